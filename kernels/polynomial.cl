// Polynomials in one variable (a coordinate or its square), by their Taylor form about the middle of its range: p(c + d) = sum of t_k d^k, |d| <= r.
//
// Not in the papers. Summing monomials loses everything where they cancel (Chmutov surfaces as printed: coefficients of
// 1e10 for values of 1); the t_k are what the polynomial really does on the range.

typedef struct {
  F value, slope, rest;  // p lies within `rest` of value + slope d
} TAYLOR;

// r may be rounded down once. t: the n + 1 coefficients, lowest first; they become the t_k by repeated synthetic division.
static inline TAYLOR taylor_form(F* t, const int n, F c, F r) {
#if IRT_OUTWARD
  // `size` bounds the sum of all terms over the range. A coefficient errs by an ulp; every term goes through n + 1 roundings in the division
  // and three where the value is lifted and the form is used. Terms of the rest go through n + 6 more, with n / 2 ulp for r.
  const real pad = (R(0.5) * n + R(3.01)) * ULP;
  const F reach = fabs(c) + r;
  F size = fabs(t[n]);
  for (int k = n - 1; k >= 0; --k) size = fma(size, reach, fabs(t[k]));
#endif
  for (int j = 0; j < n; ++j)
    for (int k = n - 1; k >= j; --k) t[k] = fma(c, t[k + 1], t[k]);
  F high = fabs(t[n]);
  for (int k = n - 1; k >= 3; --k) high = fma(high, r, fabs(t[k]));  // n >= 3
  const F square = r * r, lift = R(0.5) * t[2] * square;  // t_2 d^2 has one sign: its middle is lifted
  TAYLOR p;
  p.value = t[0] + lift;
  p.slope = t[1];
  p.rest = fma(high, square * r, fabs(lift));
#if IRT_OUTWARD
  p.rest = fma((F)pad, size, p.rest * (R(1.0) + R(2.0) * pad)) + (F)TINY;
#endif
  return p;
}

#define IA_MIDDLE(a) (R(0.5) * (a).lo + R(0.5) * (a).hi)
#define IA_RADIUS(a) max((a).hi - IA_MIDDLE(a), IA_MIDDLE(a) - (a).lo)
#define IA_POLYNOMIAL(a, taylor) ia_polynomial(taylor(IA_MIDDLE(a), IA_RADIUS(a)), IA_RADIUS(a))

static inline IA ia_polynomial(TAYLOR p, F r) {
  const F spread = fma(fabs(p.slope), r, p.rest);
  return ia(CAP_LOWER(NAN_TO(p.value - spread, -INF)), CAP_UPPER(NAN_TO(p.value + spread, INF)));
}
