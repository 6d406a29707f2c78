// Stackless bisection (S1 section 5, algorithm 3): halve what may hold a zero, skip what does not.
//
// Deviations from S1: an integer counter of units takes the place of the floating modulus (a skipped piece [p, p + s)
// leads to p + s and to the longest step that its lowest bit allows, but at most 2 s: a neighbour seldom allows more). With IRT_OUTWARD a piece that is short enough is a
// candidate, not a hit. The piece skipped just before it tells the sign at its start; the sign a little behind its end
// must be proven opposite, and f continuous between. Otherwise halving goes on to the floor of the precision, where the
// bracket may widen; what is still open is TOUCH, or UNRESOLVED at a pole.
#define MARGIN R(0.25)  // of a piece, beyond its end
#define WIDENINGS 12    // each twofold

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  I status = MISS;
  F found_lo = (F)0, found_hi = (F)0;
  I active = LE(range->out0, range->out1);
  I position = NONE, step = PATH_END, pieces = NONE, undefined, rough;
  I above = NONE, below = NONE;  // the sign of f at `position`, where it is known
  // The longest step whose piece, with its margin, is no wider than eps.
  const F wanted = (F)EPS / (NARROW(ray->length) * path.unit) * (R(1.0) - R(8.0) * ULP);
#if IRT_OUTWARD
  I stop = TO_I(POWER_OF_TWO_BELOW(clamp(wanted / (R(1.0) + MARGIN), (F)1, TO_F(PATH_END))));
#else
  const I stop = TO_I(POWER_OF_TWO_BELOW(clamp(wanted, (F)1, TO_F(PATH_END))));
#endif
  while (ANY(active)) {
    I moving = active;
    while (ANY(moving)) {
      const F from = TO_F(position);
      const FORM f = enclose(&path, from, from + TO_F(step) PARAMETERS_PASS, &undefined, &rough);
      const I is_above = positive(f) & ~undefined, is_below = negative(f) & ~undefined, skip = is_above | is_below | undefined;
      const I next = position + step, go = moving & skip;
      const I candidate = ~skip & LE(step, stop);
      step = SELECT(moving & ~candidate, SELECT(skip, min(next & -next, step << 1), step >> 1), step);
      position = SELECT(go, next, position);
      above = SELECT(go, is_above, above);
      below = SELECT(go, is_below, below);
      pieces -= moving;
      const I ended = moving & GE(position, PATH_END);
      const I exhausted = moving & ~ended & GE(pieces, (I)max_pieces);
      status = SELECT(exhausted, UNRESOLVED, status);
      found_lo = SELECT(exhausted, TO_F(position), found_lo);
      found_hi = SELECT(exhausted, TO_F(position + step), found_hi);
      active &= ~(ended | exhausted);
      moving &= ~(ended | exhausted | candidate);
    }
    if (!ANY(active)) break;
    const F from = TO_F(position), end = from + TO_F(step);
    I none;
    // Nothing was skipped before the first piece.
    const I first = active & EQ(position, NONE);
    if (ANY(first)) {
      const F inside = clamp(path.in0, (F)0, end);
      const FORM f = enclose(&path, inside, inside PARAMETERS_PASS, &undefined, &none);
      above = SELECT(first, positive(f) & ~undefined, above);
      below = SELECT(first, negative(f) & ~undefined, below);
    }
#if IRT_OUTWARD
    F margin = MARGIN * (end - from);
    I open = active;
    const I floor_reached = LE(step, (I)1);
    for (int k = 0; k <= WIDENINGS && ANY(open); ++k) {
      const F hi = min(end + margin, path.in1);
      const FORM f = enclose(&path, hi, hi PARAMETERS_PASS, &undefined, &none);
      I proven = open & ((above & negative(f)) | (below & positive(f))) & ~undefined & GT(hi, from);
#if IRT_PARTIAL
      I discontinuous;
      enclose(&path, from, hi PARAMETERS_PASS, &none, &discontinuous);
      proven &= ~discontinuous;
#endif
      status = SELECT(proven, HIT, status);
      found_lo = SELECT(proven, from, found_lo);
      found_hi = SELECT(proven, hi, found_hi);
      active &= ~proven;
      open &= ~proven & floor_reached;
      margin += margin;
    }
    const I last = active & floor_reached;
    if (ANY(last)) {
      const FORM f = enclose(&path, from, end PARAMETERS_PASS, &undefined, &rough);
      status = SELECT(last, SELECT(unbounded(f), UNRESOLVED, TOUCH), status);
      found_lo = SELECT(last, from, found_lo);
      found_hi = SELECT(last, end, found_hi);
      active &= ~last;
    }
    stop = max(stop >> 4, (I)1);
#else
    const FORM f = enclose(&path, end, end PARAMETERS_PASS, &undefined, &none);
    const I opposite = (above & negative(f)) | (below & positive(f));
    status = SELECT(active, SELECT(opposite, HIT, TOUCH), status);
    found_lo = SELECT(active, from, found_lo);
    found_hi = SELECT(active, end, found_hi);
    active = NONE;
#endif
  }
  return report(&path, q, status, found_lo, found_hi);
}
