// Reduced affine arithmetic (S1 section 4.3, algorithm 2; the AF1 form of Messine): x + y e + z u with e, u in [-1, 1],
// z >= 0. e is the position within the piece of ray, shared by all values; z takes everything else.
//
// Deviations from S1: squares have their own, tighter rule; and with IRT_OUTWARD the rounding of x, y and z goes into z.
// The rounding of x is told apart from that of the rest, because near a root x is what limits how close a sign can be proven.
// In the comments below numbers are ulp (relative errors of ULP): a rounded step errs by a half. Products of errors are covered by
// the hundredths in what is added.

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

// A form whose x, y and z were each computed with one rounding. y: 0.5. z: 0.5, and 0.5 in each of the two steps here.
#if IRT_OUTWARD
#define ROUNDED R(0.501)  // of what is rounded once, and more than the square of that
#define RA_ROUNDED(x, y, z) ra(x, y, fma((F)(R(1.51) * ULP), fabs(y) + (z), fma((F)(ROUNDED * ULP), fabs(x), z)))
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

// Of |a||b| but |x|: y has 1; z has 1 for the rounding of both radii, 0.5 in the step that multiplies them and 0.5 in both that follow.
static inline RA ra_mul(RA a, RA b) {
  const F ra_ = ra_rad(a), rb = ra_rad(b), ax = fabs(a.x), bx = fabs(b.x);
  const F x = a.x * b.x, y = fma(a.x, b.y, b.x * a.y);
#if IRT_OUTWARD
  const F z = fma(ra_, rb, fma(ax, b.z, fma(bx, a.z, (F)TINY)));
  const F rest = fma(ax + ra_, rb, ra_ * bx);  // all of |a||b| but |x|
  return ra(x, y, fma((F)(R(2.51) * ULP), rest, fma((F)(ROUNDED * ULP), fabs(x), z)));
#else
  return ra(x, y, fma(ra_, rb, fma(ax, b.z, bx * a.z)));
#endif
}

// (x + d)^2 with |d| <= r is x^2 + 2 x d + d^2, and d^2 lies in [0, r^2]. h, which errs by 1.5, is in x and in z, where four steps follow.
static inline RA ra_sqr(RA a) {
  const F r = ra_rad(a), h = R(0.5) * r * r, two = a.x + a.x;
  const F x = fma(a.x, a.x, h), y = two * a.y;
#if IRT_OUTWARD
  const F z = fma(fabs(two), a.z, h + (F)TINY);
  return ra(x, y, fma((F)(R(5.01) * ULP), fma(fabs(two), r, h), fma((F)(ROUNDED * ULP), x, z)));
#else
  return ra(x, y, fma(fabs(two), a.z, h));
#endif
}

// c * a for a constant c >= 0 that is known to within n ulp. z is rounded four times.
static inline RA ra_scale(RA a, real c, real n) {
  const F x = c * a.x, y = c * a.y, z = c * a.z;
#if IRT_OUTWARD
  return ra(x, y, fma((F)((n + R(2.01)) * ULP), fabs(y) + z, fma((F)((n + ROUNDED) * ULP), fabs(x), z + (F)TINY)));
#else
  return ra(x, y, z);
#endif
}

// c * a + b for a constant c that is known to within n ulp. Of c * a: n. y: 0.5. z: 0.5, and 0.5 in each of the four steps here.
static inline RA ra_scale_add(RA a, real c, real n, RA b) {
  const F x = fma((F)c, a.x, b.x), y = fma((F)c, a.y, b.y), z = fma((F)fabs(c), a.z, b.z);
#if IRT_OUTWARD
  F rest = z + (F)TINY;
  if (n > R(0.0)) rest = fma((F)((n + R(0.01)) * ULP * fabs(c)), fabs(a.x) + ra_rad(a), rest);
  return ra(x, y, fma((F)(R(2.51) * ULP), fabs(y) + z, fma((F)(ROUNDED * ULP), fabs(x), rest)));
#else
  return ra(x, y, z);
#endif
}

// a + c for a constant c known to within +-error.
static inline RA ra_shift(RA a, real c, real error) {
  const F x = a.x + c;
#if IRT_OUTWARD
  const F z = a.z + error;
  return ra(x, a.y, fma((F)(R(1.51) * ULP), z, fma((F)(ROUNDED * ULP), fabs(x), z)));
#else
  return ra(x, a.y, a.z);
#endif
}

static inline IA ra_range(RA a) {
#if IRT_OUTWARD
  const F r = ra_rad(a) * (R(1.0) + R(1.0) * ULP);
#else
  const F r = ra_rad(a);
#endif
  // Before min and max could drop it, nan (infinity times zero) becomes the whole line.
  return IA_OUT(NAN_TO(a.x - r, -INF), NAN_TO(a.x + r, INF), EXACT);
}

// An interval as a form that has forgotten where in the piece it is.
static inline RA ra_from_range(IA a) {
  const F x = R(0.5) * a.lo + R(0.5) * a.hi;
#if IRT_OUTWARD
  const F z = max(a.hi - x, x - a.lo) * (R(1.0) + R(2.0) * ULP);
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
