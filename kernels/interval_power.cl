// Real powers of intervals: a ** e = exp(e log a), for a >= 0 (a > 0 where e < 0), and 0 ** e = 0 for e > 0.
//
// The builtin powr is avoided: PoCL 3.1's, on packets of doubles, spoils one lane where another is zero.

// log a; ends below TINY count as zero.
static inline IA ia_log_of_base(IA a) {
  const F lo = LOWER(log(max(a.lo, (F)TINY)), R(3.0)), hi = UPPER(log(max(a.hi, (F)TINY)), R(3.0));
  return ia(SELECT(LE(a.lo, (F)TINY), -INF, lo), hi);
}

// For a constant exponent in [elo, ehi], of one sign.
static inline IA ia_pow_constant(IA a, real elo, real ehi, I* undefined, I* rough) {
  *undefined = elo > R(0.0) ? LT(a.hi, (F)0) : LE(a.hi, (F)0);
  *rough = elo > R(0.0) ? LT(a.lo, (F)0) : LE(a.lo, (F)TINY);
  return ia_exp(ia_mul(ia((F)elo, (F)ehi), ia_log_of_base(a)));
}

static inline IA ia_pow(IA a, IA b, I* undefined, I* rough) {
  *undefined = LT(a.hi, (F)0);
  *rough = LE(a.lo, (F)TINY);
  return ia_exp(ia_mul(b, ia_log_of_base(a)));
}
