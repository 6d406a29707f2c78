// Polynomials in one coordinate of affine forms (kernels/polynomial.cl).
#define RA_POLYNOMIAL(a, taylor) ra_polynomial(taylor((a).x, ra_rad(a)), a)

static inline RA ra_polynomial(TAYLOR p, RA a) {
  return ra(p.value, p.slope * a.y, fma(fabs(p.slope), a.z, p.rest));
}
