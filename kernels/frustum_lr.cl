// frustum-lr: Bezier subdivision at the first zero of the control polygon (Lane and Riesenfeld; S2 section 4.2).
static inline F cut_of(const F* c, F sign, F last, F before, F a, F b) {
  return clamp(polygon_zero(c, sign), (F)NARROWEST, (F)(R(1.0) - NARROWEST));
}
