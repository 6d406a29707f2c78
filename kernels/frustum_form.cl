// What the root finders of S2 share: a polynomial along each ray of a packet, in Bernstein form over a part of the ray, with one bound of the
// error of its coefficients. A sign counts only beyond it.
#define N (IRT_DEGREE + 1)
// Short loops without counters: their arrays stay in registers, and lanes of one round do not wait for those of the last.
#define UNROLL(n) __attribute__((opencl_unroll_hint(n)))
#if IRT_DEGREE <= 12
#define EACH UNROLL(N)
#define ROUNDS UNROLL(4)
#else
#define EACH
#define ROUNDS
#endif
#define NEARBY R(0.0625)  // of a cell: how far roots are likely to move from frame to frame
#define HALF_AND_A_LITTLE R(0.515625)  // of a piece, where it is halved: a cut in a root would leave its sign unknown on both sides
#define BINOMIAL(degree, i) ((degree) == IRT_DEGREE ? binomials[i] : binomials[i] * (real)((degree) + 1 - (i)) / (real)((degree) + 1))  // and one less

// Lines that are contracted together, of so many terms.
#define SUMS(terms) ((terms) <= 13 ? (terms) : 4)
#define CELL_STEP 16

// Pieces that each lane has looked at, where the call asks for them.
#if IRT_PIECES
#define COUNT(lanes) found->pieces -= (lanes);
#else
#define COUNT(lanes)
#endif

// Rounding of one cut by de Casteljau (at most three halves of an ulp of the largest coefficient a round), of a restriction (two
// cuts), and of an evaluation, in parts of the largest coefficient of the ray.
#if IRT_OUTWARD
#define CUT_ERROR (N * R(1.5) * ULP)
#define VALUE_ERROR (N * R(1.5) * ULP)
#else
#define CUT_ERROR R(0.0)
#define VALUE_ERROR R(0.0)
#endif

// What has been found in a cell, in its own units: 0 at its near end, 1 at its far end. What stays open is a touch where more cuts would not
// decide it: f is there within its error of zero. Other rays have spent what they may.
typedef struct {
  I hits, touches, spent;
  F lo, hi;  // brackets of hits, pieces that stay open
#if IRT_PIECES
  I pieces;
#endif
} FOUND;

// The task within a cell: the coefficients over all of it, and the part that counts.
typedef struct {
  F c[N];
  F error, size;     // of any, and of the largest
  F lo, hi;          // outside, nothing counts
  F in_lo, in_hi;    // a bracket lies within
  F reach;           // of the bracket that is wanted, half
#if IRT_PREVIOUS
  F guess;           // where the root of the frame before lies; anywhere, or nan
#endif
} CELL;

static inline F mixed(F a, F b, F share) { return fma(share, b - a, a); }

// name(c, degree, u): the value of Bernstein coefficients, in lanes of LANES, by loops that EACH_TERM unrolls.
#define BERNSTEIN_VALUE(name, LANES, EACH_TERM, BINOMIAL_OF) \
  static inline LANES name(const LANES* c, int degree, LANES u) { \
    const LANES v = (LANES)1 - u; \
    LANES sum = c[0], power = (LANES)1; \
    EACH_TERM for (int i = 1; i <= degree; ++i) { \
      power *= u; \
      sum = fma(sum, v, power * (BINOMIAL_OF(degree, i) * c[i])); \
    } \
    return sum; \
  }
BERNSTEIN_VALUE(value_at, F, EACH, BINOMIAL)

// The lowest and the highest coefficient, in few rounds.
typedef struct {
  F low, high;
} EXTENT;

static inline EXTENT extent_of(const F* c) {
  F low[N], high[N];
  EACH for (int k = 0; k < N; ++k) low[k] = high[k] = c[k];
  ROUNDS for (int apart = 1; apart < N; apart *= 2)
    EACH for (int k = 0; k + apart < N; k += 2 * apart) {
      low[k] = min(low[k], low[k + apart]);
      high[k] = max(high[k], high[k + apart]);
    }
  EXTENT e;
  e.low = low[0];
  e.high = high[0];
  return e;
}

static inline I has_one_sign(EXTENT e, F error) { return GT(e.low, error) | LT(e.high, -error); }
static inline F largest_in(EXTENT e) { return max(e.high, -e.low); }
static inline I one_sign(const F* c, F error) { return has_one_sign(extent_of(c), error); }
static inline F largest_of(const F* c) { return largest_in(extent_of(c)); }

// c over [lo, hi] of its range.
static inline void restrict_to(F* c, F lo, F hi) {
  EACH for (int n = N - 1; n > 0; --n)
    EACH for (int i = 0; i < n; ++i) c[i] = mixed(c[i], c[i + 1], lo);
  const F share = SELECT(GE(hi, (F)1), (F)1, (hi - lo) / max(R(1.0) - lo, (F)TINY));  // the next cell begins at 1, not where a quotient may end
  EACH for (int n = 1; n < N; ++n)
    EACH for (int i = N - 1; i >= n; --i) c[i] = mixed(c[i - 1], c[i], share);
}

// The polynomial over the part of the cell that counts, into c; returns the error of its coefficients.
static inline F begin_with(const CELL* cell, I lanes, F* c) {
  EACH for (int k = 0; k < N; ++k) c[k] = cell->c[k];
  if (!ANY(lanes & (GT(cell->lo, (F)0) | LT(cell->hi, (F)1)))) return cell->error;
  restrict_to(c, cell->lo, cell->hi);
  return fma((F)(R(2.0) * CUT_ERROR), cell->size, cell->error);
}

