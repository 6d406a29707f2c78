// What enclosures of f tell: a proven sign, or that they are infinite.
#if FORM_IS_RANGE
static inline I positive(FORM f) { return GT(f.lo, (F)0); }
static inline I negative(FORM f) { return LT(f.hi, (F)0); }
static inline I unbounded(FORM f) { return ~(GT(f.lo, -INF) & LT(f.hi, INF)); }
static inline I nonzero(FORM f) { return GT(f.lo, (F)0) | LT(f.hi, (F)0); }
static inline F leaning(FORM f) { return SELECT(GT(f.lo, (F)0), (F)1, (F)-1); }  // of a proven sign
static inline IA form_range(FORM f) { return f; }
static inline F form_middle(FORM f) { return R(0.5) * (f.lo + f.hi); }
#define BEFORE(f) ((F)0)
#define BEHIND(f) ((F)0)
static inline I crosses(FORM f) { return NONE; }
#else
#if IRT_OUTWARD
#define CERTAIN(v) ((v) * (R(1.0) - R(3.0) * ULP))  // covers the rounding of |y| + z
#else
#define CERTAIN(v) (v)
#endif
static inline I positive(FORM f) { return GT(CERTAIN(f.x), ra_rad(f)); }
static inline I negative(FORM f) { return LT(CERTAIN(f.x), -ra_rad(f)); }
static inline I unbounded(FORM f) { return ~LT(fabs(f.x) + ra_rad(f), INF); }
static inline I nonzero(FORM f) { return GT(CERTAIN(fabs(f.x)), ra_rad(f)); }
static inline F leaning(FORM f) { return copysign((F)1, f.x); }
static inline IA form_range(FORM f) { return ra_range(f); }
static inline F form_middle(FORM f) { return f.x; }
// The signs of the middle of the form at the start and at the end of the piece: 1 or -1, because products of values could underflow.
#define BEFORE(f) copysign((F)1, (f).x - (f).y)
#define BEHIND(f) copysign((F)1, (f).x + (f).y)
// The signs at the ends of the piece are opposite: at e = -1 and 1 the form is x - y and x + y, to within z.
static inline I crosses(FORM f) { return GT(CERTAIN(fabs(f.y)), fabs(f.x) + f.z); }
#endif
