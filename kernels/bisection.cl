// Stackless bisection (S1 section 5, algorithm 3): halve what may hold a zero, skip what does not.
//
// Deviations from S1: an integer counter of units takes the place of the floating modulus (a skipped piece [p, p + s)
// leads to p + s and to the longest step that its lowest bit allows). With IRT_OUTWARD a piece that is short enough is a
// candidate, not a hit: the signs of f a little outside it must be proven opposite and f continuous between; otherwise
// halving goes on to the floor of the precision, where the bracket may widen; what is still open is TOUCH.
#define WIDENINGS 7  // each threefold

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range);
  ROOT root;
  root.status = MISS;
  root.lo = root.hi = (F)0;
  I active = LE(range->out0, range->out1);
  I position = NONE, step = PATH_END, pieces = NONE, undefined, rough;
  // The longest step whose piece, with its margins, is no wider than eps.
  const F wanted = (F)EPS / (ray->length * path.unit) * (R(1.0) - R(8.0) * ULP);
#if IRT_OUTWARD
  I stop = TO_I(POWER_OF_TWO_BELOW(clamp(wanted * R(0.5), (F)1, TO_F(PATH_END))));
#else
  const I stop = TO_I(POWER_OF_TWO_BELOW(clamp(wanted, (F)1, TO_F(PATH_END))));
#endif
  while (ANY(active)) {
    I moving = active;
    while (ANY(moving)) {
      const F from = TO_F(position);
      const FORM f = enclose(&path, from, from + TO_F(step) PARAMETERS_PASS, &undefined, &rough);
      const I skip = positive(f) | negative(f) | undefined;
      const I next = position + step;
      const I candidate = ~skip & LE(step, stop);
      step = SELECT(moving & ~candidate, SELECT(skip, next & -next, step >> 1), step);
      position = SELECT(moving & skip, next, position);
      pieces -= moving;
      const I ended = moving & GE(position, PATH_END);
      const I exhausted = moving & ~ended & GE(pieces, (I)max_pieces);
      root.status = SELECT(exhausted, UNRESOLVED, root.status);
      root.lo = SELECT(exhausted, TO_F(position), root.lo);
      root.hi = SELECT(exhausted, TO_F(position + step), root.hi);
      active &= ~(ended | exhausted);
      moving &= ~(ended | exhausted | candidate);
    }
    if (!ANY(active)) break;
    const F from = TO_F(position), size = TO_F(step);
#if IRT_OUTWARD
    F margin = R(0.5) * size;
    I open = active;
    const I floor_reached = LE(step, (I)1);
    for (int k = 0; k <= WIDENINGS && ANY(open); ++k) {
      const F lo = max(from - margin, max(path.in0, (F)0)), hi = min(from + size + margin, path.in1);
      I discontinuous = NONE, none;
      const FORM at_lo = enclose(&path, lo, lo PARAMETERS_PASS, &undefined, &none);
      const FORM at_hi = enclose(&path, hi, hi PARAMETERS_PASS, &none, &none);
#if IRT_PARTIAL
      enclose(&path, lo, hi PARAMETERS_PASS, &none, &discontinuous);
#endif
      const I opposite = (positive(at_lo) & negative(at_hi)) | (negative(at_lo) & positive(at_hi));
      const I proven = open & opposite & LE(lo, from + size) & LT(lo, hi) & ~discontinuous;
      root.status = SELECT(proven, HIT, root.status);
      root.lo = SELECT(proven, min(lo, from), root.lo);
      root.hi = SELECT(proven, hi, root.hi);
      active &= ~proven;
      open &= ~proven & floor_reached;
      margin *= R(3.0);
    }
    if (ANY(active & floor_reached)) {
      const I last = active & floor_reached;
      const FORM f = enclose(&path, from, from + size PARAMETERS_PASS, &undefined, &rough);
      root.status = SELECT(last, SELECT(unbounded(f), UNRESOLVED, TOUCH), root.status);
      root.lo = SELECT(last, from, root.lo);
      root.hi = SELECT(last, from + size, root.hi);
      active &= ~last;
    }
    stop = max(stop >> 4, (I)1);
#else
    I none;
    const FORM at_lo = enclose(&path, from, from PARAMETERS_PASS, &undefined, &rough);
    const FORM at_hi = enclose(&path, from + size, from + size PARAMETERS_PASS, &none, &none);
    const I opposite = (positive(at_lo) & negative(at_hi)) | (negative(at_lo) & positive(at_hi));
    root.status = SELECT(active, SELECT(opposite, HIT, TOUCH), root.status);
    root.lo = SELECT(active, from, root.lo);
    root.hi = SELECT(active, from + size, root.hi);
    active = NONE;
#endif
  }
  root.lo = fma(root.lo, path.unit, path.start);
  root.hi = fma(root.hi, path.unit, path.start);
  return root;
}
