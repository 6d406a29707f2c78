// Polynomials of degree 1 to 4 on [-1, 1]: where they turn in closed form, and by their signs there the roots (S3, S4 section 3.1.1).
//
// Deviation from both papers: Cardano's and Ferrari's formulas do not give the roots but the extrema, that is the roots of the
// derivative, which is one degree lower; between two of them there is at most one root, which signs prove or exclude and Newton's
// method in that bracket refines. An error d of an extremum enters its value as d^2, so that single precision decides about roots
// as if the extrema were exact; Ferrari's own roots lose half of the digits wherever two of them come close, and all where the
// leading coefficient vanishes. Extra points never harm: where formulas have no real result any point will do.
#if IRT_DOUBLE
#define LARGEST_SCALE 0x1p900  // its reciprocal is no denormal number
#else
#define LARGEST_SCALE 0x1p100f
#endif
#define SETTLED(v) SELECT(EQ(v, v), clamp(v, (F)-1, (F)1), (F)-1)

// Coefficients and their error times a power of two that leaves products of three of them within reals, whatever f is multiplied by.
static inline void scale_form(F* c, const int degree, F* error) {
  F largest = fabs(c[0]);
  for (int k = 1; k <= degree; ++k) largest = max(largest, fabs(c[k]));
  const F scale = R(1.0) / clamp(POWER_OF_TWO_BELOW(largest), (F)(R(1.0) / LARGEST_SCALE), (F)LARGEST_SCALE);
  for (int k = 0; k <= degree; ++k) c[k] *= scale;
  *error *= scale;
}

static inline F value_of(const F* c, const int degree, F e) {
  F v = c[degree];
  for (int k = degree - 1; k >= 0; --k) v = fma(v, e, c[k]);
  return v;
}

static inline F slope_of(const F* c, const int degree, F e) {
  F v = (real)degree * c[degree];
  for (int k = degree - 1; k >= 1; --k) v = fma(v, e, (real)k * c[k]);
  return v;
}

// The roots of a e^2 + 2 h e + c, without cancellation, and of both if a is zero; the vertex twice where there are none.
static inline void quadratic_roots(F a, F h, F c, F* first, F* second) {
  const F product = a * c, discriminant = fma(h, h, -product) - fma(a, c, -product);  // Kahan: exact but for two roundings
  const F root = sqrt(max(discriminant, (F)0)), q = -(h + SELECT(LT(h, (F)0), -root, root));
  *first = q / a;
  *second = SELECT(LT(discriminant, (F)0), *first, c / q);
}

// cos(acos(w) / 3) for w from 0 to 1, the casus irreducibilis: the largest root of 4 v^3 - 3 v = w, by Newton's method from within 0.002.
static inline F third_of_angle(F w) {
  F v = fma(w, fma(w, (F)R(-0.0326921), (F)R(0.1666667)), (F)R(0.8660254));
  for (int i = 0; i < 3; ++i) v -= fma(v * v, R(4.0) * v, -fma((F)R(3.0), v, w)) / fma(v * v, (F)R(12.0), (F)R(-3.0));
  return v;
}

// The roots of a e^3 + 3 b e^2 + 3 c e + d, a complex pair as its real part. First the one farthest from the inflection, which is always
// well separated, as y = a e + b; then the other two from what is left when it is divided out, from the end that keeps digits
// (Kahan, To Solve a Real Cubic Equation). Nothing is divided by a but that first root, so that a may vanish.
static inline void cubic_roots(F a, F b, F c, F d, F* roots) {
  const F scale = R(1.0) / max(max(fabs(a), fabs(b)), max(fabs(c), fabs(d)));
  a *= scale, b *= scale, c *= scale, d *= scale;
  const F p = fma(a, c, -b * b), q = R(0.5) * fma(a, fma(a, d, R(-3.0) * b * c), R(2.0) * b * b * b);  // y^3 + 3 p y + 2 q
  const F size = fabs(q), discriminant = fma(q, q, p * p * p), s = sqrt(max(-p, (F)0));
  const F three = R(2.0) * s * third_of_angle(min(size / (s * s * s), (F)1));
  const F u = cbrt(size + sqrt(max(discriminant, (F)0))), v = p / u;
  const F one = SELECT(GT(p, (F)0), R(2.0) * size / fma(u, u, fma(v, v, p)), u - v);
  const F far = SELECT(GT(discriminant, (F)0), one, three), y = SELECT(GT(q, (F)0), -far, far);
  const F shift = SELECT(EQ(y, y), y, (F)0) - b, rough = shift / a;
  // One step of polishing, unless it leads away: near a triple root it may lead anywhere.
#define CUBIC(e) fma(fma(fma(a, e, R(3.0) * b), e, R(3.0) * c), e, d)
  const F value = CUBIC(rough), better = rough - value / (R(3.0) * fma(fma(a, rough, R(2.0) * b), rough, c));
  const F r = SELECT(LT(fabs(CUBIC(better)), fabs(value)), better, rough);
  const F ar = SELECT(LT(fabs(r), INF), a * r, shift), inverse = SELECT(EQ(ar, (F)0), (F)0, a / ar);
  const F linear = fma((F)R(3.0), b, ar);
  const I small = LE(fabs(ar) * r * r, fabs(d));  // the smallest root: divided out from the front
  roots[0] = r;
  quadratic_roots(SELECT(small, a, -ar), R(0.5) * SELECT(small, linear, fma(d, inverse, R(3.0) * c)),
                  SELECT(small, fma(r, linear, R(3.0) * c), d), roots + 1, roots + 2);
}

