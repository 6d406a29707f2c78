// Mitchell's method (S3; Mitchell, Graphics Interface 1990): a piece of ray on which the enclosure of f excludes zero holds no root, and
// one on which the enclosure of the derivative along the ray excludes zero holds one at most. What neither tells is halved, nearer half first; a
// root that is isolated is closed in on by a safeguarded Newton step.
//
// Deviations from S3: pieces are counted as in bisection.cl, where S3 recurses. The derivative is enclosed for all lanes of a packet at once
// that wait for it. Where it keeps its sign, steps go along secants, and what the bounds of the slope cut away at either end has a proven
// sign (isolate.cl): a step needs no bracket before it, cannot leave the piece, and proves a bracket or that there is no root. By
// intervals the mean value theorem (S3's centered form) clears pieces in which f is not monotone as well. S3 takes a piece shorter than eps for a
// root; with IRT_OUTWARD it is a candidate and proven as in bisection.cl: sign at the start known, opposite sign behind the end, f
// continuous between, inside the clip region where there is one (IRT_CLIP). So multiple roots are found that no derivative isolates.
#define OVERLAP R(0.125)  // of a piece: windows look so far behind its end, for roots on it
#define FIRST_STEP (PATH_END >> 2)
#define TIGHT R(4.0)     // slopes within this factor: what does not close in any more is rounding

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  const F wanted = wanted_units(ray, &path, q);
  F stop = max(wanted / (R(1.0) + MARGIN), (F)1);
  I active = LE(range->out0, range->out1), hits = NONE, open = NONE, wild = NONE;
  I position = NONE, step = FIRST_STEP;
  I above = NONE, below = NONE;  // the sign of f at `position`, if it is known
  I proving = NONE, asking = NONE, checking = NONE, tries = NONE;
  F margin = (F)0, near = (F)0, far = (F)0;
#if IRT_ALONG
  I waiting = NONE, cutting = NONE, confirming = NONE, central = NONE;
  F guess = (F)0, last_guess = (F)0, last_value = (F)0;
  WINDOW window;
  window.lo = window.hi = window.least = window.most = (F)0;
  window.below = window.above = window.steady = window.rising = NONE;
