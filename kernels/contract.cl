// Contraction: on a piece of ray the affine form x + y e +- z of f, e in [-1, 1], has zeros only where e lies between (-x - z) / y and
// (-x + z) / y. What lies before is skipped, what lies behind is kept in mind, and the march goes on with what is left.
//
// Not in the papers. As z shrinks with the square of the length, it converges quadratically at simple roots, without stack
// or derivative. Positions and steps are whole units of the path, so that pieces are exact, and contraction rounds outward to
// units. A form that is positive at one end of the piece and negative at the other, by more than z, has proven both signs: where what
// is left is short enough it is a HIT. Where that does not happen (f is a range there, or rounding drowns it) a short piece is a
// candidate and is proven as in bisection.cl: sign at the start known, opposite sign behind the end, f continuous between, all of it
// inside the clip region where there is one (IRT_CLIP). Few lanes ever come to that, so its bookkeeping is left out where none has.
//
// Where all roundings of f together have a bound (IRT_SLACK), forms have that in z instead of a pad for each operation, unless it is too coarse.
#define UNITS ((F)PATH_END_REAL)
#define FIRST_STEP (IRT_SHARPENS ? UNITS : (F)(PATH_END_REAL / 8))
// Units: how far the rounding of a contracted end to units is off. What rounds nothing outward takes more, which covers most of what else is off.
#if IRT_OUTWARD
#define SLACK R(0.5)
#else
#define SLACK R(8.0)
#endif
#define FLOOR ((F)4)   // units: no contracted piece is much shorter, because its ends are rounded outward
#define BLUNT ((F)64)  // units: below, what contraction cannot shorten only rounding keeps it from shortening

// Beams halt at pieces no longer than their width along each axis together, or when they have looked at so many (the gain is flat from
// here on); their rays begin with a piece that is longer by IRT_LEAD (cpp/kernel/assemble.cpp).
#define BEAM_PIECES 32

// Whether a beam errs by no more than a fifth of how far the box reaches. Wider ones tell nothing, and f would be asked where it may overflow, which kernels are made for
// within twice the bounds only: coordinates that no plane cuts (clip.cl) reach beyond the box by five times what they err by.
#define SLENDER(axis, k) LE(fma(UNITS, path.g##axis, path.e##axis), (F)(R(0.2) * max(fabs(BOX_LO(k)), fabs(BOX_HI(k)))))

// What is left of a piece, in units, and where something was cut away.
typedef struct {
  F from, end;
  I before, behind;
} CUT;

static inline CUT contract(FORM f, F from, F step) {
  CUT cut;
#if FORM_IS_RANGE
  cut.from = from;
  cut.end = from + step;
  cut.before = cut.behind = NONE;
#else
  const F part = R(0.5) * step, inverse = R(1.0) / f.y;
#if IRT_OUTWARD
  // Covers both quotients, and by that of y, half a piece times 4 ulp, what follows.
  const F z = fma((F)(R(4.0) * ULP), fabs(f.x) + fabs(f.y) + f.z, f.z);
#else
  const F z = f.z;
#endif
  // The middle of what is left, and half of it, in halves of the piece. Where y is zero nothing is known.
  const F middle = -f.x * inverse, reach = z * fabs(inverse);
  const I known = LT(fabs(middle) + reach, (F)MODEST);
  const F low = WHOLE(fma(min(middle - reach, (F)1), part, part - SLACK)), high = WHOLE(fma(max(middle + reach, (F)-1), part, part + SLACK));
  cut.before = known & GT(low, (F)0);
  cut.behind = known & LT(high, step);
  cut.from = from + SELECT(cut.before, low, (F)0);
  cut.end = from + SELECT(cut.behind, high, step);
#endif
  return cut;
}

#if IRT_SLACK && !FORM_IS_RANGE
#define COARSE R(8.0)  // where a COARSEth of the radius is less than the bound of all roundings, pads are tighter