// Cuts c: the part before the share into `front`, the part behind it into `rest`.
static inline void cut_at(const F* c, F share, F* front, F* rest) {
  EACH for (int k = 0; k < N; ++k) rest[k] = c[k];
  EACH for (int k = 0; k < N; ++k) {
    front[k] = rest[0];
    EACH for (int i = 0; i < N - 1 - k; ++i) rest[i] = mixed(rest[i], rest[i + 1], share);
  }
}

// Frame coherence (S2 section 4.2, which cuts at the last frame's root): the first two cuts of a piece [a, b] go closely before that root and closely
// behind it, so that a root that has moved little stands alone after two. Where cuts go is all that it decides: nothing is believed.
static inline F cut_near(const CELL* cell, int cuts, F a, F b, F otherwise) {
#if IRT_PREVIOUS
  if (cuts > 1) return otherwise;
  const F share = (cell->guess + (cuts ? (F)NEARBY : (F)-NEARBY) - a) / max(b - a, (F)TINY);
  return SELECT(GT(share, (F)R(0.015625)) & LT(share, (F)R(0.984375)), share, otherwise);
#else
  return otherwise;
#endif
}

// A march goes on from [a, b], cut at x, with the part `behind` or the one `ahead` of the cut. What lies behind a piece that was free is
// taken anew from the cell's own coefficients: nothing is kept on a stack. Returns the lanes that have come to the end of the cell.
static inline I go_on(const CELL* cell, F x, const F* front, F* rest, F next_error, I behind, I ahead, F* c, F* a, F* b, F* error) {
  const I whole = behind & one_sign(rest, next_error);
  EACH for (int k = 0; k < N; ++k) c[k] = SELECT(behind, rest[k], SELECT(ahead, front[k], c[k]));
  *a = SELECT(behind, x, *a);
  *b = SELECT(ahead, x, *b);
  *error = SELECT(behind | ahead, next_error, *error);
  const I done = whole & GE(*b, cell->hi), resumes = whole & ~done;
  if (ANY(resumes)) {
    EACH for (int k = 0; k < N; ++k) rest[k] = cell->c[k];
    restrict_to(rest, *b, cell->hi);
    EACH for (int k = 0; k < N; ++k) c[k] = SELECT(resumes, rest[k], c[k]);
    *a = SELECT(resumes, *b, *a);
    *b = SELECT(resumes, cell->hi, *b);
    *error = SELECT(resumes, fma((F)(R(2.0) * CUT_ERROR), cell->size, cell->error), *error);
  }
  return done;
}

// Exactly one root and simple: signs change once, whatever the one coefficient is that may not be told from zero.
static inline I one_root(const F* c, F error, F sign) {
  I bad = ~GT(sign * c[0], error), turned = NONE;  // a coefficient that is not surely of the first one's sign has come
  EACH for (int k = 1; k < N; ++k) {
    const F v = sign * c[k];
    bad |= turned & ~LT(v, -error);
    turned |= ~GT(v, error);
  }
  return LT(sign * c[IRT_DEGREE], -error) & ~bad;
}

// Half of what a bracket may have, in s; no shorter than the precision tells apart.
#define REACH(ray, eps) (max((F)(R(0.45) * (eps)), (F)(R(8.0) * ULP * RADIUS)) / NARROW((ray)->length))

// The first zero of the control polygon, as a share of the piece; 1 where there is none.
static inline F polygon_zero(const F* c, F sign) {
  F at = (F)IRT_DEGREE, before = (F)0, after = (F)1;
  I seen = NONE;
  EACH for (int k = 1; k < N; ++k) {
    const I crosses = ~seen & LE(sign * c[k], (F)0);
    at = SELECT(crosses, (F)(k - 1), at);
    before = SELECT(crosses, fabs(c[k - 1]), before);
    after = SELECT(crosses, fabs(c[k]), after);
    seen |= crosses;
  }
  const F zero = (at + before / max(before + after, (F)TINY)) * (R(1.0) / IRT_DEGREE);
  return zero;
}

// Whether a piece is at the floor of the precision: too short to be cut, or nothing of it rises beyond the error.
static inline I at_floor(F length, F size, F error) { return LT(length, (F)(R(16.0) * ULP)) | LE(size, error); }

static void search_cell(const CELL* cell, I lanes, const int max_pieces, FOUND* found);

// Whether the polynomial changes its sign between lo and hi, beyond all error.
static inline I brackets(const CELL* cell, F lo, F hi, F sign) {
  const F bound = fma((F)VALUE_ERROR, cell->size, cell->error);
  return GT(sign * value_at(cell->c, IRT_DEGREE, lo), bound) & LT(sign * value_at(cell->c, IRT_DEGREE, hi), -bound);
}

// What a search has found, for ROOT: a status, and the place within the part, 0 to 1.
static inline I status_of(const FOUND* found) { return SELECT(found->hits, HIT, SELECT(found->touches, TOUCH, SELECT(found->spent, UNRESOLVED, MISS))); }
static inline F place_of(const FOUND* found) { return SELECT(found->spent, found->lo, R(0.5) * (found->lo + found->hi)); }
