// Contracts of isolate.cl, form.cl, contract.cl and bisection.cl: what the value and the slope of f in the middle of a piece leave of it, and where a
// march goes on.
#define IRT_AFFINE 1
#include "along.h"

namespace {
// Not nearer to another than the rounding of one step tells apart.
F near(exact v, Random& rng) { return rounded(static_cast<double>(v) * (1 + rng.sign() * rng.below(4) * 0.5 * ULP)); }

// Slopes of a window in units: no change of f by one takes less than `least`, nor more than `most`.
CONTRACT(open_window) {
  PATH path;
  path.ex = path.ey = path.ez = path.ux = path.uy = path.uz = path.gx = path.gy = path.gz = path.ox = path.oy = path.oz = (F)0;
#if IRT_SPLIT
  path.lux = path.luy = path.luz = path.lox = path.loy = path.loz = (F)0;
#endif
  const double a = rng.size(-20, 20), b = a * rng.size(0, 4), sign = rng.sign();
  slopes = sign > 0 ? ia(rounded(a), rounded(b)) : ia(rounded(-b), rounded(-a));
  const WINDOW w = open_window(&path, 0, 16);
  return w.steady && at_most(of(w.least) * exact(rounded(b)), kEnd) && at_most(kEnd, of(w.most) * exact(rounded(a)));
}

WINDOW some_window(Random& rng) {
  WINDOW w;
  w.below = w.above = NONE;
  w.steady = ALL;
  w.rising = rng.chance(0.5) ? ALL : NONE;
  w.least = rounded(rng.size(-20, 20));
  w.most = w.least * F(rounded(rng.size(0, 3)));
  w.lo = (F)0, w.hi = (F)kEnd;
  return w;
}

// A value of f, of which a step of `units` is made.
IA some_value(double units, F step, Random& rng) {
  const double v = rng.sign() * units / step.v, other = v * rng.between(0, 1.5);
  return v < other ? ia(rounded(v), rounded(other)) : ia(rounded(other), rounded(v));
}

// Where a window has no root: with the rounding of what is added to it, too.
CONTRACT(free_units) {
  const WINDOW w = some_window(rng);
  const F c = rounded(some_unit(rng));
  const IA f = some_value(std::fmax(double(c.v), 1) * rng.size(-20, 2), w.least, rng);
  const F clear = free_units(&w, c, f);
  const exact truth = of(max(f.lo, -f.hi)) * of(w.least);
  return clear < F(0) || (at_most(of(c + clear), of(c) + truth) && at_most(of(clear), truth));
}

// The root c - f / slope lies in what a cut leaves.
CONTRACT(newton_cut) {
  WINDOW w = some_window(rng);
  const F c = rounded(some_unit(rng));
  const IA f = some_value(std::fmax(double(c.v), 1) * rng.size(-20, 2), w.least, rng);
  const exact units[] = {of(w.least), of(w.most)}, sign = w.rising ? 1 : -1;
  newton_cut(&w, c, f, ALL);
  for (const exact unit : units)
    for (const F v : {f.lo, f.hi})
      if (const exact zero = of(c) - sign * of(v) * unit; zero >= 0 && zero <= exact(kEnd) && (!at_most(of(w.lo), zero) || !at_most(zero, of(w.hi)))) return false;
  return true;
}

// Signs are those of all that the form holds, without a pad.
CONTRACT(certain) {
  const F y = rounded(rng.sign() * rng.size(-10, 10)), z = rounded(rng.chance(0.3) ? 0 : rng.size(-10, 10));
  const FORM f = ra(near((magnitude(of(y)) + of(z)) * rng.sign(), rng), y, z), g = ra(y, near((magnitude(of(y)) + of(z)) * rng.sign(), rng), z);
  const exact off = magnitude(of(f.x)) - magnitude(of(f.y)) - of(f.z);
  return !((positive(f) | negative(f) | nonzero(f)) && off <= 0) && !(crosses(g) && magnitude(of(g.y)) - magnitude(of(g.x)) - of(g.z) <= 0);
}

namespace cheaply {
#define find_root find_cheaply
#include "contract.cl"
#undef find_root
}  // namespace cheaply

// What contraction leaves of a piece holds every zero that the form has there.
CONTRACT(contract) {
  const double step = std::floor(rng.chance(0.3) ? kEnd : rng.size(0, PATH_LEVELS)), from = rng.chance(0.5) ? 0 : std::floor((kEnd - step) * rng.unit());
  const double y = rng.sign() * rng.size(-20, 20), e = rng.part() * (rng.chance(0.3) ? 1 - rng.size(-30, -1) : 1);
  const double z = std::fabs(y) * (rng.chance(0.3) ? 0 : rng.size(-24, 20)), off = z * (rng.chance(0.8) ? rng.sign() : rng.between(-1, 1));
  FORM f = ra(rounded(off - y * e), rounded(y), rounded(z));
  const cheaply::CUT cut = cheaply::contract(f, rounded(from), rounded(step));
  // Zeros lie where x + y e is between -z and z.
  exact low = (-of(f.x) - of(f.z)) / of(f.y), high = (-of(f.x) + of(f.z)) / of(f.y);
  if (low > high) std::swap(low, high);
  low = most(low, -1), high = least(high, 1);
  if (low > high) return true;
  const exact half = exact(step) / 2;
  return at_most(of(cut.from), from + (1 + low) * half) && at_most(from + (1 + high) * half, of(cut.end));
}

// The bound of all roundings is in z.
CONTRACT(enclose_cheaply) {
  Told told(rng);
  const RAY ray = told.ray();
  const RANGE range = some_range(told.radius, rng);
  const PATH path = make_path(&ray, &range, told.q);
  answer = ra(rounded(rng.between(-1, 1)), rounded(rng.between(-1, 1)), rounded(rng.size(-20, 0)));
  slack = rounded(rng.size(-30, 0));
  I coarse;
  const FORM f = cheaply::enclose_cheaply(&path, 0, 16, &coarse);
  return at_most(of(answer.z) + of(slack), of(f.z));
}

// Searches that look at pieces of units, by a form that the sample chooses: what they look at is kept.
F first_from, last_from, last_to, sign_change;
bool looked;
FORM look(F from, F to, I* undefined, I* rough) {
  if (!looked) first_from = from;
  looked = true;
  last_from = from, last_to = to;
  *undefined = *rough = NONE;
  // c - sign_change: positive behind it, negative before.
  return ra(F(0.5) * (from + to) - sign_change, F(0.5) * (to - from), (F)0);
}
#define enclose(path, from, to, undefined, rough) look(from, to, undefined, rough)
#undef IRT_SLACK
#define IRT_SLACK 0
namespace heads {
#include "contract.cl"
}  // namespace heads

// Rays of a beam begin no later than what it has proven free of zeros ends.
CONTRACT(head) {
  Told told(rng);
  told.terms[1][6] = 1;
  told.q[8] = told.q[26] = rounded(told.radius * 1e-3);
  const RAY ray = told.ray();
  const RANGE range = some_range(told.radius, rng);
  if (!(range.out0 < range.out1)) return true;
  const PATH path = make_path(&ray, &range, told.q);
  HEAD head;
  head.from = rounded(static_cast<double>(place(path, some_unit(rng))));
  head.span = path.unit * F(100), head.sign = (F)-1;
  looked = false;
  sign_change = F(kEnd * 0.9);
  heads::find_root(&ray, &range, told.q, 1, &head, false);
  return !looked || first_from == F(0) || at_most(place(path, of(first_from)), of(head.from));
}

// What a beam hands on lies no later than the piece at which it has halted.
CONTRACT(halt) {
  Told told(rng);
  told.terms[1][6] = 1;
  RAY ray = told.ray();
  ray.bx = F(rounded(told.radius * rng.size(-20, -5)));
  for (int k = 0; k < 3; ++k) told.q[k] = -(told.q[3 + k] = rounded(told.radius * 4));  // beams are slender beside it
  const RANGE range = some_range(told.radius, rng);
  if (!(range.out0 < range.out1)) return true;
  const PATH path = make_path(&ray, &range, told.q);
  HEAD head;
  sign_change = F(std::floor(some_unit(rng)) + 0.5);
  looked = false;
  heads::find_root(&ray, &range, told.q, 32, &head, true);
  // The last piece that it has looked at, or what contraction has made of it, begins where f is still negative.
  return at_most(of(head.from), place(path, of(sign_change)));
}
}  // namespace
