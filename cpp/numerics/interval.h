// Intervals with double ends, rounded outward: the first and fastest arithmetic of the reference.
//
// Nothing here is shared with the kernels, and neither the domains nor the pads come from their operator table:
// a mistake in one is not a mistake in the other. Domains follow IEEE 1788, as in mpfr_interval.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "expr/expr.h"

namespace irt::numerics {

// The next doubles outward, or a little further: v was rounded to nearest by one operation. Where that overflowed, the
// largest double is the bound.
inline double down(double v, double relative = 0x1.8p-52) {
  const double finite = std::min(v, std::numeric_limits<double>::max());
  return finite - (std::fabs(finite) * relative + 0x1p-1074);
}
inline double up(double v, double relative = 0x1.8p-52) { return -down(-v, relative); }

struct Interval {
  double lo = 0, hi = 0;
  bool empty = false;     // defined nowhere
  bool doubtful = false;  // not proven defined and continuous everywhere

  Interval() = default;
  explicit Interval(double v) : lo(v), hi(v) {}
  Interval(double lo, double hi) : lo(lo), hi(hi) {}

  // -1 or 1 where all values have that sign, else 0.
  int sign() const { return empty ? 0 : lo > 0 ? 1 : hi < 0 ? -1 : 0; }
  bool finite() const { return std::isfinite(lo) && std::isfinite(hi); }
};

inline Interval operator+(const Interval& a, const Interval& b) { return {down(a.lo + b.lo), up(a.hi + b.hi)}; }
inline Interval operator-(const Interval& a) { return {-a.hi, -a.lo}; }
inline Interval operator-(const Interval& a, const Interval& b) { return {down(a.lo - b.hi), up(a.hi - b.lo)}; }
Interval operator*(const Interval& a, const Interval& b);

// The operator over intervals; `exponent` is that of an integer power, 0 for others. Conditions are intervals too: 0 for
// false, 1 for true, [0, 1] for either.
Interval apply(Op op, long exponent, std::span<const Interval* const> args);

}  // namespace irt::numerics
