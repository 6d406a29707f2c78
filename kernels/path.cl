// A path: the part of a ray that a root finder walks, counted in units from its start, 2^PATH_LEVELS units long.
#if IRT_DOUBLE
#define PATH_LEVELS 46
#define POWER_OF_TWO_BELOW(v) AS_F(AS_I(v) & (I)0x7ff0000000000000)
#else
#define PATH_LEVELS 22  // middles of pieces stay exact, and a unit is about what single precision resolves
#define POWER_OF_TWO_BELOW(v) AS_F(AS_I(v) & (I)0x7f800000)
#endif
#define PATH_END (((I)1) << PATH_LEVELS)

typedef struct {
  F ox, oy, oz, ux, uy, uz;  // position: o + c u, c counting units
  F ex, ey, ez;              // and its error
  F start, unit;             // s = start + c unit
  F in0, in1;                // the units between which everything counts (RANGE)
} PATH;

static inline PATH make_path(const RAY* ray, const RANGE* range) {
  PATH path;
  path.start = range->out0;
  // Long enough to reach out1 in spite of rounding.
  path.unit = (range->out1 - range->out0) * (F)((R(1.0) + R(4.0) * ULP) / (((real)1) * ((long)1 << PATH_LEVELS)));
  path.ox = fma(path.start, ray->dx, ray->px);
  path.oy = fma(path.start, ray->dy, ray->py);
  path.oz = fma(path.start, ray->dz, ray->pz);
  path.ux = path.unit * ray->dx;
  path.uy = path.unit * ray->dy;
  path.uz = path.unit * ray->dz;
  path.ex = ray->ex;
  path.ey = ray->ey;
  path.ez = ray->ez;
  const F inverse = R(1.0) / path.unit;
  path.in0 = fma(range->in0 - path.start, inverse, (F)R(0.5));
  path.in1 = fma(range->in1 - path.start, inverse, (F)R(-0.5));
  return path;
}
