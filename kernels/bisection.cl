// Stackless bisection (S1 section 5, algorithm 3): halve what may hold a zero, skip what does not.
//
// Deviations from S1: an integer counter of units takes the place of the floating modulus (a skipped piece [p, p + s)
// leads to p + s and to the longest step that its lowest bit allows, but at most 2 s: a neighbour seldom allows more).
// With IRT_OUTWARD a piece that is short enough is a candidate, not a hit. The piece skipped just before it tells the sign at
// its start; the sign a little behind its end must be proven opposite, and f continuous between. Otherwise the bracket widens while
// it stays within eps, then halving goes on to the floor of the precision, where it may widen further; what is still open is
// TOUCH, or UNRESOLVED at a pole.
//
// A piece that lies outside the clip region (IRT_CLIP) is skipped as well, which tells nothing of f's sign at its end; and a
// HIT needs its bracket inside.
//
// With IRT_OUTWARD f is evaluated at one place only, for lanes that march and lanes that prove alike: no lane waits for
// another, and the driver compiles f once. Lanes that are done keep their position and step.
#define MARGIN R(0.25)  // of a piece, beyond its end
// From the floor brackets widen a little at a time, so that they are hardly wider than they must be. Both ways lead to about a
// thousandth of the path; in double that is a long way, and formulas that cancel (expanded high degrees) need all of it.
#if IRT_DOUBLE
#define WIDENINGS 64
#define WIDER R(1.5)
#else
#define WIDENINGS 48
#define WIDER R(1.25)
#endif

// Pieces that each lane has looked at, where the call asks for them.
#if IRT_PIECES
#define COUNT_FROM_HERE I looked = NONE;
#define COUNT(lanes) looked -= (lanes);
#define REPORT_COUNT root.pieces = looked;
#else
#define COUNT_FROM_HERE
#define COUNT(lanes)
#define REPORT_COUNT
#endif

// The longest step whose piece is no wider than eps / share.
static inline I stopping_step(const RAY* ray, const PATH* path, __global const real* q, real share) {
  const F wanted = (F)EPS / (NARROW(ray->length) * path->unit) * ((R(1.0) - R(8.0) * ULP) / share);
  return TO_I(POWER_OF_TWO_BELOW(clamp(wanted, (F)1, TO_F(PATH_END))));
}

#if IRT_OUTWARD
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  const F widest = (F)EPS / (NARROW(ray->length) * path.unit) * (R(1.0) - R(8.0) * ULP);  // bracket
  I stop = stopping_step(ray, &path, q, R(1.0) + MARGIN);
  I active = LE(range->out0, range->out1), hits = NONE, open = NONE;
  // Every lane begins by proving a sign where the path begins, with a step of nothing.
  I position = NONE, step = NONE, tries = NONE, proving = ALL;
  I above = NONE, below = NONE;  // the sign of f at `position`, or at in0 where that lies ahead, if it is known
  I wild = NONE;                 // the enclosure of the candidate is infinite
  F margin = max(path.in0, (F)0);
#if IRT_PARTIAL || IRT_CLIP
  I checking = NONE;  // the signs are proven, continuity and lying inside the clip region are not yet
#endif
  COUNT_FROM_HERE
  for (int pieces = 0; pieces < max_pieces && ANY(active); ++pieces) {
    COUNT(active)
    const F from = TO_F(position), end = from + TO_F(step), behind = max(min(end + margin, path.in1), path.in0);
#if IRT_PARTIAL || IRT_CLIP
    const F a = SELECT(proving & ~checking, behind, from);
#else
    const F a = SELECT(proving, behind, from);
#endif
    const F b = SELECT(proving, behind, end);
    I undefined, rough;
    REGION_VARIABLES
    const FORM f = enclose(&path, a, b PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    const I is_above = positive(f) & ~undefined, is_below = negative(f) & ~undefined;

    const I starts = active & EQ(step, NONE), marches = active & ~proving, tried = active & proving & ~starts;
    const I skips = marches & (is_above | is_below | undefined | outside), deeper = marches & ~skips, candidate = deeper & LE(step, stop);
    const I opposite = tried & ((above & is_below) | (below & is_above));
#if IRT_PARTIAL || IRT_CLIP
    const I proven = tried & checking & inside & ~rough, failed = tried & ~proven & (~opposite | checking);
    checking = opposite & ~checking;
#else
    const I proven = opposite, failed = tried & ~opposite;
#endif
    const I last = LE(step, (I)1), room = (above | below) & LE(R(2.0) * (behind - from), widest);
    const I widens = failed & (last | room) & LT(tries, (I)WIDENINGS) & LT(behind, path.in1);
    const I gives_up = failed & last & ~widens, halves = failed & ~last & ~widens;
    const I next = position + step, longest = next & -next;
    hits |= proven;
    open |= gives_up;
    active &= ~(proven | gives_up | (skips & GE(next, PATH_END)));
    wild = SELECT(candidate, unbounded(f), wild);
    tries = SELECT(candidate, NONE, tries - widens);
    margin = SELECT(candidate, MARGIN * (end - from), SELECT(widens, SELECT(last, WIDER * margin, margin + (behind - from)), margin));
    stop = SELECT(halves, max(stop >> 4, (I)1), stop);
    // What lies before in0 may lie outside the bounds: a change of sign there would be no hit.
    const I counts = starts | (skips & GE(TO_F(next), path.in0));
    above = SELECT(counts, is_above, above);
    below = SELECT(counts, is_below, below);
    proving = SELECT(starts | halves, NONE, proving | candidate);
    step = SELECT(skips, min(longest, step << 1), SELECT((deeper & ~candidate) | halves, step >> 1, SELECT(starts, PATH_END, step)));
    position = SELECT(skips, next, position);
  }
  // Lanes that are still active have spent their budget.
  const F from = TO_F(position), end = from + TO_F(step);
  const I status = SELECT(hits, HIT, SELECT(open & ~wild, TOUCH, SELECT(open | active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, from, SELECT(hits, min(end + margin, path.in1), end));
  REPORT_COUNT
  return root;
}
#else
// As the paper does: the first piece that is short enough ends the search. HIT where the computed signs at its ends differ.
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  const I stop = stopping_step(ray, &path, q, R(1.0));
  I active = LE(range->out0, range->out1), open = NONE;
  I position = NONE, step = PATH_END, undefined, rough;
  COUNT_FROM_HERE
  for (int pieces = 0; pieces < max_pieces && ANY(active); ++pieces) {
    COUNT(active)
    const F from = TO_F(position);
    REGION_VARIABLES
    const FORM f = enclose(&path, from, from + TO_F(step) PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    const I skip = positive(f) | negative(f) | undefined | outside, next = position + step, longest = next & -next;
    const I found = active & ~skip & LE(step, stop);
    open |= found;
    active &= ~found;
    step = SELECT(active, SELECT(skip, min(longest, step << 1), step >> 1), step);
    position = SELECT(active & skip, next, position);
    active &= LT(position, PATH_END);
  }
  const F from = TO_F(position), end = from + TO_F(step);
  I opposite = NONE;
  if (ANY(open)) {
    REGION_VARIABLES
    const FORM at_from = enclose(&path, from, from PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    const I counts = inside;
    const FORM at_end = enclose(&path, end, end PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    opposite = counts & inside & ((positive(at_from) & negative(at_end)) | (negative(at_from) & positive(at_end)));
  }
  ROOT root = report(&path, q, SELECT(open, SELECT(opposite, HIT, TOUCH), SELECT(active, UNRESOLVED, MISS)), from, end);
  REPORT_COUNT
  return root;
}
#endif
