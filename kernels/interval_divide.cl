// Division and roots over intervals, by the rules of IEEE 1788: empty, clipped, entire.
//
// Functions that are not defined and continuous everywhere report, lane by lane,
//   undefined: nowhere defined on the interval (the result means nothing), and
//   rough: not proven defined and continuous on all of it.
#define IA_ENTIRE ia(-INF, INF)

#define QUOTIENT R(2.5)  // ulp of a quotient in single precision

// Division by an interval that holds zero gives the whole line. Ends below TINY count as zero: devices may flush them.
static inline IA ia_recip(IA a, I* undefined, I* rough) {
  const I through = LE(a.lo, (F)TINY) & GE(a.hi, (F)-TINY);
  const F lo = LOWER(R(1.0) / a.hi, QUOTIENT), hi = UPPER(R(1.0) / a.lo, QUOTIENT);
  *undefined = EQ(a.lo, (F)0) & EQ(a.hi, (F)0);
  *rough = through;
  return ia(SELECT(through, -INF, lo), SELECT(through, INF, hi));
}

static inline IA ia_div(IA a, IA b, I* undefined, I* rough) {
  const I through = LE(b.lo, (F)TINY) & GE(b.hi, (F)-TINY);
  const F p = a.lo / b.lo, q = a.lo / b.hi, r = a.hi / b.lo, s = a.hi / b.hi;
  const F any_nan = p + q + r + s;
  const I odd = through | ~EQ(any_nan, any_nan);
  *undefined = EQ(b.lo, (F)0) & EQ(b.hi, (F)0);
  *rough = through;
  const F lo = CAP_LOWER(min(min(p, q), min(r, s))), hi = CAP_UPPER(max(max(p, q), max(r, s)));
  return ia(SELECT(odd, -INF, LOWER(lo, QUOTIENT)), SELECT(odd, INF, UPPER(hi, QUOTIENT)));
}

static inline IA ia_sqrt(IA a, I* undefined, I* rough) {
  *undefined = LT(a.hi, (F)0);
  *rough = LT(a.lo, (F)0);
  const F lo = LOWER(CAP_LOWER(sqrt(max(a.lo, (F)0))), R(3.0)), hi = UPPER(sqrt(max(a.hi, (F)0)), R(3.0));
  return ia(max(lo, (F)0), hi);
}

static inline IA ia_cbrt(IA a) { return IA_OUT(cbrt(a.lo), cbrt(a.hi), R(2.0)); }
