// Reciprocals, quotients and roots of affine forms (affine_smooth.cl). Their remainders have closed forms.

#define SQUARES_STAY_NORMAL(x) (LT(fabs(x), (F)MODEST) & GT(fabs(x), (F)(R(1.0) / MODEST)))

// 1 / (x + d) - (1 / x - d / x^2) = d^2 / (x^2 (x + d)). The slope errs by 5.5 ulp, q by 10.
static inline RA ra_recip(RA a, IA range, IA result) {
  const F reach = ra_rad(a), v = R(1.0) / a.x, near = min(fabs(range.lo), fabs(range.hi)), q = v * v * reach * (reach / near);
  const I apart = GT(range.lo, (F)TINY) | LT(range.hi, (F)-TINY), above = GT(a.x, (F)0);
  return ra_smooth(a, reach, v, -v * v, SELECT(above, (F)0, -q), SELECT(above, q, (F)0), R(2.5), apart & SQUARES_STAY_NORMAL(a.x) & WITHIN(a, range), result);
}

static inline RA ra_div(RA a, RA b, IA a_range, IA b_range, IA result) {
  I undefined, rough;
  const RA product = ra_mul(a, ra_recip(b, b_range, ia_recip(b_range, &undefined, &rough))), box = ra_from_range(result);
  const I better = LE(product.z, R(0.5) * (result.hi - result.lo)) & LT(product.z, INF);
  return RA_PICK(better, product, box);
}

// sqrt(x + d) - (sqrt(x) + d / (2 sqrt(x))) = -d^2 / (2 sqrt(x) (sqrt(x + d) + sqrt(x))^2). The slope errs by 5.5 ulp, sum by 3.5, q by 6.5, the remainder by 19.
static inline RA ra_sqrt(RA a, IA range, IA result) {
  const F reach = ra_rad(a), s = sqrt(max(a.x, (F)0)), sum = s + result.lo, q = reach / sum;
  return ra_smooth(a, reach, s, R(0.5) / s, R(-0.5) * q * (q / s), (F)0, R(3.0), GE(range.lo, (F)0) & WITHIN(a, range), result);
}

static inline RA ra_cbrt(RA a, IA range, IA result) {
  const F reach = ra_rad(a), c = cbrt(a.x), near = min(fabs(result.lo), fabs(result.hi)), over = reach / (near * near);
  // |g''| / 2 = 1 / (9 |c|^5); the slope errs by 7.5 ulp, over by 3.5, q by 10.5.
  const F q = over * over / (R(9.0) * near), slope = R(1.0) / (R(3.0) * c * c);
  const I above = GT(a.x, (F)0), apart = GT(result.lo, (F)TINY) | LT(result.hi, (F)-TINY);
  return ra_smooth(a, reach, c, slope, SELECT(above, -q, (F)0), SELECT(above, (F)0, q), R(2.0), apart & WITHIN(a, range), result);
}
