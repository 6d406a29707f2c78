// Root finders that cut Bezier pieces (S2 section 4.2), one after the other: of a piece whose signs may change, the part before the cut
// comes first; when it is proven free of zeros the part behind follows, taken anew from the cell's own coefficients where the
// march had left it. Nothing is kept on a stack.
//
// The method's file says where to cut: `cut_of`. With IRT_OUTWARD a sign counts only beyond the error that the coefficients carry, and
// a hit is a bracket between two evaluations, of the only root that is left.
#define MOST_CUTS 80
#define PATIENCE 16  // cuts after which pieces are halved, down to the floor of the precision
#define MOST_WIDENINGS ((I)4)  // each by four

// Where to cut a piece, as a share of it; `sign` is that of the polynomial at its start.
static inline F cut_of(const F* c, F sign, F last, F before, F a, F b);

static void search_cell(const CELL* cell, I lanes, const int max_pieces, FOUND* found) {
  F c[N], front[N], rest[N];
  F a = cell->lo, b = cell->hi, error = begin_with(cell, lanes, c);
  // No sign changes before the first root.
  const F sign = SELECT(LT(c[0], (F)0), (F)-1, (F)1);
  F size = largest_of(c);
  F last = (F)-4, before = (F)-8;  // the latest estimates of the root
  I widenings = NONE, isolated = NONE;  // exactly one root is left in the piece
  for (int n = 0; n < MOST_CUTS && n < max_pieces && ANY(lanes); ++n) {
    COUNT(lanes)
    isolated |= one_root(c, error, sign);
    // While there may be more roots than one, a little behind: a cut in a root would leave its sign unknown on both sides.
    const F cut = cut_of(c, sign, last, before, a, b), beyond = max(R(4.0) * cell->reach / (b - a), (F)R(0.015625));
    const F wished = SELECT(isolated, cut, cut_near(cell, n, a, b, min(cut + beyond, R(0.5) + R(0.5) * cut))), share = n < PATIENCE ? wished : (F)HALF_AND_A_LITTLE;
    const F x = fma(share, b - a, a);
    cut_at(c, share, front, rest);
    const F next_error = fma((F)CUT_ERROR, size, error), at_cut = sign * rest[0];
    const I settled = lanes & isolated & (LT(fabs(x - last), cell->reach) | LE(fabs(at_cut), next_error) | LT(b - a, cell->reach));
    I failed = NONE;
    if (ANY(settled)) {
      const F width = cell->reach * TO_F((I)1 << (widenings + widenings));
      const F zero = fma(polygon_zero(c, sign), b - a, a), lo = max(zero - width, a), hi = min(zero + width, b);
      const I good = settled & brackets(cell, lo, hi, sign), counts = GE(lo, cell->in_lo) & LE(hi, cell->in_hi);
      failed = settled & ~good;
      const I given_up = (failed & GE(widenings, MOST_WIDENINGS)) | (good & ~counts);
      widenings -= failed;
      found->hits |= good & counts;
      found->touches |= given_up;
      found->lo = SELECT(good | given_up, lo, found->lo);
      found->hi = SELECT(good | given_up, hi, found->hi);
      lanes &= ~(good | given_up);
    }
    const I free = one_sign(front, next_error);
    const I moves = lanes & ~failed, behind = moves & (free | (isolated & GT(at_cut, (F)0))), ahead = moves & ~behind;
    before = SELECT(moves, last, before);
    last = SELECT(moves, x, last);
    lanes &= ~go_on(cell, x, front, rest, next_error, behind, ahead, c, &a, &b, &error);
    size = largest_of(c);
    const I stuck = lanes & ~settled & ~isolated & at_floor(b - a, size, error);
    found->touches |= stuck;
    found->lo = SELECT(stuck, a, found->lo);
    found->hi = SELECT(stuck, b, found->hi);
    lanes &= ~stuck;
  }
  found->spent |= lanes;
  found->lo = SELECT(lanes, a, found->lo);
  found->hi = SELECT(lanes, b, found->hi);
}

#define NARROWEST R(0.00390625)  // a cut leaves at least this share on both sides
