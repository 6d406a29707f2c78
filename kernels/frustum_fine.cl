// Roots to more digits than floats have: the search in single precision has proven that a bracket holds one root. That one is found and proven once more, by
// one value of the polynomial in double, which costs a small part of a search in double.
//
// fine_form: for each cell (frustum_cells.cl) the polynomial in doubles, [down][depth][across], with FINE_TERMS along the depth; fine_basis: as `basis`.
#define FINE_DEGREE (FINE_TERMS - 1)
#define FINE_ACROSS (fine_basis + 16)
#define FINE_VALUE_ERROR (FINE_TERMS * 3.0 * 0x1p-52)  // as VALUE_ERROR, of coefficients up to 2
#if FINE_TERMS <= 13
#define FINE_EACH UNROLL(FINE_TERMS)
#else
#define FINE_EACH
#endif
#define FINE_BINOMIAL(degree, i) fine_binomials[i]
// Of one degree less, and of two.
#define FALLING(degree, i) \
  ((real)(fine_binomials[i] * (FINE_DEGREE - (i)) / FINE_DEGREE * ((degree) == FINE_DEGREE - 1 ? 1.0 : (FINE_DEGREE - 1.0 - (i)) / (FINE_DEGREE - 1))))
// Of a mean of differences, where the place is rounded to a float, and of a quotient by it: in parts of the largest difference.
#define FINE_SLOPE_ERROR ((FINE_TERMS + 2) * R(2.0) * ULP)
#define BEYOND R(0.001)  // of a cell, how far outside it values are believed: errors grow by less than 0.07 there, of any degree up to 32

BERNSTEIN_VALUE(fine_value, FW, FINE_EACH, FINE_BINOMIAL)
BERNSTEIN_VALUE(falling_value, F, FINE_EACH, FALLING)

// What is known of f about the root: its slope, what that is off by, and how much it changes at most on a unit of the way.
typedef struct {
  F slope, blur, change;
} RISE;

// Whether the slope has one sign within r.
static inline I steep(RISE f, F r) { return GT(fabs(f.slope), fma(r, f.change, f.blur)); }

// Whether f goes from beyond the bound to beyond it on the other side within `wanted` of the zero that its value and slope tell, `off` from where they are.
static inline I changes_sign(RISE f, F off, F wanted, real bound) {
  const F end = fabs(off) + wanted;
  return GT(fabs(f.slope) * wanted, fma(end, fma(R(0.51) * end, f.change, f.blur), (F)bound));
}

// Narrows brackets of `lanes` down to eps where that can be proven; others stay as they are, wide. The cell: s at its near end, its length, the error of its
// coefficients, and these contracted with the row.
//
// f(u + d) is f(u) + d f'(u), to within half of d^2 times the largest second derivative: over a bracket that is small beside eps, so that only f(u) needs
// doubles. All this is said of the polynomial that the coefficients are: f itself differs from it by the bound of their error. Where it rises or falls all over the
// bracket, and is beyond the bound on both sides of the new one, f is nonzero between them: the root that is known to be there lies in the new one.
static inline void refine(const RAY* ray, ROOT* root, I lanes, __global const real* q, real near, real length, real error, int column, const wide* plane,
                          int across, __global const wide* fine_basis) {
  const F reach = (F)(R(0.45) * EPS) / NARROW(ray->length);  // half the width that is wanted, in s
  const wide begin = near;
  const real inverse = R(1.0) / length, bound = R(1.07) * (error + FINE_VALUE_ERROR);
  const FW place = (root->at - begin) / (wide)length;
  const F u = NARROW(place), known = root->half_width * inverse, wanted = reach * inverse, r = wanted + wanted + known;
  const I here = lanes & GT(u, (F)-BEYOND + r) & LT(u, R(1.0) + BEYOND - r);
  if (!ANY(here)) return;
  FW c[FINE_TERMS];
  contract_fine_columns(plane, column, FINE_ACROSS, across, c);
  F first[FINE_TERMS], second[FINE_TERMS];  // differences
  F size = (F)0, bend = (F)0;
  FINE_EACH for (int i = 0; i < FINE_DEGREE; ++i) {
    first[i] = NARROW(c[i + 1] - c[i]);
    size = max(size, fabs(first[i]));
  }
  FINE_EACH for (int i = 0; i < FINE_DEGREE - 1; ++i) {
    second[i] = first[i + 1] - first[i];
    bend = max(bend, fabs(second[i]));
  }
  const F rounding = (F)FINE_SLOPE_ERROR * size;
  const real most = FINE_DEGREE * (FINE_DEGREE - 1) * R(1.1);  // more than outside the cell
  RISE f;
  f.slope = (real)FINE_DEGREE * falling_value(first, FINE_DEGREE - 1, u);
  f.blur = (real)FINE_DEGREE * rounding;
  f.change = most * (bend + rounding);  // by coefficients anywhere in the cell
  const F off = -NARROW(fine_value(c, FINE_DEGREE, place)) / f.slope;
  FW at = place + WIDEN(off);
  I good = here & steep(f, r) & LE(fabs(off), known + wanted) & changes_sign(f, off, wanted, bound);
#if FINE_DEGREE > 2
  if (ANY(here & ~good)) {
    // By the second derivative here, and what the third lets it change; and by a second step, from where the first one led.
    F third = (F)0;
    FINE_EACH for (int i = 0; i < FINE_DEGREE - 2; ++i) third = max(third, fabs(second[i + 1] - second[i]));
    const F twice = rounding + rounding;  // of second differences, and of third ones
    f.change = most * fma((real)(FINE_DEGREE - 2) * r, third + twice, fabs(falling_value(second, FINE_DEGREE - 2, u)) + twice);
    f.blur = fma(fabs(off), f.change, f.blur);
    const F more = -NARROW(fine_value(c, FINE_DEGREE, at)) / f.slope;
    const I better = here & ~good & steep(f, r) & LE(fabs(off) + fabs(more), known + wanted) & changes_sign(f, more, wanted, bound);
    good |= better;
    at = SELECT_WIDE(better, at + WIDEN(more), at);
  }
#endif
  root->at = SELECT_WIDE(good, fma(at, (FW)length, (FW)begin), root->at);
  root->half_width = SELECT(good, reach * (R(1.0) + R(4.0) * ULP) + (F)(real)(0x1p-50 * RADIUS), root->half_width);
}
