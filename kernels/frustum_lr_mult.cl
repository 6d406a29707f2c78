// frustum-lr-mult: as frustum-lr, with an estimate of the root's multiplicity (S2 section 4.2).
//
// At a root of multiplicity m the zeros of the control polygon approach it by the factor 1 - 1/m a step. Two steps give the factor, and with
// it the length that is still to go. (S2 takes the estimate from a paper that was then in preparation; this one is ours.)
static inline F cut_of(const F* c, F sign, F last, F before, F a, F b) {
  const F zero = polygon_zero(c, sign), x = fma(zero, b - a, a);
  const F factor = clamp((x - last) / (last - before), (F)0, (F)(R(1.0) - R(1.0) / IRT_DEGREE));
  const I known = GE(before, (F)0) & GT(fabs(last - before), (F)TINY) & GE((x - last) * (last - before), (F)0);
  const F further = (last + (x - last) / (R(1.0) - factor) - a) / max(b - a, (F)TINY);
  return clamp(SELECT(known, further, zero), (F)NARROWEST, (F)(R(1.0) - NARROWEST));
}
