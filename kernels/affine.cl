// Reduced affine arithmetic (S1 section 4.3, algorithm 2; the AF1 form of Messine): x + y e + z u with e, u in [-1, 1],
// z >= 0. e is the position within the piece of ray, shared by all values; z takes everything else.
//
// Deviations from S1: squares have their own, tighter rule; and with IRT_OUTWARD the rounding of x, y and z goes into z.
// In the bounds below A = |x| + |y| + z is the largest magnitude of a form and the rounding of x is told apart from that
// of the rest, because near a root x is what limits how close a sign can be proven.

typedef struct {
  F x, y, z;
} RA;

static inline RA ra(F x, F y, F z) {
  RA r;
  r.x = x;
  r.y = y;
  r.z = z;
  return r;
}

static inline F ra_rad(RA a) { return fabs(a.y) + a.z; }

// How far from x the values of a form may lie.
static inline F ra_reach(RA a) {
#if IRT_OUTWARD
  return ra_rad(a) * (R(1.0) + R(4.0) * ULP) + (F)ULP * fabs(a.x);
#else
  return ra_rad(a);
#endif
}

// A form whose x, y and z were each computed with one rounding: half an ulp of each, half an ulp of the sum itself.
#if IRT_OUTWARD
#define RA_ROUNDED(x, y, z) ra(x, y, fma((F)(R(1.5) * ULP), fabs(x) + fabs(y) + (z), z))
#else
#define RA_ROUNDED(x, y, z) ra(x, y, z)
#endif

static inline RA ra_neg(RA a) { return ra(-a.x, -a.y, a.z); }

static inline RA ra_add(RA a, RA b) {
  const F x = a.x + b.x, y = a.y + b.y, z = a.z + b.z;
  return RA_ROUNDED(x, y, z);
}

static inline RA ra_sub(RA a, RA b) {
  const F x = a.x - b.x, y = a.y - b.y, z = a.z + b.z;
  return RA_ROUNDED(x, y, z);
}

static inline RA ra_mul(RA a, RA b) {
  const F ra_ = ra_rad(a), rb = ra_rad(b), ax = fabs(a.x), bx = fabs(b.x);
  const F x = a.x * b.x, y = fma(a.x, b.y, b.x * a.y);
#if IRT_OUTWARD
  const F z = fma(ra_, rb, fma(ax, b.z, fma(bx, a.z, (F)TINY)));
  const F rest = fma(ax + ra_, rb, ra_ * bx);  // all of |a||b| but |x|
  return ra(x, y, fma((F)(R(6.0) * ULP), rest, fma((F)ULP, fabs(x), z)));
#else
  return ra(x, y, fma(ra_, rb, fma(ax, b.z, bx * a.z)));
#endif
}

// (x + d)^2 with |d| <= r is x^2 + 2 x d + d^2, and d^2 lies in [0, r^2].
static inline RA ra_sqr(RA a) {
  const F r = ra_rad(a), h = R(0.5) * r * r, two = a.x + a.x;
  const F x = fma(a.x, a.x, h), y = two * a.y;
#if IRT_OUTWARD
  const F z = fma(fabs(two), a.z, h + (F)TINY);
  return ra(x, y, fma((F)(R(6.0) * ULP), fma(fabs(two), r, h), fma((F)ULP, x, z)));
#else
  return ra(x, y, fma(fabs(two), a.z, h));
#endif
}

// c * a for a constant c >= 0 that is known to within k ulp.
static inline RA ra_scale(RA a, real c, real k) {
  const F x = c * a.x, y = c * a.y, z = c * a.z;
#if IRT_OUTWARD
  return ra(x, y, fma((F)(k * ULP), fabs(x) + fabs(y) + z, z + (F)TINY));
#else
  return ra(x, y, z);
#endif
}

// a + c for a constant c known to within +-error.
static inline RA ra_shift(RA a, real c, real error) {
  const F x = a.x + c;
#if IRT_OUTWARD
  return ra(x, a.y, fma((F)(R(1.5) * ULP), fabs(x) + a.z, a.z + error));
#else
  return ra(x, a.y, a.z);
#endif
}

static inline IA ra_range(RA a) {
#if IRT_OUTWARD
  const F r = ra_rad(a) * (R(1.0) + R(2.0) * ULP);
#else
  const F r = ra_rad(a);
#endif
  // Before min and max could drop it, nan (infinity times zero) becomes the whole line.
  return IA_OUT(NAN_TO(a.x - r, -INF), NAN_TO(a.x + r, INF), EXACT_K);
}

// An interval as a form that has forgotten where in the piece it is.
static inline RA ra_from_range(IA a) {
  const F x = R(0.5) * a.lo + R(0.5) * a.hi;
#if IRT_OUTWARD
  const F z = max(a.hi - x, x - a.lo) * (R(1.0) + R(2.0) * ULP) + (F)TINY;
#else
  const F z = max(a.hi - x, x - a.lo);
#endif
#if IRT_INFINITE
  const I wild = ~LT(fabs(x), INF) | ~LT(z, INF);
  return ra(SELECT(wild, (F)0, x), (F)0, SELECT(wild, INF, z));
#else
  return ra(x, (F)0, z);
#endif
}
