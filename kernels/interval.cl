// Interval arithmetic (S1 section 4.2, algorithm 1): sums, products, squares, reciprocals of the whole line.
//
// Deviations from S1: every end is rounded outward (IRT_OUTWARD), and `min`/`max` take the place of their NaN-aware
// cousins, with NaN excluded beforehand (IRT_INFINITE).

typedef struct {
  F lo, hi;
} IA;

static inline IA ia(F lo, F hi) {
  IA r;
  r.lo = lo;
  r.hi = hi;
  return r;
}

// Rounds two computed ends outward by n ulp.
#define IA_OUT(l, h, n) ia(LOWER(CAP_LOWER(l), n), UPPER(CAP_UPPER(h), n))

static inline IA ia_neg(IA a) { return ia(-a.hi, -a.lo); }

static inline IA ia_add(IA a, IA b) { return IA_OUT(a.lo + b.lo, a.hi + b.hi, EXACT); }

static inline IA ia_sub(IA a, IA b) { return IA_OUT(a.lo - b.hi, a.hi - b.lo, EXACT); }

static inline IA ia_mul(IA a, IA b) {
  const F p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
#if IRT_INFINITE
  const F nan = p + q + r + s;  // nan where any of the four is, or where they have opposite infinities
  const I odd = ~EQ(nan, nan);
  const F lo = SELECT(odd, -INF, min(min(p, q), min(r, s))), hi = SELECT(odd, INF, max(max(p, q), max(r, s)));
#else
  const F lo = min(min(p, q), min(r, s)), hi = max(max(p, q), max(r, s));
#endif
  return IA_OUT(lo, hi, EXACT);
}

// Of what is never negative: a form of it may reach below zero, where rules for such values are wrong.
static inline IA ia_nonnegative(IA a) { return ia(max(a.lo, (F)0), a.hi); }

// Both factors are never negative, though their ranges may be where one goes through a pole.
static inline IA ia_mul_nonnegative(IA a, IA b) {
  const F lo = NAN_TO(max(a.lo, (F)0) * max(b.lo, (F)0), (F)0), hi = NAN_TO(a.hi * b.hi, INF);
  return ia(max(LOWER(CAP_LOWER(lo), EXACT), (F)0), UPPER(hi, EXACT));
}

// The range of a * a; never negative (the even-power rule of S1 section 4.2).
static inline IA ia_sqr(IA a) {
  const F p = a.lo * a.lo, q = a.hi * a.hi;
  const F lo = SELECT(LE(a.lo, (F)0) & GE(a.hi, (F)0), (F)0, min(p, q));
  return ia(max(LOWER(CAP_LOWER(lo), EXACT), (F)0), UPPER(max(p, q), EXACT));
}

// c * a for a constant c >= 0: n is EXACT where c is a real, and an ulp of c and half an ulp for a sum of errors more where it is not.
static inline IA ia_scale(IA a, real c, real n) { return IA_OUT(c * a.lo, c * a.hi, n); }

// a + [lo, hi] for a constant.
static inline IA ia_shift(IA a, real lo, real hi) { return IA_OUT(a.lo + lo, a.hi + hi, EXACT); }

static inline IA ia_abs(IA a) {
  const I through = LE(a.lo, (F)0) & GE(a.hi, (F)0);
  const F p = fabs(a.lo), q = fabs(a.hi);
  return ia(SELECT(through, (F)0, min(p, q)), max(p, q));
}

// Two ranges of the same values.
static inline IA ia_meet(IA a, IA b) { return ia(max(a.lo, b.lo), min(a.hi, b.hi)); }

static inline IA ia_min(IA a, IA b) { return ia(min(a.lo, b.lo), min(a.hi, b.hi)); }

static inline IA ia_max(IA a, IA b) { return ia(max(a.lo, b.lo), max(a.hi, b.hi)); }

// a ** n by a generated chain of products `power`. A chain for a ** n loses at most n - 1 roundings, and underflow on the
// way is underflow of the result; k = n / 2. Even powers depend on |a| alone (S1 4.2).
#define IA_POWER_EVEN(a, power, k) ia_power_even(power(ia_abs(a).lo), power(ia_abs(a).hi), k)
#define IA_POWER_ODD(a, power, k) IA_OUT(power((a).lo), power((a).hi), k)

static inline IA ia_power_even(F lo, F hi, real k) {
  return ia(max(LOWER(CAP_LOWER(lo), k), (F)0), UPPER(hi, k));
}
