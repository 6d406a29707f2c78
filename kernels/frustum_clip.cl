// frustum-clip: Bezier clipping from the front (Nishita, Sederberg, Kakimoto; S2 section 4.2).
//
// No control point lies below the steepest line from the first one to any other, so the polynomial has no zero before that
// line has one. The line supports the convex hull; where its far point lies beyond the axis it is the hull's own edge.
static inline F cut_of(const F* c, F sign, F last, F before, F a, F b) {
  const F start = sign * c[0];
  F steepest = (F)0;
  for (int k = 1; k < N; ++k) steepest = min(steepest, (sign * c[k] - start) * (R(1.0) / k));
  return clamp(start / max(-steepest * IRT_DEGREE, (F)TINY), (F)NARROWEST, (F)(R(1.0) - NARROWEST));
}
