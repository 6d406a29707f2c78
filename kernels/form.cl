// What enclosures of f tell: a proven sign, or that they are infinite.
#if FORM_IS_RANGE
static inline I positive(FORM f) { return GT(f.lo, (F)0); }
static inline I negative(FORM f) { return LT(f.hi, (F)0); }
static inline I unbounded(FORM f) { return ~(GT(f.lo, -INF) & LT(f.hi, INF)); }
#else
#if IRT_OUTWARD
#define CERTAIN(v) ((v) * (R(1.0) - R(3.0) * ULP))  // covers the rounding of |y| + z
#else
#define CERTAIN(v) (v)
#endif
static inline I positive(FORM f) { return GT(CERTAIN(f.x), ra_rad(f)); }
static inline I negative(FORM f) { return LT(CERTAIN(f.x), -ra_rad(f)); }
static inline I unbounded(FORM f) { return ~LT(fabs(f.x) + ra_rad(f), INF); }
#endif