// f by arithmetic without pads, with the bound of all its roundings in z: x, y and z together are off by no more. `coarse`: pads would be tighter.
static inline FORM enclose_cheaply(const PATH* path, F from, F to PARAMETERS, I* coarse) {
  const F middle = R(0.5) * (from + to), span = R(0.5) * (to - from);
  const RA x = coordinate(ALONG(path, x, middle), span * path->ux, ERROR_UNTIL(path, x, to)),
           y = coordinate(ALONG(path, y, middle), span * path->uy, ERROR_UNTIL(path, y, to)),
           z = coordinate(ALONG(path, z, middle), span * path->uz, ERROR_UNTIL(path, z, to));
  const BARE f = bare(bare_ra(x.x, x.y, x.z), bare_ra(y.x, y.y, y.z), bare_ra(z.x, z.y, z.z) PARAMETERS_PASS);
  *coarse = GT(COARSE * f.slack, f.radius);
  return ra(f.form.x, f.form.y, (f.form.z + f.slack) * (R(1.0) + R(2.0) * ULP));
}
#endif

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces FINDER) {
  PATH path = make_path(ray, range, q);
  // The longest bracket, and the longest step whose piece and margin make one.
  const F wanted = clamp(wanted_units(ray, &path, q), (F)1, UNITS);
#if IRT_OUTWARD
  F stop = max(WHOLE(wanted / (R(1.0) + MARGIN) - R(0.5)), (F)1);
#else
  F stop = WHOLE(wanted - R(0.5));
#endif
  const F enough = max(wanted, FLOOR);
  F position = (F)0, step = FIRST_STEP, clear = (F)0;
  F sign = (F)0;  // positive or negative as f is at `position`, or at in0 where that lies ahead; zero: not known
  I active = LE(range->out0, range->out1), hits = NONE, open = NONE;
#if IRT_BEAMS
  if (beam) {
    // All of a beam counts, and nothing is decided of it.
    path.in0 = (F)0;
    active &= SLENDER(x, 0) & SLENDER(y, 1) & SLENDER(z, 2);
    stop = WHOLE((path.ex + path.ey + path.ez + UNITS * (path.gx + path.gy + path.gz)) / path.unit);
  } else {
    const F inverse = R(1.0) / path.unit, begin = WHOLE((head->from - path.start) * inverse - R(4.0));
    const I known = GT(begin, (F)0);
    active &= LT(begin, UNITS);
    position = SELECT(known, min(begin, UNITS), (F)0);
    sign = SELECT(known & GE(begin, path.in0), head->sign, (F)0);
    step = clamp(WHOLE(IRT_LEAD * head->span * inverse), (F)8, max(UNITS - position, (F)8));
  }
#endif
  F from = position, to = position + step;  // the piece to look at
  I bracketed = NONE;  // the signs at both ends of the piece are proven opposite
  F far = (F)0;        // the end of what is found
  // Candidates: what they try, how often, how far behind their end; and whether the enclosure was infinite.
  I proving = NONE, asking = NONE, asked = NONE, wild = NONE, tries = NONE;
  F margin = (F)0;
#if IRT_PARTIAL || IRT_CLIP
  I checking = NONE;  // the signs are proven, continuity and lying inside the clip region are not yet
#endif
  COUNT_FROM_HERE
  for (int pieces = 0; pieces < max_pieces && ANY(active); ++pieces) {
    COUNT(active)
    I undefined, rough;
    REGION_VARIABLES
#if IRT_SLACK && !FORM_IS_RANGE
    I coarse;
    FORM f = enclose_cheaply(&path, from, to PARAMETERS_PASS, &coarse);
    undefined = rough = NONE;
    if (ANY(active & coarse & ~nonzero(f))) f = enclose(&path, from, to PARAMETERS_PASS, &undefined, &rough REGION_OUT);
#else
    const FORM f = enclose(&path, from, to PARAMETERS_PASS, &undefined, &rough REGION_OUT);
#endif
    const I sure = nonzero(f) & ~undefined, marches = active & ~proving;
    const F tells = SELECT(sure, leaning(f), (F)0);
    const I skips = marches & (sure | undefined | outside), left = marches & ~skips;
    const CUT cut = contract(f, position, step);
#if IRT_PARTIAL
    // A form says nothing of where f is undefined or jumps: then nothing is cut, the piece is halved.
    const I cuts = left & ~rough;
#else
    const I cuts = left;
#endif
    const F end = position + step, rest = cut.end - cut.from, ahead = SELECT(cut.before, BEFORE(f), sign);
    const I crossing = cut.behind & LT(ahead * BEHIND(f), (F)0), pinned = cuts & (crossing | bracketed);
    const I shorter = cuts & LE(rest, R(0.75) * step), lies_inside = GE(cut.from, path.in0) & LE(cut.end, path.in1) & inside;
    const I found = pinned & lies_inside & (LE(rest, enough) | (~shorter & LE(rest, BLUNT)));
    const I deeper = left & ~found, candidate = deeper & LE(step, stop), moves = deeper & ~candidate, shrinks = moves & shorter;
    // Everything before `clear` and behind the piece is free of zeros.
    const F next = max(end, clear), longer = min(max(step + step, next - position), UNITS - next);
    // Pieces that contraction hardly shortens are halved; what is behind the half is then not clear.
    const F halved = max(WHOLE(R(0.5) * SELECT(cuts, rest, step)), (F)1);
    clear = SELECT(shrinks, next, SELECT(moves, (F)0, clear));
    bracketed = shrinks & pinned;
    hits |= found;
    far = SELECT(found, cut.end, far);
    active &= ~(found | (skips & GE(next, UNITS)));
    const I cutting = cuts & ~candidate;
    position = SELECT(skips, next, SELECT(cutting, cut.from, position));
    step = SELECT(skips, longer, SELECT(shrinks, rest, SELECT(moves, halved, step)));
    // What lies before in0 may lie outside the bounds: a change of sign there would be no hit.
    sign = SELECT((skips | cutting) & GE(position, path.in0), SELECT(skips, tells, ahead), sign);
    from = position;
    to = position + step;
    if (IRT_SHARPENS && !ANY(active)) break;  // as most packets do after one piece
    const I tried = active & proving;
#if IRT_BEAMS
    if (beam) {
      active &= ~candidate;
      continue;
    }
#endif
    if (ANY(candidate | tried)) {
      const F behind = max(min(end + margin, path.in1), path.in0);
      const I answers = tried & asking, attempted = tried & ~asking, opposite = attempted & LT(sign * tells, (F)0);
      sign = SELECT(answers, tells, sign);
#if IRT_PARTIAL || IRT_CLIP
      const I holds = attempted & checking & inside & ~rough, failed = attempted & ~holds & (~opposite | checking);
      checking = opposite & ~checking;
#else
      const I holds = opposite, failed = attempted & ~opposite;
#endif
      AFTER_FAILURE(failed, LE(step, (F)1), WIDENINGS)
      far = SELECT(holds, behind, SELECT(gives_up, end, far));
      hits |= holds;
      open |= gives_up;
      active &= ~(holds | gives_up);
      wild = SELECT(candidate, unbounded(f), wild);
      tries = SELECT(candidate, NONE, tries - widens);
      margin = SELECT(candidate, MARGIN * step, SELECT(widens, WIDER * margin, margin));
      stop = SELECT(halves, max(WHOLE(R(0.0625) * stop), (F)1), stop);
      step = SELECT(halves, max(WHOLE(R(0.5) * step), (F)1), step);
      clear = SELECT(halves, (F)0, clear);
      proving = (proving & ~halves) | candidate;
      // Where the sign at the start is not known it is asked for, once: of all up to the first place that surely counts, as a root before it may count.
      asking = candidate & EQ(sign, (F)0) & ~asked;
      asked |= asking;
      const F start = max(position, path.in0), there = SELECT(asking, start, max(min(position + step + margin, path.in1), path.in0));
#if IRT_PARTIAL || IRT_CLIP
      from = SELECT(proving, SELECT(checking | asking, position, there), position);
#else
      from = SELECT(proving & ~asking, there, position);
#endif
      to = SELECT(proving, there, position + step);
    }
  }
#if IRT_BEAMS
  if (beam) {
    head->from = fma(position, path.unit, path.start) - R(8.0) * ULP * (F)RADIUS;
    head->span = step * path.unit;
    head->sign = sign;
    open = LT(position, UNITS) & LE(range->out0, range->out1);
  }
#endif
  // Lanes that are still active have spent their budget.
  const I status = SELECT(hits, HIT, SELECT(open & ~wild, TOUCH, SELECT(open | active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, position, far);
  REPORT_COUNT
  return root;
}
