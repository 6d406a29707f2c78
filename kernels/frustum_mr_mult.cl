// frustum-mr-mult: as frustum-mr, with an estimate of the root's multiplicity (S2 section 4.2; ours, as in frustum_lr_mult.cl).
static inline F knot_of(F zero, F last, F before) {
  const F factor = clamp((zero - last) / (last - before), (F)0, (F)(R(1.0) - R(1.0) / IRT_DEGREE));
  const I known = GE(before, (F)0) & GT(fabs(last - before), (F)TINY) & GE((zero - last) * (last - before), (F)0);
  return SELECT(known, last + (zero - last) / (R(1.0) - factor), zero);
}
