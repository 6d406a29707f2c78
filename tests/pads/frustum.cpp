// Contracts of frustum_form.cl, frustum_cells.cl, frustum_fine.cl, frustum_rays.cl and frustum_knots.cl: how far coefficients and values are off, and what part of a ray a
// cell's polynomial is looked at over.
#include "kernel_host.h"

#define IRT_BEAMS 0
#define IRT_SLACK 0
#define IRT_GRADIENT_FOUND 0
#define IRT_SPHERES 0
#define IRT_HALF_SPACES 0
#define IRT_DEGREE 3
#define IRT_MOST_TERMS 1
#define IRT_TILE 1
#define IRT_PREVIOUS 0

namespace {
const real binomials[] = {1, 3, 3, 1};
#include "packet.cl"
#include "scene.cl"
#include "ray_list.cl"
#include "frustum_form.cl"

// ---- Bernstein arithmetic

// Coefficients of all signs and sizes, the largest often at an end.
void some_coefficients(F* c, Random& rng) {
  for (int k = 0; k < N; ++k) c[k] = rounded(rng.sign() * (rng.chance(0.6) ? 2 - rng.size(-20, -1) : rng.size(-10, 1)));
}

// Exact coefficients of the parts before and behind the share.
void cut_exactly(const exact* c, exact share, exact* front, exact* rest) {
  for (int k = 0; k < N; ++k) rest[k] = c[k];
  for (int k = 0; k < N; ++k) {
    front[k] = rest[0];
    for (int i = 0; i < N - 1 - k; ++i) rest[i] += share * (rest[i + 1] - rest[i]);
  }
}

bool near_to(const F* c, const exact* truth, exact off) {
  for (int k = 0; k < N; ++k)
    if (!at_most(magnitude(of(c[k]) - truth[k]), off)) return false;
  return true;
}

CONTRACT(cut_at) {
  F c[N], front[N], rest[N];
  exact e[N], before[N], behind[N];
  some_coefficients(c, rng);
  for (int k = 0; k < N; ++k) e[k] = of(c[k]);
  const F share = rounded(rng.chance(0.5) ? rng.unit() : 1 - rng.size(-20, -1));
  cut_at(c, share, front, rest);
  cut_exactly(e, of(share), before, behind);
  const exact off = of(F(CUT_ERROR)) * of(largest_of(c));
  return near_to(front, before, off) && near_to(rest, behind, off);
}

CONTRACT(value_at) {
  F c[N];
  some_coefficients(c, rng);
  const F u = rounded(rng.chance(0.5) ? rng.unit() : rng.chance(0.5) ? rng.size(-20, -1) : 1 - rng.size(-20, -1));
  exact e[N];
  for (int k = 0; k < N; ++k) e[k] = of(c[k]);
  for (int n = N - 1; n > 0; --n)
    for (int i = 0; i < n; ++i) e[i] += of(u) * (e[i + 1] - e[i]);
  return at_most(magnitude(of(value_at(c, IRT_DEGREE, u)) - e[0]), of(F(VALUE_ERROR)) * of(largest_of(c)));
}

// The share of what lies behind `lo` that restrict_to takes; in samples whose quotients err in one direction it is the same again.
F share_of(F lo, F hi) { return hi >= F(1) ? F(1) : (hi - lo) / max(R(1.0) - lo, (F)TINY); }

// Over [lo, lo + share (1 - lo)], the part of the cell's own coefficients that restrict_to makes.
bool restricted(const CELL& cell, F lo, F hi, const F* c, F error) {
  exact e[N], front[N], rest[N];
  for (int k = 0; k < N; ++k) e[k] = of(cell.c[k]);
  cut_exactly(e, of(lo), front, rest);
  cut_exactly(rest, of(share_of(lo, hi)), front, e);
  return near_to(c, front, of(error) - of(cell.error));
}

CELL some_cell(Random& rng) {
  CELL cell;
  some_coefficients(cell.c, rng);
  cell.size = largest_of(cell.c);
  cell.error = (F)0;
  cell.lo = rounded(rng.chance(0.3) ? 0 : rng.chance(0.5) ? rng.size(-20, -1) : rng.unit());
  cell.hi = rounded(rng.chance(0.3) ? 1 : rng.between(cell.lo.v, 1));
  return cell;
}

CONTRACT(begin_with) {
  if (!error_mode) error_mode = 1;
  const CELL cell = some_cell(rng);
  F c[N];
  const F error = begin_with(&cell, ALL, c);
  if (cell.lo == F(0) && cell.hi == F(1)) return error == F(0);
  return restricted(cell, cell.lo, cell.hi, c, error);
}

// Behind a piece that is free of zeros the march takes what follows from the cell's own coefficients.
CONTRACT(go_on) {
  if (!error_mode) error_mode = 1;
  CELL cell = some_cell(rng);
  F c[N], front[N], rest[N], a = cell.lo, b = cell.lo, error = (F)0;
  for (int k = 0; k < N; ++k) c[k] = front[k] = rest[k] = (F)1;
  cell.lo = (F)0;
  if (go_on(&cell, a, front, rest, (F)0, ALL, NONE, c, &a, &b, &error)) return true;
  return restricted(cell, a, cell.hi, c, error);
}

// ---- parts of a ray

CELL asked;
F found_lo, found_hi;
void search_cell(const CELL* cell, I lanes, const int, FOUND* found) {
  asked = *cell;
  found->hits = ALL, found->touches = found->spent = NONE;
  found->lo = found_lo, found->hi = found_hi;
}

#define FINDER \
  , const size_t packet, const size_t pixel_row, const int *tiles, const int *shapes, const real *slabs, const real *form, const real *basis, const int terms, \
      const int tile_x0, const int tile_y0, const int tile_columns, const int tile_rows
#define SCALAR real
#define LANES F
#define TERMS N
#define CONTRACTION(with) contract_##with
#include "frustum_contract.cl"
#define find_root find_in_cells
#include "frustum_cells.cl"
#undef find_root
#undef FINDER
#define FINDER , const size_t packet, const size_t pixel_row, const real *rays_form, const int stride, const real reach_s
#define find_root find_in_form
#include "frustum_rays.cl"
#undef find_root

// A cell from near, so long, or the form of a ray from -reach to reach; what was asked of it, and what it told of [found_lo, found_hi].
struct Part {
  real near, length;
  RANGE range;
  ROOT root;

