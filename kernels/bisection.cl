// Stackless bisection (S1 section 5, algorithm 3): halve what may hold a zero, skip what does not.
//
// Deviations from S1: an integer counter of units takes the place of the floating modulus (a skipped piece [p, p + s)
// leads to p + s and to the longest step that its lowest bit allows, but at most 2 s: a neighbour seldom allows more).
// With IRT_OUTWARD a piece that is short enough is a candidate, not a hit. The piece skipped just before it tells the sign at
// its start; the sign a little behind its end must be proven opposite, and f continuous between. Otherwise halving goes on to
// the floor of the precision, where the bracket may widen; what is still open is TOUCH, or UNRESOLVED at a pole.
//
// f is evaluated at one place only, for lanes that march and lanes that prove alike: no lane waits for another, and the
// driver compiles f once.
#define MARGIN R(0.25)  // of a piece, beyond its end
#define WIDENINGS 24    // each by a half, so that the bracket is hardly wider than it must be

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  // The longest step whose piece, with its margin, is no wider than eps.
  const F wanted = (F)EPS / (NARROW(ray->length) * path.unit) * (R(1.0) - R(8.0) * ULP);
#if IRT_OUTWARD
  I stop = TO_I(POWER_OF_TWO_BELOW(clamp(wanted / (R(1.0) + MARGIN), (F)1, TO_F(PATH_END))));
#else
  I stop = TO_I(POWER_OF_TWO_BELOW(clamp(wanted, (F)1, TO_F(PATH_END))));
#endif
  I active = LE(range->out0, range->out1), status = MISS;
  F found_lo = (F)0, found_hi = (F)0;
  // Every lane begins by proving a sign where the path begins, with a step of nothing.
  I position = NONE, step = NONE, pieces = NONE, tries = NONE;
  I proving = ALL, above = NONE, below = NONE;  // the sign of f at `position`, where it is known
  F margin = max(path.in0, (F)0);
#if IRT_OUTWARD
  I wild = NONE;  // the enclosure of the candidate is infinite
#endif
#if IRT_PARTIAL
  I checking = NONE;  // the signs are proven, continuity is not yet
#endif
  while (ANY(active)) {
    const F from = TO_F(position), end = from + TO_F(step), behind = min(end + margin, path.in1);
#if IRT_PARTIAL
    const F a = SELECT(proving & ~checking, behind, from);
#else
    const F a = SELECT(proving, behind, from);
#endif
    const F b = SELECT(proving, behind, end);
    I undefined, rough;
    const FORM f = enclose(&path, a, b PARAMETERS_PASS, &undefined, &rough);
    const I is_above = positive(f) & ~undefined, is_below = negative(f) & ~undefined;

    const I starts = active & EQ(step, NONE);
    const I skips = active & ~proving & (is_above | is_below | undefined), deeper = active & ~proving & ~skips;
    const I candidate = deeper & LE(step, stop), tried = active & proving & ~starts;
#if IRT_PARTIAL
    const I opposite = tried & ((above & is_below) | (below & is_above)) & ~checking, proven = tried & checking & ~rough;
    const I failed = tried & ~opposite & ~proven;
    checking = opposite;
#else
    const I proven = tried & ((above & is_below) | (below & is_above)), failed = tried & ~proven;
#endif
#if IRT_OUTWARD
    wild = SELECT(candidate, unbounded(f), wild);
    const I last = LE(step, (I)1), widens = failed & last & LT(tries, (I)WIDENINGS) & LT(behind, path.in1);
    const I gives_up = failed & last & ~widens, halves = failed & ~last;
    const I open = SELECT(wild, UNRESOLVED, TOUCH);
    stop = SELECT(halves, max(stop >> 4, (I)1), stop);
    tries = SELECT(candidate, NONE, tries - widens);
    margin = SELECT(candidate, MARGIN * (end - from), SELECT(widens, R(1.5) * margin, margin));
#else
    const I gives_up = failed, halves = NONE, open = TOUCH;
    margin = (F)0;
#endif
    pieces -= active;
    const I next = position + step, ended = skips & GE(next, PATH_END);
    const I exhausted = active & ~(ended | proven | gives_up) & GE(pieces, (I)max_pieces);
    const I stops = proven | gives_up | exhausted;
    status = SELECT(stops, SELECT(proven, HIT, SELECT(gives_up, open, UNRESOLVED)), status);
    found_lo = SELECT(stops, from, found_lo);
    found_hi = SELECT(stops, SELECT(proven, behind, end), found_hi);
    active &= ~(stops | ended);

    above = SELECT(skips | starts, is_above, above);
    below = SELECT(skips | starts, is_below, below);
    proving = SELECT(starts | halves, NONE, proving | candidate);
    const I longest = next & -next;
    step = SELECT(skips, min(longest, step << 1), SELECT((deeper & ~candidate) | halves, step >> 1, SELECT(starts, PATH_END, step)));
    position = SELECT(skips, next, position);
  }
  return report(&path, q, status, found_lo, found_hi);
}
