// Exponential, logarithm and hyperbolic functions of affine forms (affine_smooth.cl). Half of a squared reach errs by 1.5 ulp: by 1 for the
// rounding of the reach; ends of ranges are bounds.

static inline RA ra_exp(RA a, IA range, IA result) {
  const F reach = ra_rad(a), v = exp(min(a.x, range.hi)), top = max(v, result.hi);
  return ra_smooth(a, reach, v, v, (F)0, R(0.5) * reach * reach * top, R(3.0), LE(a.x, range.hi), result);
}

// q errs by 3 ulp.
static inline RA ra_log(RA a, IA range, IA result) {
  const F reach = ra_rad(a), q = reach / range.lo;
  return ra_smooth(a, reach, log(max(a.x, (F)TINY)), R(1.0) / a.x, R(-0.5) * q * q, (F)0, R(3.0), GT(range.lo, (F)TINY) & WITHIN(a, range), result);
}

static inline RA ra_sinh(RA a, IA range, IA result) {
  const F reach = ra_rad(a), h = R(0.5) * reach * reach;
  return ra_smooth(a, reach, sinh(a.x), cosh(a.x), min(h * result.lo, (F)0), max(h * result.hi, (F)0), R(4.0), WITHIN(a, range), result);
}

static inline RA ra_cosh(RA a, IA range, IA result) {
  const F reach = ra_rad(a);
  return ra_smooth(a, reach, cosh(a.x), sinh(a.x), (F)0, R(0.5) * reach * reach * result.hi, R(4.0), WITHIN(a, range), result);
}

// |g'''| <= 2. g' = 1 - g^2 cancels near 1, by 10.5 ulp of g^2 at most. Where the reach is above 2e-3, |g'''| is less than 2 by more than that
// (or reach^3 / 3 by the digits of 0.3334); below it is a fiftieth of an ulp of g.
static inline RA ra_tanh(RA a, IA range, IA result) {
  const F reach = ra_rad(a), v = tanh(a.x), slope = R(1.0) - v * v, bend = -v * slope * reach * reach;
  const F rest = R(0.3334) * reach * reach * reach;
  return ra_smooth(a, reach, v, slope, min(bend, (F)0) - rest, max(bend, (F)0) + rest, R(5.03), ALL, result);
}
