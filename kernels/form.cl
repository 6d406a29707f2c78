// What enclosures of f tell: a proven sign, or that they are infinite.
#if FORM_HAS_RANGE
static inline I positive(FORM f) { return GT(f.lo, (F)0); }
static inline I negative(FORM f) { return LT(f.hi, (F)0); }
static inline I unbounded(FORM f) { return ~(GT(f.lo, -INF) & LT(f.hi, INF)); }
static inline I nonzero(FORM f) { return GT(f.lo, (F)0) | LT(f.hi, (F)0); }
static inline F leaning(FORM f) { return SELECT(GT(f.lo, (F)0), (F)1, (F)-1); }  // of a proven sign
static inline IA form_range(FORM f) { return ia(f.lo, f.hi); }
static inline F form_middle(FORM f) { return R(0.5) * (f.lo + f.hi); }
#endif

#if FORM_IS_RANGE
#define BEFORE(f) ((F)0)
#define BEHIND(f) ((F)0)
static inline I crosses(FORM f) { return NONE; }
#else
// No pad covers the rounding of |y| + z: what is above the real that it rounds to is above the sum.
#if !FORM_HAS_RANGE
static inline I positive(FORM f) { return GT(f.x, ra_rad(f)); }
static inline I negative(FORM f) { return LT(f.x, -ra_rad(f)); }
static inline I unbounded(FORM f) { return ~LT(fabs(f.x) + ra_rad(f), INF); }
static inline I nonzero(FORM f) { return GT(fabs(f.x), ra_rad(f)); }
static inline F leaning(FORM f) { return copysign((F)1, f.x); }
static inline IA form_range(FORM f) { return ra_range(f); }
static inline F form_middle(FORM f) { return f.x; }
#endif
// The signs of the middle of the form at the start and at the end of the piece: 1 or -1, because products of values could underflow.
#define BEFORE(f) copysign((F)1, (f).x - (f).y)
#define BEHIND(f) copysign((F)1, (f).x + (f).y)
// The signs at the ends of the piece are opposite: at e = -1 and 1 the form is x - y and x + y, to within z.
static inline I crosses(FORM f) { return GT(fabs(f.y), fabs(f.x) + f.z); }
#endif

#if IRT_SLACK
// Enclosures without pads, by the functions of assemble.cpp whose names begin with bare_.
#if IRT_AFFINE
typedef bare_RA BARE_COORDINATE;
static inline F size_of(bare_RA a) { return fabs(a.x) + bare_ra_rad(a); }
#define BARE_FORMULA bare_irt_affine
#else
typedef bare_IA BARE_COORDINATE;
static inline F size_of(bare_IA a) { return max(-a.lo, a.hi); }
#define BARE_FORMULA bare_irt_interval
#endif

typedef struct {
  bare_FORM form;
  F off;     // how far from zero it ends; below zero where it holds it
  F radius;  // half its width
  F side;    // its sign, where it has one
  F slack;   // how far rounding may have moved its ends
} BARE;

static inline BARE bare(BARE_COORDINATE x, BARE_COORDINATE y, BARE_COORDINATE z PARAMETERS) {
  BARE r;
  I undefined, rough;  // neither, or there would be no slack
  r.form = BARE_FORMULA(x, y, z PARAMETERS_PASS, &undefined, &rough);
  r.slack = irt_slack(size_of(x), size_of(y), size_of(z) PARAMETERS_PASS);
#if FORM_IS_RANGE
  r.off = max(r.form.lo, -r.form.hi);
  r.radius = R(0.5) * (r.form.hi - r.form.lo);
  r.side = r.form.lo;
#else
  r.radius = bare_ra_rad(r.form);
  r.off = fabs(r.form.x) - r.radius;
  r.side = r.form.x;
#endif
  return r;
}

static inline IA bare_range(BARE f) {
#if FORM_IS_RANGE
  return ia(f.form.lo - f.slack, f.form.hi + f.slack);
#else
  return ia(f.form.x - (f.radius + f.slack), f.form.x + (f.radius + f.slack));
#endif
}
#endif
