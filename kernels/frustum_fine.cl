// Roots to more digits than floats have: the search in single precision has proven that a bracket holds one root. That one is found and proven once more, by
// four values of the polynomial in double, which costs a small part of a search in double.
//
// fine_form: for each cell (frustum_cells.cl) the polynomial itself in doubles, [down][depth][across] in Bernstein's polynomials, whose values at the centres
// of a tile's pixels fine_basis has.
#define FINE_DEGREE (FINE_TERMS - 1)
#define FINE_ACROSS (fine_basis + 16)
#define FINE_VALUE_ERROR (FINE_TERMS * 3.0 * 0x1p-52)  // as VALUE_ERROR, of coefficients up to 2
#if FINE_TERMS <= 13
#define FINE_EACH UNROLL(FINE_TERMS)
#else
#define FINE_EACH
#endif
#define BEYOND R(0.001)  // of a cell, how far outside it values are believed: errors grow by less than 0.07 there, of any degree up to 32

#if W == 1
#define SELECT_WIDE(m, a, b) SELECT(m, a, b)
#define NARROW_MASK(c) MASK(c)
#else
#define SELECT_WIDE(m, a, b) select(b, a, TO_LONG(m))
#define NARROW_MASK(c) TO_I(c)
#endif

// Opposite signs beyond the bound.
static inline I opposite(FW a, FW b, wide bound) {
  return (NARROW_MASK(a > bound) & NARROW_MASK(b < -bound)) | (NARROW_MASK(a < -bound) & NARROW_MASK(b > bound));
}

static inline FW fine_value(const FW* c, FW u) {
  const FW v = 1.0 - u;
  FW sum = c[0], power = (FW)1;
  FINE_EACH for (int i = 1; i < FINE_TERMS; ++i) {
    power *= u;
    sum = fma(sum, v, power * (fine_binomials[i] * c[i]));
  }
  return sum;
}

// Narrows brackets of `lanes` down to eps where that can be proven; others stay as they are, wide. The cell: s at its near end, its length, the error of its
// coefficients.
static inline void refine(const RAY* ray, ROOT* root, I lanes, __global const real* q, real near, real length, real error, int column, int row,
                          __global const wide* form, __global const wide* fine_basis) {
  const F reach = (F)(R(0.45) * EPS) / NARROW(ray->length);  // half the width that is wanted, in s
  const wide begin = near, inverse = 1.0 / length, bound = 1.07 * (error + FINE_VALUE_ERROR);
  const FW u = (root->at - begin) * inverse, known = WIDEN(root->half_width) * inverse, wanted = WIDEN(reach) * inverse, r = fma((FW)2.0, wanted, known);
  const F place = NARROW(u), around = NARROW(r);
  const I here = lanes & GT(place, (F)-BEYOND + around) & LT(place, R(1.0) + BEYOND - around);
  if (!ANY(here)) return;
  wide plane[FINE_TERMS * FINE_TERMS + W];
  FW c[FINE_TERMS];
  contract_fine_row(form, row, FINE_ACROSS, FINE_TERMS, FINE_TERMS * FINE_TERMS, plane);
  contract_fine_columns(plane, column, FINE_ACROSS, FINE_TERMS, c);
  // Between u - r and u + r, where all of the bracket lies, f has one root only if its slope has one sign: if the mean slope is larger than what the second
  // derivative can change there. So whatever root is bracketed anew is the one that is known to be there.
  FW bend = (FW)0;
  FINE_EACH for (int i = 2; i < FINE_TERMS; ++i) bend = max(bend, fabs(c[i] - c[i - 1] - (c[i - 1] - c[i - 2])));
  const FW first = fine_value(c, u - r), last = fine_value(c, u + r), rise = last - first;
  const F change = R(4.4) * FINE_DEGREE * (FINE_DEGREE - 1) * around * around * (NARROW(bend) + (F)(real)(4.0 * bound));
  const I steep = GT(fabs(NARROW(rise)), change + (F)(real)(2.1 * bound));
  const FW x = clamp(u - r - 2.0 * r * first / rise, u - known, u + known);
  const I good = here & steep & opposite(fine_value(c, x - wanted), fine_value(c, x + wanted), bound);
  root->at = SELECT_WIDE(good, fma(x, (FW)length, (FW)begin), root->at);
  root->half_width = SELECT(good, reach * (R(1.0) + R(4.0) * ULP) + (F)(real)(0x1p-50 * RADIUS), root->half_width);
}
