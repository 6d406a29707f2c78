// The part of a ray inside the bounds: a box, IRT_SPHERES balls and IRT_HALF_SPACES half-spaces. Every comparison is made twice, so that rounding can
// neither hide a root just inside the bounds nor show one just outside.

// How much of a ray goes with a coordinate, and with its error, whose derivative is d. A coordinate that stays within its error is taken for very fast, so that
// its planes are passed far from here or not at all; it has that error twice.
static inline F pace_of(F d, I parallel) { return SELECT(parallel, (F)MODEST, R(1.0) / d); }
static inline F pace_of_error(F pace, I parallel) { return SELECT(parallel, (F)(R(2.0) * MODEST), fabs(pace)); }

// Between the planes lo and hi of one axis; e bounds the error of a coordinate anywhere on the ray.
static inline void clip_axis(RANGE* range, F p, F d, F e, F lo, F hi, F radius) {
  const I parallel = LE(fabs(d) * radius, e);
  const F pace = pace_of(d, parallel), a = (lo - p) * pace, b = (hi - p) * pace;
  const F enter = min(a, b), leave = max(a, b);
  const F pad = fma(e + ULP * (fabs(lo) + fabs(hi)), pace_of_error(pace, parallel), fma((F)(R(8.0) * ULP), fabs(a) + fabs(b), SELECT(parallel, radius + radius, (F)0)));
  range->out0 = max(range->out0, enter - pad);
  range->out1 = min(range->out1, leave + pad);
  range->in0 = max(range->in0, enter + pad);
  range->in1 = min(range->in1, leave - pad);
}

#if IRT_SPHERES
// |P + s D - c|^2 <= r^2. An error of the position is an error of the radius; the rounding of the quadratic's coefficients is one of its
// discriminant: at most 9 ulp of each of its terms. What is left of 20 moves the ends, by half of that of (middle^2 / width + width), farther
// than the root and the quotients may have.
static inline void clip_sphere(RANGE* range, const RAY* ray, F cx, F cy, F cz, F radius) {
  const F x = ray->px - cx, y = ray->py - cy, z = ray->pz - cz;
  const F a = fma(ray->dx, ray->dx, fma(ray->dy, ray->dy, ray->dz * ray->dz));
  const F b = fma(ray->dx, x, fma(ray->dy, y, ray->dz * z));
  const F square = fma(x, x, fma(y, y, z * z));
  const F slack = ray->ex + ray->ey + ray->ez + R(2.0) * ULP * (fabs(cx) + fabs(cy) + fabs(cz) + radius);
  const F outer = radius + slack, inner = max(radius - slack, (F)0);
  const F error = R(20.0) * ULP * fma(b, b, a * (square + outer * outer));
  const F open = fma(b, b, -a * (square - outer * outer)) + error, sure = fma(b, b, -a * (square - inner * inner)) - error;
  const F inverse = R(1.0) / a, middle = -b * inverse, wide = sqrt(max(open, (F)0)) * inverse, narrow = sqrt(max(sure, (F)0)) * inverse;
  const I maybe = GE(open, (F)0), surely = GT(sure, (F)0);
  range->out0 = max(range->out0, SELECT(maybe, middle - wide, INF));
  range->out1 = min(range->out1, SELECT(maybe, middle + wide, -INF));
  range->in0 = max(range->in0, SELECT(surely, middle - narrow, INF));
  range->in1 = min(range->in1, SELECT(surely, middle + narrow, -INF));
}
#endif

#if IRT_HALF_SPACES
// n . (P + s D) <= offset. Of an error of the coordinates, which is 4 ulp of what they are made of or more (make_ray), the rounding of n and of the sums of
// products adds a half, and that of the quotient nearly one. That of an offset that a ray can reach is less than what is left.
static inline void clip_half_space(RANGE* range, const RAY* ray, F nx, F ny, F nz, F offset, F radius) {
  const F p = fma(nx, ray->px, fma(ny, ray->py, nz * ray->pz)), d = fma(nx, ray->dx, fma(ny, ray->dy, nz * ray->dz));
  const F e = R(2.5) * fma(fabs(nx), ray->ex, fma(fabs(ny), ray->ey, fabs(nz) * ray->ez));
  const I parallel = LE(fabs(d) * radius, e), leaving = GT(d, (F)0) | parallel;
  const F pace = pace_of(d, parallel), at = (offset - p) * pace, pad = fma(e, pace_of_error(pace, parallel), SELECT(parallel, radius + radius, (F)0));
  range->out0 = max(range->out0, SELECT(leaving, -INF, at - pad));
  range->out1 = min(range->out1, SELECT(leaving, at + pad, INF));
  range->in0 = max(range->in0, SELECT(leaving, -INF, at + pad));
  range->in1 = min(range->in1, SELECT(leaving, at - pad, INF));
}
#endif

static inline RANGE clip_ray(const RAY* ray, __global const real* q) {
  RANGE range;
  range.out0 = ray->near_out;
  range.out1 = ray->far_out;
  range.in0 = ray->near_in;
  range.in1 = ray->far_in;
  if (BOXED != 0) {
    // Where coordinates err by as much as the box is wide (boxes far from the origin, beams) no plane cuts the ray.
    const F most = (F)(R(2.0) * RADIUS);
    range.out0 = max(range.out0, -most);
    range.out1 = min(range.out1, most);
    clip_axis(&range, ray->px, ray->dx, ray->ex, (F)BOX_LO(0), (F)BOX_HI(0), (F)RADIUS);
    clip_axis(&range, ray->py, ray->dy, ray->ey, (F)BOX_LO(1), (F)BOX_HI(1), (F)RADIUS);
    clip_axis(&range, ray->pz, ray->dz, ray->ez, (F)BOX_LO(2), (F)BOX_HI(2), (F)RADIUS);
  }
#if IRT_SPHERES
  for (int i = 0; i < IRT_SPHERES; ++i)
    clip_sphere(&range, ray, (F)SPHERE(i, 0), (F)SPHERE(i, 1), (F)SPHERE(i, 2), (F)SPHERE(i, 3));
#endif
#if IRT_HALF_SPACES
  for (int i = 0; i < IRT_HALF_SPACES; ++i)
    clip_half_space(&range, ray, (F)HALF_SPACE(i, 0), (F)HALF_SPACE(i, 1), (F)HALF_SPACE(i, 2), (F)HALF_SPACE(i, 3), (F)RADIUS);
#endif
  return range;
}
