// Stackless bisection (S1 section 5, algorithm 3): halve what may hold a zero, skip what does not.
//
// Deviations from S1: an integer counter of units takes the place of the floating modulus (a skipped piece [p, p + s)
// leads to p + s and to the longest step that its lowest bit allows, but at most 2 s: a neighbour seldom allows more).
// With IRT_OUTWARD a piece that is short enough is a candidate, not a hit. An affine form whose ends have proven opposite signs
// (`crosses`) is one without another evaluation. Intervals cannot be excluded some pieces before the root already, and marching on in
// ever smaller pieces took most of the time; so a window is opened there (IRT_ALONG, isolate.cl): where f is steady in it, Newton steps
// prove that it has no root, or a bracket. Otherwise, and without windows, the piece skipped just before tells the sign at the
// candidate's start; the sign a little behind its end must be proven opposite, and f continuous between. Else the bracket widens while
// it stays within eps, then halving goes on to the floor of the precision, where it may widen further; what is still open is
// TOUCH, or UNRESOLVED at a pole.
//
// A piece that lies outside the clip region (IRT_CLIP) is skipped as well, which tells nothing of f's sign at its end; and a
// HIT needs its bracket inside.
//
// With IRT_OUTWARD f is evaluated at one place only, so that the driver compiles it once. Lanes at candidates wait until no lane marches;
// then all of them open windows, cut, and prove together. Where all roundings of f together have a bound (IRT_SLACK), lanes first march by
// arithmetic without pads as far as that bound leaves no doubt.
#if IRT_ALONG
#define EARLY 2  // windows are opened at pieces of 2^EARLY times eps
#define AHEAD 2  // and are 2^AHEAD pieces long
#endif
#if IRT_SLACK
#define COARSE R(8.0)   // where a COARSEth of the radius is less than the bound of all roundings, pads are tighter
#define SHORT ((I)64)   // units: so much the coordinates without pads may be off, and more
#endif

#if IRT_ALONG
// Windows end where a piece of `halt` units can begin.
static inline I window_end(I position, I halt) { return min((position + (halt << AHEAD)) & -halt, PATH_END); }
#endif

// The longest step of a power of two units that is no longer than `wanted`.
static inline I longest_step(F wanted) { return TO_I(POWER_OF_TWO_BELOW(clamp(wanted, (F)1, TO_F(PATH_END)))); }

#if IRT_OUTWARD
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  const F wanted = wanted_units(ray, &path, q);
  const I first_stop = longest_step(wanted / (R(1.0) + MARGIN));
#if IRT_ALONG
  const I first_halt = min(longest_step(wanted) << EARLY, PATH_END);
#else
  const I first_halt = longest_step(wanted);  // what is found without a margin is as wide as its piece
#endif
  // A bracket (sharpen.cl) is a window as it is.
  I stop = first_stop, halt = IRT_SHARPENS && IRT_ALONG ? PATH_END : first_halt;
  I active = LE(range->out0, range->out1), marching = active, proving = NONE, hits = NONE, open = NONE;
  I position = NONE, step = PATH_END, tries = NONE;
  I above = NONE, below = NONE;  // the sign of f at `position`, if it is known
  I asked = NONE;                // the sign at the start has been asked for
  I wild = NONE;                 // the enclosure of the candidate is infinite
  F near = (F)0, far = (F)0, margin = (F)0;  // a bracket that is found; what is looked at behind a candidate
#if IRT_ALONG
  I cutting = NONE;
  WINDOW window;
  window.lo = window.hi = window.least = window.most = (F)0;
  window.below = window.above = window.steady = window.rising = NONE;
#endif
#if IRT_PARTIAL || IRT_CLIP
  I checking = NONE;  // the signs are proven, continuity and lying inside the clip region are not yet
