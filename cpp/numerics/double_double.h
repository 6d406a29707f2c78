// Unevaluated sums of two doubles: some 104 bits, by exact sums and products (Dekker, Knuth).
#pragma once

#include <cmath>

namespace irt::numerics {

struct DoubleDouble {
  double hi = 0, lo = 0;

  DoubleDouble() = default;
  explicit DoubleDouble(double v) : hi(v) {}
  DoubleDouble(double hi, double lo) : hi(hi), lo(lo) {}
};

// Bounds the error of one sum or product, in parts of the result; of a mean, in parts of the larger of the two.
constexpr double kDoubleDoubleUnit = 0x1p-102;

// |a| >= |b|, or a is zero.
inline DoubleDouble quick_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

inline DoubleDouble exact_sum(double a, double b) {
  const double s = a + b, t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}

inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = exact_sum(a.hi, b.hi), t = exact_sum(a.lo, b.lo), v = quick_sum(s.hi, s.lo + t.hi);
  return quick_sum(v.hi, v.lo + t.lo);
}

// The same in fewer steps: the error of a sum of opposite signs is bounded in parts of |a| + |b|, not of the result.
inline DoubleDouble near_sum(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = exact_sum(a.hi, b.hi);
  return quick_sum(s.hi, s.lo + (a.lo + b.lo));
}

inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const double p = a.hi * b.hi;
  return quick_sum(p, __builtin_fma(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi));
}

}  // namespace irt::numerics
