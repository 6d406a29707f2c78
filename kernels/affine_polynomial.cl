// Polynomials in one coordinate of affine forms (kernels/polynomial.cl).
#define RA_POLYNOMIAL(a, taylor) ra_polynomial(taylor((a).x, ra_reach(a)), a)

static inline RA ra_polynomial(TAYLOR p, RA a) {
  const F z = fma(fabs(p.slope), a.z, p.rest);
#if IRT_OUTWARD
  return ra(p.value, p.slope * a.y, fma((F)(R(3.0) * ULP), fma(fabs(p.slope), fabs(a.y), z), z));
#else
  return ra(p.value, p.slope * a.y, z);
#endif
}