// The ends -1 and 1 and, between them in order, the extrema: degree + 1 points.
static inline void turning_points(const F* c, const int degree, F* e) {
  e[0] = (F)-1;
  if (degree == 2) e[1] = SETTLED(R(-0.5) * c[1] / c[2]);
  if (degree == 3) {
    F u, v;
    quadratic_roots(R(3.0) * c[3], c[2], c[1], &u, &v);
    u = SETTLED(u), v = SETTLED(v);
    e[1] = min(u, v), e[2] = max(u, v);
  }
  if (degree == 4) {
    F r[3];
    cubic_roots(R(4.0) * c[4], c[3], c[2] * (R(2.0) / R(3.0)), c[1], r);
    const F u = SETTLED(r[0]), v = SETTLED(r[1]), w = SETTLED(r[2]), low = min(v, w), high = max(v, w);
    e[1] = min(u, low), e[2] = max(low, min(u, high)), e[3] = max(u, high);
  }
  if (degree > 0) e[degree] = (F)1;
}

// The sign of a value, 0 where rounding may have made it.
static inline F certain_sign(F value, F error) { return SELECT(GT(value, error), (F)1, SELECT(LT(value, -error), (F)-1, (F)0)); }

// A walk from point to point: what has been seen since the last one with a certain sign.
typedef struct {
  F from, side;  // that point and its sign; 0 before the first
  F doubtful;    // the first point behind it whose sign rounding hides,
  I doubts;      // where there is one
} WALK;

static inline WALK begin_walk(void) {
  WALK walk;
  walk.from = walk.doubtful = (F)-1;
  walk.side = (F)0;
  walk.doubts = NONE;
  return walk;
}

// On to the point e with the sign s. The lanes in which a root of odd order lies in (from, e); those in which one of even order, or
// of none within rounding, lies at `doubtful`.
static inline I crosses(const WALK* walk, F s) { return LT(s * walk->side, (F)0); }
static inline I touches(const WALK* walk, F s) { return walk->doubts & ~EQ(s, (F)0) & ~crosses(walk, s); }

static inline void walk_to(WALK* walk, F e, F s) {
  const I certain = ~EQ(s, (F)0);
  walk->doubtful = SELECT(walk->doubts, walk->doubtful, e);
  walk->doubts = ~certain;
  walk->from = SELECT(certain, e, walk->from);
  walk->side = SELECT(certain, s, walk->side);
}

// The root in (a, b) of a polynomial that has the sign `side` at a and the other at b.
#define REFINEMENTS 64  // halving alone would not need more; Newton's method takes 3 to 5
static inline F root_between(const F* c, const int degree, F a, F b, F side, I lanes) {
  if (degree == 1) return clamp(-c[0] / c[1], a, b);
  if (degree == 2) {
    F u, v;
    quadratic_roots(c[2], R(0.5) * c[1], c[0], &u, &v);
    const I first = LE(fabs(u - R(0.5) * (a + b)), fabs(v - R(0.5) * (a + b))) | ~EQ(v, v);
    const F rough = SELECT(first, u, v), better = rough - value_of(c, 2, rough) / slope_of(c, 2, rough);
    return clamp(SELECT(LT(fabs(better), INF), better, rough), a, b);
  }
  F noise = fabs(c[0]);
  for (int k = 1; k <= degree; ++k) noise += fabs(c[k]);
  noise *= ULP;
  // It turns at most ends: near an extremum it is a parabola.
  const F va = fabs(value_of(c, degree, a)), vb = fabs(value_of(c, degree, b)), share = min(va, vb) / (va + vb);
  const F part = sqrt(R(0.5) * share) * (b - a);
  F e = SELECT(LE(va, vb), a + part, b - part);
  for (int i = 0; i < REFINEMENTS && ANY(lanes); ++i) {
    const F value = value_of(c, degree, e), next = e - value / slope_of(c, degree, e);
    const I before = GT(value * side, (F)0);
    a = SELECT(before, e, a);
    b = SELECT(before, b, e);
    // At the root itself the step may lead out of the bracket by an ulp.
    const I there = LE(fabs(value), noise), within = GE(next, a) & LE(next, b);
    const F to = SELECT(within, next, SELECT(there, e, R(0.5) * (a + b)));
    const I ends = there | LE(fabs(to - e), (F)ULP);
    e = SELECT(lanes, to, e);
    lanes &= ~ends;
  }
  return e;
}

// Whether rounding hides where in (from, to) the root at e lies, by more than `wanted` to either side: near a multiple root.
static inline I blurred(const F* c, const int degree, F error, F from, F to, F side, F e, F wanted) {
  const F before = side * value_of(c, degree, max(e - wanted, from)), behind = side * value_of(c, degree, min(e + wanted, to));
  return ~(GT(before, error) & LT(behind, -error));
}

// Half of eps, in e.
static inline F wanted_places(const RAY* ray, F reach, __global const real* q) { return (F)(R(0.5) * EPS) / (NARROW(ray->length) * reach); }

// What was found at e, the piece being middle + e reach.
static inline ROOT closed_root(const RANGE* range, F middle, F reach, F e, I hit, I touch, I overflow) {
  ROOT root;
  const F at = fma(reach, e, middle);
  // A root between the ends rounded outward and those rounded inward may lie outside the bounds.
  const I inside = GE(at, range->in0) & LE(at, range->in1);
  root.status = SELECT(overflow, UNRESOLVED, SELECT(hit & inside, HIT, SELECT(hit | touch, TOUCH, MISS)));
  root.at = WIDEN(SELECT(overflow, range->out0, at));
  root.half_width = ULP * fabs(at);
#if IRT_PIECES
  root.pieces = NONE;
#endif
  return root;
}
