// Root finders that insert knots (Morken and Reimers; S2 section 4.2): the polynomial is a spline, and a knot goes in where its control polygon
// has its first zero. The polygon converges to the spline around it, and to the first root, without any subdivision.
//
// The method's file says where the knot goes: `knot_of`. Before the knot at which the first coefficient that may have the other sign
// begins to count, the spline is proven free of zeros (all coefficients that count there have one sign).
#define PATIENCE (24 + 4 * IRT_DEGREE)  // knots after which brackets that guards do not close widen
#define MOST_KNOTS (PATIENCE + 24)
#define MOST_COEFFICIENTS (N + MOST_KNOTS)
#define MOST_WIDENINGS ((I)4)  // each by four

static inline F knot_of(F zero, F last, F before);

static void search_cell(const CELL* cell, I lanes, const int max_pieces, FOUND* found) {
  F c[MOST_COEFFICIENTS], t[MOST_COEFFICIENTS + N];
  for (int k = 0; k < N; ++k) {
    t[k] = (F)0;
    t[N + k] = (F)1;
  }
  F error = begin_with(cell, lanes, c);
  const F start = cell->lo, length = cell->hi - cell->lo;
  const F sign = SELECT(LT(c[0], (F)0), (F)-1, (F)1);
  F last = (F)-4, before = (F)-8;
  I widenings = NONE, isolated = NONE;  // exactly one root is left
  for (int count = N; ANY(lanes); ++count) {
    COUNT(lanes)
    // The first coefficient that may be of the other sign, the polygon's zero before it, and how often signs change.
    F sum = (F)0;
    for (int i = 1; i <= IRT_DEGREE; ++i) sum += t[i];
    F zero = (F)1, free_until = (F)1, place = sum * (R(1.0) / IRT_DEGREE), doubt = place;
    I seen = LE(sign * c[0], error), other = NONE, doubtful = NONE, bad = seen, crossed = NONE;
    free_until = SELECT(seen, (F)0, free_until);
    for (int i = 1; i < count; ++i) {
      sum += t[i + IRT_DEGREE] - t[i];
      const F next = sum * (R(1.0) / IRT_DEGREE), v = sign * c[i];
      const I is_same = GT(v, error), is_other = LT(v, -error), first = ~seen & ~is_same, crosses = ~crossed & LE(v, (F)0);
      const F p = fabs(c[i - 1]);
      zero = SELECT(crosses, fma(p / max(p + fabs(v), (F)TINY), next - place, place), zero);
      free_until = SELECT(first, t[i], free_until);
      doubt = SELECT(first, next, doubt);
      bad |= ~is_other & (other | doubtful);
      doubtful |= ~(is_other | is_same);
      other |= is_other;
      seen |= first;
      crossed |= crosses;
      place = next;
    }
    lanes &= seen;  // the others are free of zeros
    isolated |= other & ~bad;
    zero = SELECT(crossed, zero, doubt);
    const F x = fma(clamp(zero, (F)0, (F)1), length, start), free = fma(free_until, length, start);
    const F width = cell->reach * TO_F((I)1 << (widenings + widenings));
    const I settled = lanes & ((isolated & (LT(fabs(x - last), cell->reach))) | (other & LT(x - free, width)));
    // Guards that prove no more: error keeps them from the root.
    if (count - N >= PATIENCE && count % 4 == 0) widenings -= lanes & ~settled & LT(fabs(x - last), R(0.125) * cell->reach) & LT(widenings, MOST_WIDENINGS);
    if (ANY(settled)) {
      const F lo = SELECT(isolated, max(x - width, start), free), hi = min(x + width, cell->hi);
      const I good = settled & brackets(cell, lo, hi, sign), counts = GE(lo, cell->in_lo) & LE(hi, cell->in_hi);
      const I failed = settled & ~good, given_up = (failed & GE(widenings, MOST_WIDENINGS)) | (good & ~counts);
      widenings -= failed & LT(fabs(x - last), R(0.125) * cell->reach);
      found->hits |= good & counts;
      found->touches |= given_up;
      found->lo = SELECT(good | given_up, lo, found->lo);
      found->hi = SELECT(good | given_up, hi, found->hi);
      lanes &= ~(good | given_up);
    }
    const bool full = count >= MOST_COEFFICIENTS - 1;
    if (full || count - N >= max_pieces) {
      // Knots gather at the first coefficient in doubt: what is zero there within the error, more of them would not decide.
      const F middle = fma(doubt, length, start), v = value_at(cell->c, IRT_DEGREE, middle);
      const I drowns = LE(fabs(v), fma((F)VALUE_ERROR, cell->size, error));
      found->touches |= full ? lanes & drowns : NONE;
      found->spent |= full ? lanes & ~drowns : lanes;
      found->lo = SELECT(lanes, free, found->lo);
      found->hi = SELECT(lanes, middle + (middle - free), found->hi);
      return;
    }
    // Where more roots may follow, knots a little before the root have to prove that it is the first.
    const I guards = ~isolated & LT(fabs(x - last), R(0.25) * cell->reach);
    const F place_of = SELECT(guards, max(x - R(0.5) * cell->reach, R(0.5) * (free + x)), knot_of(x, last, before));
    const F own = clamp(place_of - start, (F)0, length) / max(length, (F)TINY), knot = SELECT(isolated, own, cut_near(cell, count - N, start, cell->hi, own));
    before = last;
    last = x;
    // Boehm's insertion, over all coefficients: those that it does not concern get the weights 0 and 1.
    c[count] = c[count - 1];
    for (int i = count; i > 0; --i) {
      const F weight = clamp((knot - t[i]) / max(t[i + IRT_DEGREE] - t[i], (F)TINY), (F)0, (F)1);
      c[i] = mixed(c[i - 1], c[i], weight);
    }
    for (int i = count + N; i > 0; --i) t[i] = max(t[i - 1], i == count + N ? (F)1 : min(t[i], knot));
#if IRT_OUTWARD
    // A weight errs by 1.75, times a difference of two sizes; that, its product and its sum are rounded.
    error = fma((F)(R(4.5) * ULP), cell->size, error);
#endif
  }
}
