// Rays given one by one: the host moved each origin to the point nearest the middle of the bounds, in double.
//
// rays: planar with the stride given: P (3), D (3), tau, length, near_out, near_in, far_out, far_in.

#define RAY_DECL __global const wide *rays, const int ray_stride
#define RAY_PASS rays, ray_stride
#define RAY_TERM(k) LOAD_WIDE(rays + (k) * ray_stride + W * column)

// The rounding of P and D, of the entry point, of the steps along the ray and of the evaluation.
#define AXIS_ERROR(p, d) fma((F)(R(4.0) * ULP), fma((F)RADIUS, fabs(d), fabs(p)), (F)POSITION_PAD)

#if IRT_SPLIT
#define SET(v, w, term) w = term, v = NARROW(w);
#else
#define SET(v, w, term) v = term;
#endif

// No t is reported before 0 where none before it counts; where some do, rounding may go a little before the first.
#define EARLIEST(ray) SELECT(LT(NARROW((ray)->tau + WIDEN((ray)->near_in)), (F)0), -INF, (F)0)

static inline RAY make_ray(RAY_DECL, __global const real* q, size_t column, size_t row) {
  RAY r;
  SET(r.px, r.wpx, RAY_TERM(0))
  SET(r.py, r.wpy, RAY_TERM(1))
  SET(r.pz, r.wpz, RAY_TERM(2))
  SET(r.dx, r.wdx, RAY_TERM(3))
  SET(r.dy, r.wdy, RAY_TERM(4))
  SET(r.dz, r.wdz, RAY_TERM(5))
  r.tau = RAY_TERM(6);
  r.length = RAY_TERM(7);
  r.near_out = NARROW(RAY_TERM(8));
  r.near_in = NARROW(RAY_TERM(9));
  r.far_out = NARROW(RAY_TERM(10));
  r.far_in = NARROW(RAY_TERM(11));
  r.ex = AXIS_ERROR(r.px, r.dx);
  r.ey = AXIS_ERROR(r.py, r.dy);
  r.ez = AXIS_ERROR(r.pz, r.dz);
  return r;
}
