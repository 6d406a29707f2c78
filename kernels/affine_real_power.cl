// Real powers of affine forms: a ** e for a constant e, by Taylor's theorem (affine_smooth.cl); a ** b as exp(b log a).

// The value at the middle carries the error that interval_power.cl proves for it, 3 ulp at least. A fifth more of it covers half an ulp of v; times
// over^2 it covers what e - 1 loses where e is near 1. The slope errs by 4.5 ulp, q by 13.
static inline RA ra_pow_constant(RA a, IA range, IA result, real elo, real ehi) {
  I undefined, rough;
  const IA at = ia_pow_constant(ia(a.x, a.x), elo, ehi, &undefined, &rough);
  const F reach = ra_rad(a), v = R(0.5) * (at.lo + at.hi), off = R(0.5) * (at.hi - at.lo), over = reach / range.lo;
  const real e = R(0.5) * (elo + ehi), second = R(0.5) * e * (e - R(1.0));
  const F slope = e * (v / a.x), q = second * max(at.hi, result.hi) * over * over, rest = off * fma(fabs((F)e) * over, R(1.0) + over, (F)1) * R(1.2);
  return ra_smooth(a, reach, v, slope, min(q, (F)0) - rest, max(q, (F)0) + rest, R(0.0), GT(range.lo, (F)TINY) & WITHIN(a, range), result);
}

static inline RA ra_pow(RA a, RA b, IA a_range, IA b_range, IA result) {
  const RA l = ra_log(a, a_range, ia_log_of_base(a_range)), power = ra_exp(ra_mul(b, l), b_range, result), box = ra_from_range(result);
  const I better = GT(a_range.lo, (F)TINY) & LT(power.z, INF);
  return RA_PICK(better, power, box);
}
