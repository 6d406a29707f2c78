// frustum-mr: knots at the first zero of the control polygon (Morken and Reimers; S2 section 4.2).
static inline F knot_of(F zero, F last, F before) { return zero; }