  Part(bool of_rays, Random& rng) {
    real q[32] = {};
    const double radius = rng.size(-6, 6);
    q[6] = rounded(radius), q[8] = q[26] = rounded(radius * 1e-4);
    RAY ray;
    ray.length = rounded(rng.size(0, 1));
    near = of_rays ? -q[6] : rounded(q[6] * (rng.chance(0.3) ? -1 : rng.between(-1, 0.9)));
    length = of_rays ? 2 * q[6] : rounded((double(q[6]) - near) * (rng.chance(0.4) ? 1 : std::exp2(-rng.between(0, 8))));
    double a = rng.between(-1, 1) * q[6], b = rng.between(-1, 1) * q[6];
    if (rng.chance(0.6)) a = near + length * (rng.chance(0.3) ? 0 : std::exp2(-rng.between(1, 20))), b = near + length * (1 - std::exp2(-rng.between(1, 20)));
    range.out0 = range.in0 = rounded(std::fmin(a, b)), range.out1 = range.in1 = rounded(std::fmax(a, b));
    found_lo = rounded(rng.unit()), found_hi = min(found_lo + F(rounded(rng.size(-20, 0))), F(1));
    asked.lo = asked.hi = asked.in_lo = asked.in_hi = (F)2;
    const real row[N + 1] = {1, -1, 1, -1, 0}, slab[] = {near, length, 0}, basis[17 + N] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    const int tiles[] = {0, 1}, shapes[] = {1, 1, 0};
    root = of_rays ? find_in_form(&ray, &range, q, 99, 0, 0, row, 1, q[6]) : find_in_cells(&ray, &range, q, 99, 0, 0, tiles, shapes, slab, row, basis, 1, 0, 0, 1, 1);
  }
  bool looked() const { return asked.lo <= F(1); }
  exact place(exact u) const { return exact(near) + u * exact(length); }

