// Real powers of intervals; x ** e is defined for x >= 0 (x > 0 where e < 0).

// a ** e for a constant exponent e in [elo, ehi] that is not an integer: defined for a >= 0 (a > 0 where e < 0).
// x ** e grows with e where x > 1 and falls where x < 1, so each end takes the exponent's end that is on the safe side.
static inline IA ia_pow_constant(IA a, real elo, real ehi, I* undefined, I* rough) {
  const F l = max(a.lo, (F)0), h = max(a.hi, (F)0);
  const F smaller = powr(l, SELECT(GE(l, (F)1), (F)elo, (F)ehi)), larger = powr(h, SELECT(GE(h, (F)1), (F)ehi, (F)elo));
  if (elo >= R(0.0)) {
    *undefined = LT(a.hi, (F)0);
    *rough = LT(a.lo, (F)0);
    // powr(0, e) and powr(inf, e) are exact; SELECT keeps devices that disagree from dropping the end.
    const F lo = SELECT(GT(l, (F)TINY), max(LOWER(CAP_LOWER(smaller), R(17.0)), (F)0), (F)0);
    const F hi = SELECT(GT(h, (F)TINY), UPPER(larger, R(17.0)), UPPER(powr((F)TINY, (F)elo), R(17.0)));
    return ia(lo, hi);
  }
  *undefined = LE(a.hi, (F)0);
  *rough = LE(a.lo, (F)TINY);
  const F falls_lo = powr(h, SELECT(GE(h, (F)1), (F)elo, (F)ehi)), falls_hi = powr(l, SELECT(GE(l, (F)1), (F)ehi, (F)elo));
  const F lo = SELECT(LT(h, INF), max(LOWER(CAP_LOWER(falls_lo), R(17.0)), (F)0), (F)0);
  return ia(SELECT(LE(h, (F)TINY), (F)0, lo), SELECT(LE(l, (F)TINY), INF, UPPER(falls_hi, R(17.0))));
}

// a ** b = exp(b log a) for a > 0, and 0 ** b = 0 for b > 0.
static inline IA ia_pow(IA a, IA b, I* undefined, I* rough) {
  IA log_a = ia(SELECT(LE(a.lo, (F)TINY), -INF, LOWER(log(max(a.lo, (F)TINY)), R(4.0))), UPPER(log(max(a.hi, (F)TINY)), R(4.0)));
  *undefined = LT(a.hi, (F)0);
  *rough = LE(a.lo, (F)TINY);
  const IA e = ia_mul(b, log_a);
  return ia(max(LOWER(CAP_LOWER(exp(e.lo)), R(4.0)), (F)0), UPPER(exp(e.hi), R(4.0)));
}
