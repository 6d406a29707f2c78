// A path: the part of a ray that a root finder walks, counted in units from its start, 2^PATH_LEVELS units long.
#if IRT_DOUBLE
#define PATH_LEVELS 46
#define WHOLE_SHIFT 0x1.8p52
#else
#define PATH_LEVELS 22  // middles of pieces stay exact, and a unit is about what single precision resolves
#define WHOLE_SHIFT 0x1.8p23f
#endif
#define PATH_END (((I)1) << PATH_LEVELS)
#define WHOLE(v) (((v) + WHOLE_SHIFT) - WHOLE_SHIFT)  // the nearest integer, for |v| up to PATH_END
#define PATH_END_REAL (((real)1) * ((long)1 << PATH_LEVELS))

// Units that the ends of what counts go inward: a difference, a quotient and a sum of up to 2^22 units may be off by 0.25 + 1.25 + 0.125 in single precision.
#define INWARD R(1.75)

typedef struct {
  F ox, oy, oz, ux, uy, uz;  // position: o + c u, c counting units
#if IRT_SPLIT
  F lox, loy, loz, lux, luy, luz;  // what rounding o and u to F left over
#endif
  F ex, ey, ez;  // and its error
#if IRT_SLACK
  F bx, by, bz;  // and the error without lo and lu, rounding of a piece's slope included
#endif
#if IRT_BEAMS
  F gx, gy, gz;  // which grows so much with each unit
#endif
  F start, unit;  // s = start + c unit
  F in0, in1;     // the units between which everything counts (RANGE)
} PATH;

// The coordinate after c units. With the left-overs only the last two roundings err: by an ulp of the coordinate. An interval's ends are rounded once more.
#if IRT_SPLIT
#if IRT_AFFINE
#define ALONG_ERROR R(1.05)  // ulp
#else
#define ALONG_ERROR R(1.55)
#endif
#define ALONG(path, axis, c) (fma(c, path->u##axis, path->o##axis) + fma(c, path->lu##axis, path->lo##axis))
#define PATH_AXIS(axis, k) \
  { \
    const FW o = fma(WIDEN(path.start), ray->wd##axis, ray->wp##axis), u = WIDEN(path.unit) * ray->wd##axis; \
    path.o##axis = NARROW(o); \
    path.lo##axis = NARROW(o - WIDEN(path.o##axis)); \
    path.u##axis = NARROW(u); \
    path.lu##axis = NARROW(u - WIDEN(path.u##axis)); \
    path.e##axis = fma((F)(ALONG_ERROR * ULP), max((F)fabs(BOX_LO(k)), (F)fabs(BOX_HI(k))) + ray->e##axis, (F)POSITION_PAD); \
  }
#else
#define ALONG(path, axis, c) fma(c, path->u##axis, path->o##axis)
#define PATH_AXIS(axis, k) \
  { \
    path.o##axis = fma(path.start, ray->d##axis, ray->p##axis); \
    path.u##axis = path.unit * ray->d##axis; \
    path.e##axis = ray->e##axis; \
  }
#endif

// What the left-overs may add. The error has room for the rounding of a coordinate and of a slope, which here takes the place of that of two sums,
// and for that of this sum, whose second part is small.
#if IRT_SPLIT
#define PATH_BARE(axis) path.b##axis = path.e##axis + fma(TO_F(PATH_END), fabs(path.lu##axis), fabs(path.lo##axis));
#else
#define PATH_BARE(axis) path.b##axis = path.e##axis;
#endif

#if IRT_BEAMS
#define PATH_SPREAD(axis) \
  path.g##axis = path.unit * ray->w##axis; \
  path.e##axis = (IRT_OUTWARD ? path.e##axis : (F)0) + fma(max(NARROW(ray->tau) + path.start + reach, (F)0), ray->w##axis, ray->b##axis) * (R(1.0) + R(8.0) * ULP);
#define ERROR_UNTIL(path, axis, c) fma(c, path->g##axis, path->e##axis)
#else
#define ERROR_UNTIL(path, axis, c) (IRT_OUTWARD ? path->e##axis : (F)0)
#endif

static inline PATH make_path(const RAY* ray, const RANGE* range, __global const real* q) {
  PATH path;
  path.start = range->out0;
  // Long enough to reach out1 in spite of rounding.
  path.unit = (range->out1 - range->out0) * (F)((R(1.0) + R(4.0) * ULP) / (PATH_END_REAL));
  PATH_AXIS(x, 0)
  PATH_AXIS(y, 1)
  PATH_AXIS(z, 2)
#if IRT_SLACK
  PATH_BARE(x)
  PATH_BARE(y)
  PATH_BARE(z)
#endif
#if IRT_BEAMS
  const F reach = (F)(R(4.0) * ULP) * (fabs(NARROW(ray->tau)) + (F)RADIUS);
  PATH_SPREAD(x)
  PATH_SPREAD(y)
  PATH_SPREAD(z)
#endif
  const F inverse = R(1.0) / path.unit;
  path.in0 = fma(range->in0 - path.start, inverse, (F)INWARD);
  path.in1 = fma(range->in1 - path.start, inverse, (F)-INWARD);
  return path;
}

#if IRT_SPLIT
#define REPORT_ERROR DEPTH_ERROR
#else
#define REPORT_ERROR (DEPTH_ERROR + R(1.0))  // and of the place
#endif

// eps in units of the path, less what is added to so many when they are reported: by the rounding of t, as far as there is room in eps, and of this.
static inline F wanted_units(const RAY* ray, const PATH* path, __global const real* q) {
  const F length = NARROW(ray->length), far = (fabs(NARROW(ray->tau)) + (F)RADIUS) * length;
  const F off = R(2.0) * fma((F)(REPORT_ERROR * ULP), far, (F)POSITION_PAD);
  return ((F)FIRST_EPS - min(off, (F)(R(0.125) * FIRST_EPS))) / (length * path->unit) * (R(1.0) - R(12.0) * ULP);
}

// What is known of the units [lo, hi], as a result.
static inline ROOT report(const PATH* path, __global const real* q, I status, F lo, F hi) {
  ROOT root;
  const F c = SELECT(EQ(status, HIT) | EQ(status, TOUCH), R(0.5) * (lo + hi), lo);
  root.status = status;
  root.at = fma(WIDEN(c), WIDEN(path->unit), WIDEN(path->start));
  root.half_width = max(hi - c, c - lo) * path->unit * (R(1.0) + R(4.0) * ULP);
#if !IRT_SPLIT
  root.half_width += ULP * (F)RADIUS;  // the rounding of `at`
#endif
  return root;
}

// Pieces that each lane has looked at, where the call asks for them.
#if IRT_PIECES
#define COUNT_FROM_HERE I looked = NONE;
#define COUNT(lanes) looked -= (lanes);
#define REPORT_COUNT root.pieces = looked;
#else
#define COUNT_FROM_HERE
#define COUNT(lanes)
#define REPORT_COUNT
#endif
