// Bisection with a stack (S4 section 3.1.2, after Mitchell): the nearer half first, the farther one waits on a stack. The same search as
// bisection.cl makes without one, to compare them.
//
// Pieces follow one another, so that an entry is the end of a piece: it begins where the one before it has ended. No ray is halved more
// often than a path has levels, which bounds the stack; lanes stand at different heights of it, so that an entry is found by looking at all.
//
// S4 calls a piece whose interval holds zero a root. With IRT_OUTWARD a piece that is short enough is a candidate: the piece skipped
// before it tells the sign at its start; the opposite sign must be proven a little behind its end, and f continuous between, inside the
// clip region. Else it is halved on, to the floor of the precision, where what is looked at behind it widens; what is still open is a TOUCH,
// or UNRESOLVED at a pole.
#define STACK_WIDENINGS 32
#define STACK_WIDER R(1.5)
#define HEIGHT (PATH_LEVELS + 1)

static inline void push(I* stack, I* height, I v, I lanes) {
  for (int k = 0; k < HEIGHT; ++k) stack[k] = SELECT(lanes & EQ(*height, (I)k), v, stack[k]);
  *height -= lanes;
}

static inline I pop(const I* stack, I* height, I lanes) {
  *height += lanes;
  I v = NONE;
  for (int k = 0; k < HEIGHT; ++k) v = SELECT(EQ(*height, (I)k), stack[k], v);
  return v;
}

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  const F wanted = wanted_units(ray, &path, q);
  I stop = TO_I(clamp(wanted / (R(1.0) + MARGIN), (F)1, TO_F(PATH_END)));
  I active = LE(range->out0, range->out1), hits = NONE, open = NONE, wild = NONE;
  I from = NONE, end = PATH_END, height = NONE, stack[HEIGHT];
  for (int k = 0; k < HEIGHT; ++k) stack[k] = NONE;
  I above = NONE, below = NONE;  // the sign of f at `from`, if it is known
  I proving = NONE, asking = NONE, checking = NONE, tries = NONE;
  F margin = (F)0, far = (F)0;
  COUNT_FROM_HERE
  for (int pieces = 0; pieces < max_pieces && ANY(active); ++pieces) {
    COUNT(active)
    // Of a candidate: the sign at its start, up to where all counts, where it is not known, the sign behind it, and that all between is continuous and inside.
    const F start = max(TO_F(from), path.in0), behind = max(min(TO_F(end) + margin, path.in1), path.in0);
    I undefined, rough;
    REGION_VARIABLES
    const FORM f = enclose(&path, SELECT(proving & ~asking, SELECT(checking, start, behind), TO_F(from)),
                           SELECT(proving, SELECT(asking, start, behind), TO_F(end)) PARAMETERS_PASS, &undefined, &rough REGION_OUT);
    const I is_above = positive(f) & ~undefined, is_below = negative(f) & ~undefined;

    const I marches = active & ~proving, skips = marches & (is_above | is_below | undefined | outside), ended = skips & GE(end, PATH_END);
    const I left = marches & ~skips, candidate = left & LE(end - from, stop);
    const I answers = active & asking, tried = active & proving & ~asking;
    JUDGE(tried)
    AFTER_FAILURE(failed, LE(end - from, (I)1), STACK_WIDENINGS)
    hits |= proven;
    open |= gives_up;
    far = SELECT(proven, behind, SELECT(gives_up, TO_F(end), far));
    active &= ~(proven | gives_up | ended);
    // What lies before in0 may lie outside the bounds: a change of sign there would be no hit.
    const I known = answers | (skips & GE(TO_F(end), path.in0));
    above = SELECT(known, is_above, above & ~skips);
    below = SELECT(known, is_below, below & ~skips);
    wild = SELECT(candidate, unbounded(f), wild);
    tries = SELECT(candidate, NONE, tries - widens);
    margin = SELECT(candidate, MARGIN * TO_F(end - from), SELECT(widens, STACK_WIDER * margin, margin));
    stop = SELECT(halves, max(stop >> 2, (I)1), stop);
    const I splits = (left & ~candidate) | halves, passes = skips & ~ended;
    proving = (proving & ~halves) | candidate;
    asking = candidate & ~(above | below);
    push(stack, &height, end, splits);
    const I popped = pop(stack, &height, passes);
    from = SELECT(passes, end, from);
    end = SELECT(splits, from + ((end - from) >> 1), SELECT(passes, popped, end));
  }
  // Lanes that are still active have spent their budget.
  const I status = SELECT(hits, HIT, SELECT(open & ~wild, TOUCH, SELECT(open | active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, SELECT(hits, max(TO_F(from), path.in0), TO_F(from)), far);
  REPORT_COUNT
  return root;
}
