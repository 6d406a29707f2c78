// Division and roots over intervals, by the rules of IEEE 1788: empty, clipped, entire.
//
// Functions that are not defined and continuous everywhere report, lane by lane,
//   undefined: nowhere defined on the interval (the result means nothing), and
//   rough: not proven defined and continuous on all of it.
#define IA_ENTIRE ia(-INF, INF)

#define DIVIDE_K R(3.5)

// Division by an interval that holds zero gives the whole line. Ends below TINY count as zero: devices may flush them.
static inline IA ia_recip(IA a, I* undefined, I* rough) {
  const I through = LE(a.lo, (F)TINY) & GE(a.hi, (F)-TINY);
  const F lo = LOWER(R(1.0) / a.hi, DIVIDE_K), hi = UPPER(R(1.0) / a.lo, DIVIDE_K);
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
  return ia(SELECT(odd, -INF, LOWER(lo, DIVIDE_K)), SELECT(odd, INF, UPPER(hi, DIVIDE_K)));
}

static inline IA ia_sqrt(IA a, I* undefined, I* rough) {
  *undefined = LT(a.hi, (F)0);
  *rough = LT(a.lo, (F)0);
  const F lo = LOWER(CAP_LOWER(sqrt(max(a.lo, (F)0))), R(4.0)), hi = UPPER(sqrt(max(a.hi, (F)0)), R(4.0));
  return ia(max(lo, (F)0), hi);
}

static inline IA ia_cbrt(IA a) { return IA_OUT(cbrt(a.lo), cbrt(a.hi), R(3.0)); }
