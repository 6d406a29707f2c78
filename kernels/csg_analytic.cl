// Closed forms on trees of set operations (S4 section 4.1.2): the roots of every leaf, and which of them the tree shows.
//
// Deviation from S4, which tests each leaf's root against the whole solid by values: the signs of all leaves are known between two roots,
// because the roots in which they change are; so the tree is asked for signs only, before, at and behind each root. Roots of
// different leaves that rounding cannot tell apart (NEARBY) are one event. HIT: the tree's sign changes; TOUCH: the tree is zero there and
// does not change its sign (a leaf's tangent, or two solids that share a face), or rounding hides by more than eps where that root lies.
#define NEARBY (R(16.0) * ULP)

// The roots of one leaf, LEAF_ROOTS at most, the last ones INF, its sign behind each, and whether rounding hides it.
#define LEAF_ROOTS 5
static inline F leaf_roots(const F* c, const int degree, F error, F wanted, I lanes, F* root, F* behind, I* vague) {
  F e[TERMS], first = (F)0;
  turning_points(c, degree, e);
  WALK walk = begin_walk();
  for (int k = 0; k < LEAF_ROOTS; ++k) root[k] = INF, behind[k] = (F)0, vague[k] = NONE;
  for (int k = 0; k <= degree; ++k) {
    const F s = certain_sign(value_of(c, degree, e[k]), error);
    const I odd = lanes & crosses(&walk, s), even = lanes & touches(&walk, s);
    if (k == 0) first = s;
    if (ANY(odd)) {
      root[k] = SELECT(odd, root_between(c, degree, walk.from, e[k], walk.side, odd), root[k]);
      vague[k] = odd & blurred(c, degree, error, walk.from, e[k], walk.side, root[k], wanted);
    }
    root[k] = SELECT(even, walk.doubtful, root[k]);
    behind[k] = s;
    walk_to(&walk, e[k], s);
  }
  // What is in doubt to the end; then nothing lies behind.
  const I last = walk.doubts & lanes;
  root[degree] = SELECT(last, walk.doubtful, root[degree]);
  behind[degree] = SELECT(last, walk.side, behind[degree]);
  return first;
}

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const F middle = R(0.5) * (range->out0 + range->out1), reach = R(0.5) * (range->out1 - range->out0);
  I open = LE(range->out0, range->out1), hit = NONE, touch = NONE, overflow = NONE;
  F at = (F)0;
  if (ANY(open)) {
    F c[LEAVES][TERMS], error[LEAVES], root[LEAVES][LEAF_ROOTS], behind[LEAVES][LEAF_ROOTS], now[LEAVES], then[LEAVES], there[LEAVES];
    I vague[LEAVES][LEAF_ROOTS];
    const F wanted = wanted_places(ray, reach, q);
    irt_coefficients(fma(middle, ray->dx, ray->px), fma(middle, ray->dy, ray->py), fma(middle, ray->dz, ray->pz), reach * ray->dx,
                     reach * ray->dy, reach * ray->dz PARAMETERS_PASS, c, error);
#define ROOTS_OF(leaf, degree) \
  overflow |= open & ~LT(error[leaf], INF); \
  scale_form(c[leaf], degree, error + leaf); \
  now[leaf] = leaf_roots(c[leaf], degree, error[leaf], wanted, open, root[leaf], behind[leaf], vague[leaf]);
    EACH_LEAF(ROOTS_OF)
    F passed = (F)-2;
    for (int event = 0; event < LEAVES * LEAF_ROOTS && ANY(open); ++event) {
      F next = INF;
      for (int i = 0; i < LEAVES; ++i)
        for (int k = 0; k < LEAF_ROOTS; ++k) next = min(next, SELECT(GT(root[i][k], passed), root[i][k], INF));
      open &= LT(next, INF);
      passed = next + (F)NEARBY;
      I hidden = NONE;
      for (int i = 0; i < LEAVES; ++i) {
        then[i] = there[i] = now[i];
        for (int k = 0; k < LEAF_ROOTS; ++k) {
          const I here = GE(root[i][k], next) & LE(root[i][k], passed);
          there[i] = SELECT(here, (F)0, there[i]);
          then[i] = SELECT(here, behind[i][k], then[i]);
          hidden |= here & vague[i][k];
        }
      }
      const I odd = open & LT(irt_tree(now) * irt_tree(then), (F)0), even = open & ~odd & EQ(irt_tree(there), (F)0);
      at = SELECT(odd | even, next, at);
      hit |= odd & ~hidden;
      touch |= even | (odd & hidden);
      open &= ~(odd | even);
      for (int i = 0; i < LEAVES; ++i) now[i] = then[i];
    }
  }
  return closed_root(range, middle, reach, at, hit, touch, overflow);
}
