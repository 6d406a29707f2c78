// frustum-newton: ours, the fastest of the frustum form's root finders. As the yardstick of hand-written kernels does, it separates roots
// by cutting and then leaves Bezier pieces alone: an evaluation costs as many multiplications as a cut has rounds.
//
// The root of a piece that has exactly one is closed in on by Halley's steps, each of which trebles the digits that are known, and proven between two
// evaluations beyond all error.
#define MOST_HALVINGS 80
#define MOST_ROUNDS 12
#define MOST_WIDENINGS 5  // each by four
#define NARROWEST R(1e-4)

// The root within [a, b] of the lanes given; c is the polynomial there, positive (times sign) at a and negative at b. Every step is followed by an
// attempt to prove the bracket around it: the attempt is the test of convergence. Steps that leave the bracket of signs, or do not halve, give way to its middle.
static inline void close_in(const CELL* cell, const F* c, F a, F b, F sign, I lanes, FOUND* found) {
  const F length = b - a, near = cell->reach * R(0.25) / max(length, (F)TINY);
  F power[N];  // coefficients of the powers of x
  EACH for (int k = 0; k < N; ++k) power[k] = sign * c[k];
  EACH for (int k = 1; k < N; ++k)
    EACH for (int i = IRT_DEGREE; i >= k; --i) power[i] -= power[i - 1];
  EACH for (int k = 0; k < N; ++k) power[k] *= (F)BINOMIAL(IRT_DEGREE, k);
  F lo = (F)0, hi = (F)1, x = polygon_zero(c, sign), step = (F)1;
  F narrowed = (F)1;  // where the bounds cut a bracket
  for (int n = 0; n < MOST_ROUNDS && ANY(lanes); ++n) {
    COUNT(lanes)
    F value = power[IRT_DEGREE], slope = (F)0, bend = (F)0;  // half the second derivative
    EACH for (int i = IRT_DEGREE - 1; i >= 0; --i) {
      bend = fma(bend, x, slope);
      slope = fma(slope, x, value);
      value = fma(value, x, power[i]);
    }
    const I left = GT(value, (F)0);  // of the root
    lo = SELECT(left, x, lo);
    hi = SELECT(left, hi, x);
    const F next = x - value * slope / fma(slope, slope, -value * bend);
    const I fast = GE(next, lo - near) & LE(next, hi + near) & LE(fabs(next - x), step);
    const F taken = SELECT(fast, next, R(0.5) * (lo + hi));
    step = max(R(0.5) * fabs(taken - x), near);
    x = taken;
    // The last rounds take wider and wider brackets.
    const int widenings = max(0, n - (MOST_ROUNDS - 1 - MOST_WIDENINGS));
    const F middle = fma(x, length, a), width = cell->reach * narrowed * (real)(1 << (2 * widenings));
    const F from = max(middle - width, a), to = min(middle + width, b);
    const I good = lanes & brackets(cell, from, to, sign), counts = GE(from, cell->in_lo) & LE(to, cell->in_hi);
    const I shorter = good & ~counts & GT(narrowed, (F)NARROWEST), done = good & ~shorter;
    narrowed = SELECT(shorter, narrowed * R(0.0625), narrowed);
    found->hits |= done & counts;
    found->touches |= done & ~counts;
    found->lo = SELECT(lanes, from, found->lo);
    found->hi = SELECT(lanes, to, found->hi);
    lanes &= ~done;
  }
  found->touches |= lanes;
}

// Where the control polygon of the derivative first says that the polynomial, positive (times sign), has come down and turns, as a share of the piece: cut
// there, two roots close together stand alone, and what nearly has two has none, where halving needs a cut for each digit.
static inline F valley_of(const F* c, F sign) {
  F at = (F)0, down = (F)0, up = (F)1, before = sign * (c[1] - c[0]);
  I seen = NONE;
  EACH for (int k = 1; k < IRT_DEGREE; ++k) {
    const F step = sign * (c[k + 1] - c[k]);
    const I turns = ~seen & LT(before, (F)0) & GE(step, (F)0);
    at = SELECT(turns, (F)(k - 1), at);
    down = SELECT(turns, -before, down);
    up = SELECT(turns, step, up);
    seen |= turns;
    before = step;
  }
  const F share = (at + down / (down + up)) * (R(1.0) / max(IRT_DEGREE - 1, 1));
  return SELECT(seen, clamp(share, (F)R(0.0625), (F)R(0.9375)), (F)HALF_AND_A_LITTLE);
}

static void search_cell(const CELL* cell, I lanes, const int max_pieces, FOUND* found) {
  F c[N], front[N], rest[N];
  F a = cell->lo, b = cell->hi, error = begin_with(cell, lanes, c);
  // No sign changes before the first root.
  const F sign = SELECT(LT(c[0], (F)0), (F)-1, (F)1);
  lanes &= ~one_sign(c, error);
  F size = largest_of(c);
  I isolated = lanes & one_root(c, error, sign);
  I moves = lanes & ~isolated, stuck = NONE;
  for (int n = 0; n < MOST_HALVINGS && n < max_pieces && ANY(moves); ++n) {
    COUNT(moves)
    const F share = cut_near(cell, n, a, b, n % 4 == 3 ? (F)HALF_AND_A_LITTLE : valley_of(c, sign)), x = fma(share, b - a, a), next_error = fma((F)CUT_ERROR, size, error);
    cut_at(c, share, front, rest);
    const EXTENT before = extent_of(front), after = extent_of(rest);
    const I behind = moves & has_one_sign(before, next_error), ahead = moves & ~behind, whole = has_one_sign(after, next_error);
    // Of what the march goes on with, or more: extents of the new coefficients are these two, or the cell's.
    size = SELECT(behind, SELECT(whole, cell->size, largest_in(after)), SELECT(ahead, largest_in(before), size));
    const I done = go_on(cell, x, front, rest, next_error, behind, ahead, c, &a, &b, &error);
    moves &= ~done;
    lanes &= ~done;
    const I alone = moves & one_root(c, error, sign);
    isolated |= alone;
    moves &= ~alone;
    stuck |= moves & at_floor(b - a, size, error);
    moves &= ~stuck;
  }
  const I open = lanes & ~isolated;
  found->touches |= stuck;
  found->spent |= moves;
  found->lo = SELECT(open, a, found->lo);
  found->hi = SELECT(open, b, found->hi);
  if (ANY(isolated)) close_in(cell, c, a, b, sign, isolated, found);
}