  // What is looked at reaches from out0 to out1, as far as the cell does, in spite of the quotient in restrict_to.
  bool part() const {
    if (!looked()) return of(range.out0) >= place(1) || of(range.out1) <= place(0) || range.out1 <= range.out0;
    const exact last = of(asked.lo) + of(share_of(asked.lo, asked.hi)) * (1 - of(asked.lo));
    return at_most(place(of(asked.lo)), most(of(range.out0), place(0))) && at_most(least(of(range.out1), place(1)), place(last));
  }
  // Brackets between in_lo and in_hi lie where everything counts.
  bool inside() const { return !looked() || asked.in_lo > asked.in_hi || (at_most(of(range.in0), place(of(asked.in_lo))) && at_most(place(of(asked.in_hi)), of(range.in1))); }
  // What is reported holds the bracket. Doubles lose what results.cl has room for.
  bool report() const {
    if (!looked() || !root.status) return true;
    const exact off = of(root.half_width) + (IRT_SPLIT ? (magnitude(near) + magnitude(length)) * exact(0x1p-52) : exact(0));
    return at_most(magnitude(place(of(found_lo)) - of(root.at)), off) && at_most(magnitude(place(of(found_hi)) - of(root.at)), off);
  }
};

CONTRACT(cell_part) { return Part(false, rng).part(); }
CONTRACT(cell_inside) { return Part(false, rng).inside(); }
CONTRACT(cell_report) { return Part(false, rng).report(); }
CONTRACT(form_part) { return Part(true, rng).part(); }
CONTRACT(form_inside) { return Part(true, rng).inside(); }
CONTRACT(form_report) { return Part(true, rng).report(); }

// ---- roots refined in double

#if VARIANT == 0
#define FINE_TERMS 4
const wide fine_binomials[] = {1, 3, 3, 1};
// The coefficients themselves.
void contract_fine_row(const wide*, int, const wide*, int, int, wide*) {}
void contract_fine_columns(const wide*, int, const wide* polynomials, int, FW* c) {
  for (int k = 0; k < 4; ++k) c[k] = polynomials[k];
}
#include "frustum_fine.cl"

// A bracket becomes a narrower one, of the one root in it: of cubics with one to three real roots, often close together.
CONTRACT(refine) {
  if (!error_mode) error_mode = 1;
  const double first = rng.between(0.01, 0.99), second = first + rng.sign() * rng.size(-24, 1);
  const bool real_pair = rng.chance(0.5);
  const double third = real_pair ? second + rng.sign() * rng.size(-24, 1) : rng.size(-24, 1);  // or what is imaginary of a pair
  const exact a = first, b = real_pair ? -exact(second) - third : -2 * exact(second), c = real_pair ? exact(second) * third : exact(second) * second + exact(third) * third;
  const exact powers[] = {-a * c, c - a * b, b - a, 1};
  exact bernstein[] = {powers[0], powers[0] + powers[1] / 3, powers[0] + (2 * powers[1] + powers[2]) / 3, powers[0] + powers[1] + powers[2] + powers[3]};
  exact largest = 0;
  for (const exact v : bernstein) largest = most(largest, magnitude(v));
  const exact scale = rng.between(1, 2) / largest;
  for (exact& v : bernstein) v *= scale;
  const auto value = [&](exact u) {
    exact e[4];
    for (int k = 0; k < 4; ++k) e[k] = bernstein[k];
    for (int n = 3; n > 0; --n)
      for (int i = 0; i < n; ++i) e[i] += u * (e[i + 1] - e[i]);
    return e[0];
  };
  real q[32] = {};
  q[6] = rounded(rng.size(-6, 6));
  const real near = rounded(q[6] * rng.between(-1, 0.9)), length = rounded((q[6] - near) * std::exp2(-rng.between(0, 6)));
  RAY ray;
  ray.length = rounded(rng.size(0, 1));
  ROOT root;
  root.status = HIT;
  root.half_width = rounded(length * rng.size(-24, -1));
  root.at = near + double(length) * first + rng.between(-0.9, 0.9) * root.half_width.v;
  q[8] = rounded(root.half_width.v * std::exp2(-rng.between(0, 24)));
  // Coefficients err by what they are said to err by; often by as much as f rises within eps.
  const double rise = 3 * double(magnitude(bernstein[1] - bernstein[0] + first * (bernstein[2] - 2 * bernstein[1] + bernstein[0]) * 2)) * 0.45 * q[8] / (length * double(ray.length.v));
  const real error = rounded(rng.chance(0.3) ? rise * rng.between(0, 1) : rng.size(-50, -20)) + 0x1p-52f;
  wide basis[20] = {};
  for (int k = 0; k < 4; ++k) basis[16 + k] = static_cast<double>(bernstein[k] + (exact(error) - 0x1p-52) * (rng.chance(0.5) ? rng.sign() : rng.between(-1, 1)));
  const ROOT before = root;
  refine(&ray, &root, ALL, q, near, length, error, 0, basis, 4, basis);
  if (root.half_width == before.half_width) return true;
  const F reach = (F)(R(0.45) * q[8]) / NARROW(ray.length);
  if (!at_most(of(reach) * (1 + exact(0x1p-23)), of(root.half_width))) return false;  // room for the rounding of a product (results.cl)
  const auto place = [&](exact s) { return (s - exact(near)) / exact(length); };
  const exact from = place(of(before.at) - of(before.half_width)), to = place(of(before.at) + of(before.half_width));
  const exact lo = place(of(root.at) - of(root.half_width)), hi = place(of(root.at) + of(root.half_width));
  if ((value(from) < 0) == (value(to) < 0)) return true;  // that was no bracket
  // It has all roots that the old one has.
  for (const double root : {first, second, third})
    if ((real_pair || root == first) && exact(root) > from && exact(root) < to && !(exact(root) > lo && exact(root) < hi)) return false;
  return (value(lo) < 0) == (value(from) < 0) && (value(hi) < 0) == (value(to) < 0);
}
#endif

// ---- knots

// Each coefficient that a knot makes is a mean of two; the error that is carried grows by more than any of them is off.
exact knot_off, knot_error;
bool knots_hold;
F watched(F a, F b, F weight, F knot, F first, F last) {
  const F v = mixed(a, b, weight);
  exact share = of(last) > of(first) ? (of(knot) - of(first)) / (of(last) - of(first)) : exact(knot > first);
  share = most(least(share, 1), 0);
  knot_off = most(knot_off, magnitude(of(v) - (of(a) + share * (of(b) - of(a)))));
  return v;
}
void next_knot(F error) {
  knots_hold = knots_hold && at_most(knot_off, of(error) - knot_error);
  knot_off = 0;
  knot_error = of(error);
}
#undef COUNT
#define COUNT(lanes) next_knot(error);
#define mixed(a, b, weight) watched(a, b, weight, knot, t[i], t[i + IRT_DEGREE])
#define search_cell search_by_knots
#define knot_of next_place
#include "frustum_knots.cl"
F next_place(F zero, F, F) { return zero; }

CONTRACT(knots) {
  CELL cell = some_cell(rng);
  if (!(cell.lo < cell.hi)) return true;
  cell.lo = (F)0, cell.hi = (F)1;
  cell.reach = rounded(rng.size(-20, -8));
  cell.in_lo = (F)0, cell.in_hi = (F)1;
  FOUND found;
  found.hits = found.touches = found.spent = NONE;
  knot_off = knot_error = 0;
  knots_hold = true;
  search_by_knots(&cell, ALL, 12, &found);
  return knots_hold;
}
}  // namespace