#endif
  COUNT_FROM_HERE
  for (int pieces = 0; pieces < max_pieces && ANY(active); ++pieces) {
#if IRT_SLACK
    // Most pieces hold a zero or none by far, and neither takes a proof of each rounding. Lanes in doubt wait for the others.
    I doubtful = NONE;
    F side = SELECT(above, (F)1, SELECT(below, (F)-1, (F)0));
    for (; pieces < max_pieces && ANY(marching); ++pieces) {
      COUNT(marching)
      const F start = TO_F(position);
      const BARE f = enclose_bare(&path, start, start + TO_F(step) PARAMETERS_PASS);
      const I excluded = GT(f.off, f.slack), skips = marching & excluded, stays = marching & ~excluded;
      const I next = position + step, unsure = stays & (LT(step, SHORT) | GT(COARSE * f.slack, f.radius)), doubts = unsure | (stays & LE(step, halt));
#if IRT_ALONG
      doubtful |= unsure;  // a window, not this piece, is what the others are to be asked
#else
      doubtful |= doubts;
#endif
      side = SELECT(skips, f.side, side);
      step = SELECT(skips, min(LOWEST_BIT(next), step << 1), SELECT(stays & ~doubts, step >> 1, step));
      position = SELECT(skips, next, position);
      marching &= ~doubts & LT(position, PATH_END);
    }
    above = GT(side, (F)0);
    below = LT(side, (F)0);
    active &= LT(position, PATH_END);
    marching |= doubtful;
    if (pieces >= max_pieces) break;
#endif
    COUNT(active)
    const F from = TO_F(position), end = from + TO_F(step);
    F a = from, b = end;
    const bool marches = ANY(marching);
    if (!marches) {
#if IRT_ALONG
      if (!ANY(cutting | proving)) {
        // All lanes wait at candidates.
        const I last = window_end(position, halt);
        window = open_window(&path, from, TO_F(last) PARAMETERS_PASS);
        // Near the floor of the precision slopes drown in rounding before signs do.
        window.steady &= GT(stop, (I)16);
        window.below = SELECT(window.rising, below, above);
        const I leaves = active & window.steady & SELECT(window.rising, above, below);
        cutting = active & ~leaves;
        position = SELECT(leaves, last, position);
        step = SELECT(leaves, min(LOWEST_BIT(last), halt), step);
        stop = SELECT(leaves, first_stop, stop);
        halt = SELECT(leaves, first_halt, halt);
        active &= ~(leaves & GE(last, PATH_END));
        marching = active & leaves;
        continue;
      }
      if (ANY(cutting)) {
        a = b = R(0.5) * (window.lo + window.hi);
      } else
#endif
      {
        const F behind = max(min(end + margin, path.in1), path.in0);
        const I start = ~((above | below) & GE(from, path.in0)) & ~asked;
        b = SELECT(start, max(from, path.in0), behind);
        // A sign that is asked for is that of all up to the first place that surely counts: a root before it may count.
#if IRT_PARTIAL || IRT_CLIP
        a = SELECT(start | checking, from, b);
#else
        a = SELECT(start, from, b);
#endif
      }
    }
    I undefined, rough;
    REGION_VARIABLES
    const FORM f = enclose(&path, a, b PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    const I is_above = positive(f) & ~undefined, is_below = negative(f) & ~undefined;
    if (marches) {
      const I skips = marching & (is_above | is_below | undefined | outside), deeper = marching & ~skips, stops = deeper & LE(step, halt);
      const I next = position + step, ended = skips & GE(next, PATH_END);
      above = SELECT(skips, is_above, above);
      below = SELECT(skips, is_below, below);
      step = SELECT(skips, min(LOWEST_BIT(next), step << 1), SELECT(deeper & ~stops, step >> 1, step));
      position = SELECT(skips, next, position);
      active &= ~ended;
      marching &= ~(ended | stops);
      if (ANY(stops)) {
        const I found = stops & crosses(f) & ~rough & inside & GE(from, path.in0) & LE(end, path.in1);
        near = SELECT(found, from, near);
        far = SELECT(found, end, far);
        hits |= found;
        active &= ~found;
        wild = SELECT(stops, unbounded(f), wild);
#if !IRT_ALONG
        const I coarse = stops & ~found & GT(step, stop);
        step = SELECT(coarse, step >> 1, step);
        halt = SELECT(coarse, stop, halt);
        marching |= coarse;
        proving |= stops & ~found & ~coarse;
        margin = SELECT(stops, MARGIN * TO_F(step), margin);
        asked = SELECT(stops, NONE, asked);
        tries = SELECT(stops, NONE, tries);
#endif
      }
      continue;
    }
#if IRT_ALONG
    if (ANY(cutting)) {
      const I steady = cutting & window.steady, loose = cutting & ~steady, last = window_end(position, halt);
      const F width = window.hi - window.lo, clear = free_units(&window, a, f);
      const I passes = loose & GE(clear, a - from), dull = loose & ~passes, coarse = dull & GT(halt, stop), tries_behind = dull & ~coarse;
      newton_cut(&window, a, f, steady);
      const I gone = steady & GT(window.lo, window.hi), pinned = steady & ~gone & GE(window.lo, path.in0) & LE(window.hi, path.in1);
      const I found = pinned & window.below & window.above & LE(window.hi - window.lo, wanted);
      const I stuck = steady & ~gone & ~found & GE(window.hi - window.lo, R(0.75) * width);
      near = SELECT(found, window.lo, near);
      far = SELECT(found, window.hi, far);
      // Where the march goes on, and the sign of f there, if it is known.
      const I next = SELECT(passes, TO_I(floor(min(a + clear, TO_F(last)))) & -halt, SELECT(gone, last, max(position, TO_I(floor(window.lo)) & -max(stop >> 4, (I)1))));
      const I before = (gone | stuck) & window.below & GE(window.lo, TO_F(next)) & GT(next, position), behind = gone & ~before & window.above;
      const I moved = before | gone | passes, ended = (gone | passes) & GE(next, PATH_END), goes = gone | stuck | passes;
      above = SELECT(moved, (passes & is_above) | (before & ~window.rising) | (behind & window.rising), above);
      below = SELECT(moved, (passes & is_below) | (before & window.rising) | (behind & ~window.rising), below);
      position = SELECT(goes, next, position);
      step = SELECT(goes, min(LOWEST_BIT(next | PATH_END), SELECT(stuck, step, halt)), SELECT(coarse, min(step, max(halt >> 2, stop)), step));
      stop = SELECT(gone | passes, first_stop, SELECT(stuck, max(stop >> 4, (I)1), stop));
      halt = SELECT(gone | passes, first_halt, SELECT(stuck, stop, SELECT(coarse, max(halt >> 2, stop), halt)));
      hits |= found;
      active &= ~(found | ended);
      marching |= (goes & ~ended) | coarse;
      proving |= tries_behind;
      margin = SELECT(tries_behind, MARGIN * TO_F(step), margin);
      asked = SELECT(tries_behind, NONE, asked);
      tries = SELECT(tries_behind, NONE, tries);
      cutting &= ~(found | goes | dull);
      continue;
    }
#endif
    const F behind = b;
    const I known = (above | below) & GE(from, path.in0), start = proving & ~known & ~asked;
    const I tried = proving & ~start;
    above = SELECT(start, is_above, above);
    below = SELECT(start, is_below, below);
    asked |= start;
    JUDGE(tried)
    const I last = LE(step, (I)1), room = (above | below) & LE(R(2.0) * (behind - from), wanted);
    const I widens = failed & (last | room) & LT(tries, (I)WIDENINGS) & LT(behind, path.in1);
    const I gives_up = failed & last & ~widens, halves = failed & ~last & ~widens;
    near = SELECT(proven, max(from, path.in0), near);
    far = SELECT(proven, behind, far);
    hits |= proven;
    open |= gives_up;
    tries -= widens;
    margin = SELECT(widens, SELECT(last, WIDER * margin, margin + (behind - from)), margin);
    stop = SELECT(halves, max(stop >> 1, (I)1), stop);
    halt = SELECT(halves, stop, halt);
    step = SELECT(halves, step >> 1, step);
    active &= ~(proven | gives_up);
    marching = halves;
    proving &= ~(proven | gives_up | halves);
  }
  // Lanes that are still active have spent their budget.
  const F from = TO_F(position), end = from + TO_F(step);
  const I status = SELECT(hits, HIT, SELECT(open & ~wild, TOUCH, SELECT(open | active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, SELECT(hits, near, from), SELECT(hits, far, end));
  REPORT_COUNT
  return root;
}
#else
// As the paper does: the first piece that is short enough ends the search. HIT where the computed signs at its ends differ.
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  const I stop = longest_step(wanted_units(ray, &path, q));
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
