// Exponential, logarithm and hyperbolic functions of affine forms (affine_smooth.cl).

static inline RA ra_exp(RA a, IA range, IA result) {
  const F reach = ra_reach(a), v = exp(a.x), top = max(v, result.hi);
  return ra_smooth(a, reach, v, v, (F)0, R(0.5) * reach * reach * top, R(10.0), ALL, result);
}

static inline RA ra_log(RA a, IA range, IA result) {
  const F reach = ra_reach(a), q = reach / range.lo;
  return ra_smooth(a, reach, log(max(a.x, (F)TINY)), R(1.0) / a.x, R(-0.5) * q * q, (F)0, R(12.0), GT(range.lo, (F)TINY) & WITHIN(a, range), result);
}

static inline RA ra_sinh(RA a, IA range, IA result) {
  const F reach = ra_reach(a), h = R(0.5) * reach * reach;
  return ra_smooth(a, reach, sinh(a.x), cosh(a.x), min(h * result.lo, (F)0), max(h * result.hi, (F)0), R(11.0), WITHIN(a, range), result);
}

static inline RA ra_cosh(RA a, IA range, IA result) {
  const F reach = ra_reach(a);
  return ra_smooth(a, reach, cosh(a.x), sinh(a.x), (F)0, R(0.5) * reach * reach * result.hi, R(11.0), WITHIN(a, range), result);
}

// g' = 1 - g^2 cancels near 1, by 12 ulp of 1 at most; |g'''| <= 2.
static inline RA ra_tanh(RA a, IA range, IA result) {
  const F reach = ra_reach(a), v = tanh(a.x), slope = R(1.0) - v * v, bend = -v * slope * reach * reach;
  const F rest = reach * fma(reach * reach, (F)R(0.3334), (F)(R(32.0) * ULP));
  return ra_smooth(a, reach, v, slope, min(bend, (F)0) - rest, max(bend, (F)0) + rest, R(20.0), ALL, result);
}
