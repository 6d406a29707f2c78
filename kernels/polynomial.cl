// Polynomials in one variable (a coordinate or its square), by their Taylor form about the middle of its range: p(c + d) = sum of t_k d^k, |d| <= r.
//
// Not in the papers. Summing monomials loses everything where they cancel (Chmutov surfaces as printed: coefficients of
// 1e10 for values of 1); the t_k are what the polynomial really does on the range.

typedef struct {
  F value, slope, rest;  // p lies within `rest` of value + slope d
} TAYLOR;

// t: the n + 1 coefficients, lowest first; they become the t_k by repeated synthetic division.
static inline TAYLOR taylor_form(F* t, const int n, F c, F r) {
#if IRT_OUTWARD
  // Every term goes through 2 n roundings at most and its coefficient through one; `size` bounds their sum over the range.
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
  p.rest = fma((F)((real)(n + 3) * ULP), size, p.rest * (R(1.0) + (real)(n + 8) * ULP)) + (F)TINY;
#endif
  return p;
}

#define IA_MIDDLE(a) (R(0.5) * (a).lo + R(0.5) * (a).hi)
#define IA_RADIUS(a) (max((a).hi - IA_MIDDLE(a), IA_MIDDLE(a) - (a).lo) * (R(1.0) + R(2.0) * ULP))
#define IA_POLYNOMIAL(a, taylor) ia_polynomial(taylor(IA_MIDDLE(a), IA_RADIUS(a)), IA_RADIUS(a))

static inline IA ia_polynomial(TAYLOR p, F r) {
  const F spread = fma(fabs(p.slope), r, p.rest) * (R(1.0) + R(2.0) * ULP);
  return IA_OUT(NAN_TO(p.value - spread, -INF), NAN_TO(p.value + spread, INF), EXACT_K);
}
