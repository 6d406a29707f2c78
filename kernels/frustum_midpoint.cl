// frustum-midpoint: Bezier subdivision at the middle (Schneider; S2 section 4.2).
static inline F cut_of(const F* c, F sign, F last, F before, F a, F b) { return (F)R(0.5); }