#define ISOLATING (waiting | cutting | confirming)
#else
#define ISOLATING NONE
#endif
  COUNT_FROM_HERE
  for (int pieces = 0; pieces < max_pieces && ANY(active); ++pieces) {
    COUNT(active)
    const F from = TO_F(position), end = from + TO_F(step);
    const I marching = active & ~(ISOLATING | proving), next = position + step;
    // Of a candidate: the sign at its start, up to where all counts, where it is not known, the sign behind it, and that all between is continuous and inside.
    const F start = max(from, path.in0), behind = max(min(end + margin, path.in1), path.in0);
    F a = SELECT(proving & ~asking, SELECT(checking, start, behind), from), b = SELECT(proving, SELECT(asking, start, behind), end);
#if IRT_ALONG
    a = SELECT(cutting, guess, SELECT(confirming, window.lo, a));
    b = SELECT(cutting, guess, SELECT(confirming, window.hi, b));
#endif
    I undefined, rough;
    REGION_VARIABLES
    const FORM f = enclose(&path, a, b PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    const I is_above = positive(f) & ~undefined, is_below = negative(f) & ~undefined;
    I skips = marching & (is_above | is_below | undefined | outside), deeper = marching & ~skips;
    wild = SELECT(deeper, unbounded(f), wild);
    above = SELECT(skips, is_above, above);
    below = SELECT(skips, is_below, below);

#if IRT_ALONG
    waiting |= deeper;
    deeper = NONE;
    if (ANY(cutting | confirming)) {
      const I steady = cutting & window.steady, loose = cutting & ~steady;
      const F width = window.hi - window.lo;
      newton_cut(&window, guess, form_range(f), steady);
      const F rest = window.hi - window.lo;
      const I gone = steady & LT(rest, (F)0), drowned = steady & ~gone & central & GE(rest, R(0.75) * width);
      const I pinned = steady & ~gone & window.below & window.above & GE(window.lo, path.in0) & LE(window.hi, path.in1);
      const I closed = pinned & (LE(rest, min(wanted, TO_F(step))) | (drowned & LE(window.most, TIGHT * window.least)));
#if IRT_CLIP
      const I found = confirming & inside, elsewhere = confirming & outside & ~inside, fails = confirming & ~(inside | outside);
      confirming = closed;
#else
      const I found = closed, elsewhere = NONE, fails = NONE;
#endif
      const I passes = loose & GE(free_units(&window, guess, form_range(f)), R(0.5) * TO_F(step));
      hits |= found;
      near = SELECT(found, window.lo, near);
      far = SELECT(found, window.hi, far);
      active &= ~found;
      skips |= gone | passes | elsewhere;
      above = SELECT(gone | passes, is_above, SELECT(elsewhere, window.rising, above));
      below = SELECT(gone | passes, is_below, SELECT(elsewhere, ~window.rising, below));
      const I gives_up = (drowned & ~closed) | fails;
      deeper |= gives_up | (loose & ~passes);
      cutting &= ~(closed | gone | loose | gives_up);
      // Along the secant through what is known, or to the middle where that shortened the window too little.
      const F value = form_middle(f), secant = guess - value * ((guess - last_guess) / (value - last_value)), middle = R(0.5) * (window.lo + window.hi);
      const I sound = GT(secant, window.lo) & LT(secant, window.hi) & LE(rest, R(0.5) * width);
      last_guess = guess;
      last_value = value;
      central = ~sound;
      guess = SELECT(sound, secant, middle);
    }
#endif
    if (ANY(proving)) {
      const I answers = active & asking, tried = active & proving & ~asking;
      JUDGE(tried)
      AFTER_FAILURE(failed, LE(step, (I)1), WIDENINGS)
      above = SELECT(answers, is_above, above);
      below = SELECT(answers, is_below, below);
      hits |= proven;
      open |= gives_up;
      near = SELECT(proven, start, near);
      far = SELECT(proven, behind, SELECT(gives_up, end, far));
      active &= ~(proven | gives_up);
      tries -= widens;
      margin = SELECT(widens, WIDER * margin, margin);
      asking = NONE;
      proving &= ~(proven | gives_up | halves);
      stop = SELECT(halves, max(R(0.25) * stop, (F)1), stop);
      // The sign that is known may be that at in0.
      const I late = halves & LT(from, path.in0);
      above &= ~late;
      below &= ~late;
      deeper |= halves;
    }

    const I longer = min(LOWEST_BIT(next), step << 1);
#if IRT_ALONG
    if (ANY(waiting) && !ANY((active & ~(ISOLATING | proving)) | deeper)) {
      const F reach = min(fma((F)OVERLAP, TO_F(step), end), TO_F(PATH_END));
      const WINDOW w = open_window(&path, from, reach PARAMETERS_PASS);
      window.lo = SELECT(waiting, w.lo, window.lo);
      window.hi = SELECT(waiting, w.hi, window.hi);
      window.least = SELECT(waiting, w.least, window.least);
      window.most = SELECT(waiting, w.most, window.most);
      window.steady = SELECT(waiting, w.steady, window.steady);
      window.rising = SELECT(waiting, w.rising, window.rising);
      window.below = SELECT(waiting, SELECT(w.rising, below, above), window.below);
      window.above &= ~waiting;
      guess = SELECT(waiting, R(0.5) * (from + SELECT(w.steady, reach, end)), guess);
      last_guess = SELECT(waiting, guess, last_guess);
      central |= waiting;
      // What goes away from zero has no root; what may turn is worth a look at its middle where its slopes are bounded.
      const I leaves = waiting & w.steady & SELECT(w.rising, above, below), dull = waiting & ~w.steady & (FORM_IS_RANGE ? EQ(w.least, (F)0) : ALL);
      skips |= leaves;
      deeper |= dull;
      cutting |= waiting & ~(leaves | dull);
      waiting = NONE;
    }
#endif
    const I candidate = deeper & LE(TO_F(step), stop), halved = deeper & ~candidate;
    position = SELECT(skips, next, position);
    step = SELECT(skips, longer, SELECT(halved, step >> 1, step));
    active &= ~(skips & GE(next, PATH_END));
    proving |= candidate;
    asking |= candidate & ~((above | below) & GE(from, path.in0));
    tries = SELECT(candidate, NONE, tries);
    margin = SELECT(candidate, MARGIN * TO_F(step), margin);
  }
  // Lanes that are still active have spent their budget.
  const F from = TO_F(position);
  const I status = SELECT(hits, HIT, SELECT(open & ~wild, TOUCH, SELECT(open | active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, SELECT(hits, near, from), far);
  REPORT_COUNT
  return root;
}
