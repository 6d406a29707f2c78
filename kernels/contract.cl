// Contraction: on a piece of ray the affine form x + y e +- z of f, e in [-1, 1], has zeros only where e lies between (-x - z) / y and
// (-x + z) / y. What lies before is skipped, what lies behind is kept in mind, and the march goes on with what is left.
//
// Not in the papers. As z shrinks with the square of the length, it converges quadratically at simple roots, without stack
// or derivative. Positions and steps are whole units of the path, so that pieces are exact, and contraction rounds outward to
// units. A form that is positive at one end of the piece and negative at the other, by more than z, has proven both signs: where what
// is left is short enough it is a HIT. Where that does not happen (f is a range there, or rounding drowns it) candidates are
// proven as in bisection.cl: sign at the start known, opposite sign behind the end, f continuous between, all of it inside the
// clip region where there is one (IRT_CLIP).
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
#define FIRST_STEP (PATH_END >> 3)
// How far the rounding of a contracted end may be off, in units.
#define SLACK R(0.75)
#define FLOOR ((I)4)  // units: no contracted piece is much shorter, because its ends are rounded outward
#define BLUNT ((I)64)  // units: below, what contraction cannot shorten only rounding keeps it from shortening

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

// What is left of a piece, in units, and whether the form has proven signs before and behind it.
typedef struct {
  I from, end;
  I before, behind;  // where something was cut away
  I above_before, above_behind;
} CUT;

static inline CUT contract(FORM f, I from, I step) {
  CUT cut;
  cut.from = from;
  cut.end = from + step;
#if FORM_IS_RANGE
  cut.before = cut.behind = cut.above_before = cut.above_behind = NONE;
#else
  const F start = TO_F(from), length = TO_F(step), inverse = R(1.0) / f.y;
#if IRT_OUTWARD
  const F z = fma((F)(R(4.0) * ULP), fabs(f.x) + fabs(f.y) + f.z, f.z);
#else
  const F z = f.z;
#endif
  const F p = (-f.x - z) * inverse, q = (-f.x + z) * inverse;
  // Shares of the piece, 0 to 1. Where y is zero nothing is known; clamp would let nan pass.
  const I known = LT(fabs(p) + fabs(q), INF);
  const F first = SELECT(known, clamp(fma((F)R(0.5), min(p, q), (F)R(0.5)), (F)0, (F)1), (F)0);
  const F last = SELECT(known, clamp(fma((F)R(0.5), max(p, q), (F)R(0.5)), (F)0, (F)1), (F)1);
  const F off = fma((F)(R(16.0) * ULP), length, (F)SLACK);
  const F low = floor(fma(length, first, -off)), high = ceil(fma(length, last, off));
  cut.before = GT(low, (F)0);
  cut.behind = LT(high, length);
  cut.from = from + SELECT(cut.before, TO_I(low), NONE);
  cut.end = SELECT(cut.behind, from + TO_I(high), cut.end);
  cut.above_before = GT(f.x, f.y);
  cut.above_behind = GT(f.x, -f.y);
#endif
  return cut;
}

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  // The longest bracket, and the longest step whose piece and margin make one.
  const F wanted = clamp((F)EPS / (NARROW(ray->length) * path.unit) * (R(1.0) - R(8.0) * ULP), (F)1, TO_F(PATH_END));
  const I widest = TO_I(floor(wanted));
#if IRT_OUTWARD
  I stop = max(TO_I(floor(wanted / (R(1.0) + MARGIN))), (I)1);
#else
  I stop = widest;
#endif
  I active = LE(range->out0, range->out1), hits = NONE, open = NONE;
  I position = NONE, step = NONE, tries = NONE, proving = ALL, clear = NONE;
  I above = NONE, below = NONE;  // the sign of f at `position`, or at in0 where that lies ahead, if it is known
  I bracketed = NONE;            // the signs at both ends of the piece are proven opposite
  I wild = NONE;                 // the enclosure of the candidate is infinite
  F margin = max(path.in0, (F)0), far = (F)0;
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
    const I skips = marches & (is_above | is_below | undefined | outside), left = marches & ~skips;
    const CUT cut = contract(f, position, step);
    const I rest = cut.end - cut.from;
