// Remainders of affine forms: a - k b, where the whole of a / b has one floor k.
static inline RA ra_mod(RA a, RA b, IA a_range, IA b_range, IA result) {
  I undefined, rough, jumps, none;
  const IA k = ia_floor(ia_div(a_range, b_range, &undefined, &rough), &none, &jumps);
  const RA same = ra_sub(a, ra_mul(b, ra(k.lo, (F)0, (F)0))), box = ra_from_range(result);
  const I better = ~(rough | jumps) & LT(same.z, INF);
  return RA_PICK(better, same, box);
}
