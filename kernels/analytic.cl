// Closed forms (S3, S4 section 3.1.1): the first root of a polynomial of degree 4 at most along the ray.
//
// The piece of ray inside the bounds is [-1, 1] of e, about its middle, however far the camera. HIT: computed values before and behind
// have opposite signs, by more than rounding can have made. TOUCH: a value that rounding may have made between two of one sign
// (a root of even order), at an end (the eye on the surface), a root that rounding hides by more than eps (of odd order, from three on), or one that may lie outside the bounds.
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const F middle = R(0.5) * (range->out0 + range->out1), reach = R(0.5) * (range->out1 - range->out0);
  I open = LE(range->out0, range->out1), hit = NONE, touch = NONE, overflow = NONE;
  F at = (F)0, near = (F)0, far = (F)0, side = (F)0;
  if (ANY(open)) {
    F c[LEAVES][TERMS], error[LEAVES], e[TERMS];
    irt_coefficients(fma(middle, ray->dx, ray->px), fma(middle, ray->dy, ray->py), fma(middle, ray->dz, ray->pz), reach * ray->dx,
                     reach * ray->dy, reach * ray->dz PARAMETERS_PASS, c, error);
    overflow = open & ~LT(error[0], INF);
    scale_form(c[0], IRT_DEGREE, error);
    turning_points(c[0], IRT_DEGREE, e);
    WALK walk = begin_walk();
    for (int k = 0; k <= IRT_DEGREE; ++k) {
      const F s = certain_sign(value_of(c[0], IRT_DEGREE, e[k]), error[0]);
      const I odd = open & crosses(&walk, s), even = open & touches(&walk, s);
      near = SELECT(odd, walk.from, near);
      far = SELECT(odd, e[k], far);
      side = SELECT(odd, walk.side, side);
      at = SELECT(even, walk.doubtful, at);
      hit |= odd;
      touch |= even;
      open &= ~(odd | even);
      walk_to(&walk, e[k], s);
    }
    at = SELECT(open, walk.doubtful, at);
    touch |= open & walk.doubts;
    if (ANY(hit)) {
      at = SELECT(hit, root_between(c[0], IRT_DEGREE, near, far, side, hit), at);
      const I vague = hit & blurred(c[0], IRT_DEGREE, error[0], near, far, side, at, wanted_places(ray, reach, q));
      hit &= ~vague;
      touch |= vague;
    }
  }
  return closed_root(range, middle, reach, at, hit, touch, overflow);
}
