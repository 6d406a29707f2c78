// Normals from the points of neighbouring pixels, and their shading (S2 section 4.3): a pass over depths already found.
//
// Deviations from S2: where both neighbours along a row or column lie on the sheet of the pixel the difference is central, not
// one-sided; and a neighbour that lies JUMP pixel widths nearer or farther lies on another sheet and is never taken. Where a
// row or column has no neighbour the gradient stands in, which is needed anyway to tell the front from the back.
//
// depths: with a border of one pixel; +inf for MISS, -inf for UNRESOLVED. steps: what P and D gain from column to column
// (6 reals) and from row to row.
typedef struct {
  F x, y, z;  // from the pixel's point to the neighbour's
  I good;     // there is one on the same sheet
} OFFSET;

// To the neighbour in the direction of `sign`, +1 or -1, which has the depth `beside`; t and s are the pixel's own.
static inline OFFSET offset_to(const RAY* ray, F t, F s, F beside, __global const real* step, real sign) {
  const F px = (F)(sign * step[0]), py = (F)(sign * step[1]), pz = (F)(sign * step[2]);
  const F dx = (F)(sign * step[3]), dy = (F)(sign * step[4]), dz = (F)(sign * step[5]);
  const F ex = ray->dx + dx, ey = ray->dy + dy, ez = ray->dz + dz;
  const F own = NARROW(ray->length), other = sqrt(fma(ex, ex, fma(ey, ey, ez * ez)));
  // s' - s = t' / |D'| - t / |D|, without cancelling: |D'|^2 - |D|^2 = (D' + D) (D' - D).
  const F gain = fma(ex + ray->dx, dx, fma(ey + ray->dy, dy, (ez + ray->dz) * dz));
  const F more = (beside - t - t * gain / (own * (own + other))) / other, at = s + more;
  const F x = fma(at, dx, px), y = fma(at, dy, py), z = fma(at, dz, pz);
  OFFSET o;
  o.x = fma(more, ray->dx, x);
  o.y = fma(more, ray->dy, y);
  o.z = fma(more, ray->dz, z);
  o.good = LT(fabs(beside), INF) & LE(fabs(beside - t), (F)JUMP * sqrt(fma(x, x, fma(y, y, z * z))));
  return o;
}

// b - a where both are good; else the good one, in the same sense.
static inline OFFSET difference(OFFSET a, OFFSET b) {
  OFFSET o;
  o.x = SELECT(b.good, b.x, (F)0) - SELECT(a.good, a.x, (F)0);
  o.y = SELECT(b.good, b.y, (F)0) - SELECT(a.good, a.y, (F)0);
  o.z = SELECT(b.good, b.z, (F)0) - SELECT(a.good, a.z, (F)0);
  o.good = a.good | b.good;
  const F scale = R(1.0) / max(max(max(fabs(o.x), fabs(o.y)), fabs(o.z)), (F)TINY);
  o.x *= scale;
  o.y *= scale;
  o.z *= scale;
  return o;
}

#define SHADE_DECL \
  RAY_DECL, __global const real *q, const int pitch, NORMAL_DECL RGB_DECL __global const real *depths, __global const real *steps PARAMETERS
#define SHADE_PASS RAY_PASS, q, pitch, NORMAL_PASS RGB_PASS depths, steps PARAMETERS_PASS

// Not inlined, as in trace.cl.
__attribute__((noinline)) void shade_packet(const size_t column, const size_t row, SHADE_DECL) {
  const size_t at = row * pitch + column * W;
  const RAY ray = make_ray(RAY_PASS, q, column, row);
  const size_t width = pitch + 2;
  __global const real* here = depths + (row + 1) * width + column * W + 1;
  const F depth = LOAD(here), less = R(1.0) / NARROW(ray.length);
  const I found = LT(fabs(depth), INF);
  const I status = SELECT(found, HIT, SELECT(LT(depth, (F)0), UNRESOLVED, MISS));
  const F t = SELECT(found, depth, (F)0), s = NARROW(WIDEN(t) / ray.length - ray.tau);
  const F vx = -ray.dx * less, vy = -ray.dy * less, vz = -ray.dz * less;
  NORMAL n = normal_at(&ray, s, found, vx, vy, vz PARAMETERS_PASS);
  if (ANY(found)) {
    const OFFSET a = difference(offset_to(&ray, t, s, LOAD(here - 1), steps, R(-1.0)), offset_to(&ray, t, s, LOAD(here + 1), steps, R(1.0)));
    const OFFSET b = difference(offset_to(&ray, t, s, LOAD(here - width), steps + 6, R(-1.0)), offset_to(&ray, t, s, LOAD(here + width), steps + 6, R(1.0)));
    const F x = fma(a.y, b.z, -a.z * b.y), y = fma(a.z, b.x, -a.x * b.z), z = fma(a.x, b.y, -a.y * b.x);
    const F square = fma(x, x, fma(y, y, z * z));
    const F unit = SELECT(GE(fma(x, vx, fma(y, vy, z * vz)), (F)0), (F)1, (F)-1) / sqrt(square);
    const I good = found & a.good & b.good & GT(square, (F)TINY);
    n.x = SELECT(good, x * unit, n.x);
    n.y = SELECT(good, y * unit, n.y);
    n.z = SELECT(good, z * unit, n.z);
  }
#if IRT_NORMAL
  STORE(TO_FLOATS(n.x), normal + at);
  STORE(TO_FLOATS(n.y), normal + (size_t)plane + at);
  STORE(TO_FLOATS(n.z), normal + 2 * (size_t)plane + at);
#endif
#if IRT_RGB
  STORE(shade(status, n.front, n.x, n.y, n.z, vx, vy, vz, background, q), rgba + at);
#endif
}

__kernel __attribute__((vec_type_hint(F))) void shade_neighbours(SHADE_DECL, const int first_column, const int first_row) {
  shade_packet(first_column + get_global_id(0), first_row + get_global_id(1), SHADE_PASS);
}