#if IRT_PARTIAL
    // A form says nothing of where f is undefined or jumps: then nothing is cut, the piece is halved.
    const I cuts = left & ~rough;
#else
    const I cuts = left;
#endif
    const I before = cuts & cut.before, known_above = SELECT(before, cut.above_before, above), known_below = SELECT(before, ~cut.above_before, below);
    const I crossing = cuts & cut.behind & ((known_above & ~cut.above_behind) | (known_below & cut.above_behind));
    const I lies_inside = GE(TO_F(cut.from), path.in0) & LE(TO_F(cut.end), path.in1);
    const I shorter = cuts & LE(rest, step - max(step >> 2, (I)1)), pinned = cuts & (crossing | bracketed);
    const I found = pinned & lies_inside & inside & (LE(rest, max(widest, FLOOR)) | (~shorter & LE(rest, BLUNT)));
    const I deeper = left & ~found, candidate = deeper & LE(step, stop), moves = deeper & ~candidate;
    const I opposite = tried & ((above & is_below) | (below & is_above));
#if IRT_PARTIAL || IRT_CLIP
    const I proven = tried & checking & inside & ~rough, failed = tried & ~proven & (~opposite | checking);
    checking = opposite & ~checking;
#else
    const I proven = opposite, failed = tried & ~opposite;
#endif
#if IRT_OUTWARD
    const I last = LE(step, (I)1), widens = failed & last & LT(tries, (I)WIDENINGS) & LT(behind, path.in1);
    const I gives_up = failed & last & ~widens, halves = failed & ~last;
#else
    // As the papers do: the first piece that is short enough ends the search; HIT where the computed signs at its ends differ.
    const I widens = NONE, gives_up = failed, halves = NONE;
#endif
    far = SELECT(found, TO_F(cut.end), SELECT(proven, behind, far));
    hits |= proven | found;
    open |= gives_up;
    // Everything before `clear` and behind the piece is free of zeros.
    const I next = max(position + step, clear);
    active &= ~(proven | found | gives_up | (skips & GE(next, PATH_END)));
    wild = SELECT(candidate, unbounded(f), wild);
    tries = SELECT(candidate, NONE, tries - widens);
    margin = SELECT(candidate, MARGIN * (end - from), SELECT(widens, WIDER * margin, margin));
    stop = SELECT(halves, max(stop >> 4, (I)1), stop);
    // What lies before in0 may lie outside the bounds: a change of sign there would be no hit.
    const I counts = starts | (skips & GE(TO_F(next), path.in0)), moved = (found | moves) & GE(TO_F(cut.from), path.in0);
    above = SELECT(counts, is_above, SELECT(moved, known_above, above));
    below = SELECT(counts, is_below, SELECT(moved, known_below, below));
    proving = SELECT(starts | halves, NONE, proving | candidate);
    // Pieces that contraction hardly shortens are halved; what is behind the half is then not clear.
    const I shrinks = moves & shorter, halved = max(SELECT(moves & cuts, rest, step) >> 1, (I)1);
    clear = SELECT(shrinks, max(clear, position + step), SELECT(moves | halves | skips, NONE, clear));
    bracketed = shrinks & pinned;
    const I longer = min(max(step << 1, next - position), PATH_END - next);
    step = SELECT(skips, longer, SELECT(shrinks, rest, SELECT(moves | halves, halved, SELECT(starts, (I)FIRST_STEP, step))));
    position = SELECT(skips, next, SELECT(found | (moves & cuts), cut.from, position));
  }
  // Lanes that are still active have spent their budget.
  const F from = TO_F(position), end = from + TO_F(step);
  const I status = SELECT(hits, HIT, SELECT(open & ~wild, TOUCH, SELECT(open | active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, from, SELECT(hits, far, end));
  REPORT_COUNT
  return root;
}
