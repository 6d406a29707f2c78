// Every operator over intervals of doubles.
#include "numerics/interval.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "error.h"

namespace irt::numerics {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// The C library's functions are good to 4 ulp (glibc manual, "Known Maximum Errors in Math Functions"); this allows 12.
double below(double v) { return down(v, 0x1.8p-49); }
double above(double v) { return up(v, 0x1.8p-49); }

Interval entire() { return {-kInf, kInf}; }

Interval doubted(Interval a) {
  a.doubtful = true;
  return a;
}

Interval nothing() {
  Interval r;
  r.empty = r.doubtful = true;
  return r;
}

bool holds_zero(const Interval& a) { return a.lo <= 0 && a.hi >= 0; }

template <class F>
Interval rising(const Interval& a, F f) {
  return {below(f(a.lo)), above(f(a.hi))};
}

Interval within(Interval a, double lo, double hi) {
  a.lo = std::max(a.lo, lo);
  a.hi = std::min(a.hi, hi);
  return a;
}

// The part of a inside [lo, hi].
Interval cut(const Interval& a, double lo, double hi) {
  if (a.hi < lo || a.lo > hi) return nothing();
  Interval r = within(a, lo, hi);
  r.doubtful = a.lo < lo || a.hi > hi;
  return r;
}

Interval magnitude(const Interval& a) {
  if (a.lo >= 0) return a;
  if (a.hi <= 0) return {-a.hi, -a.lo};
  return {0, std::max(-a.lo, a.hi)};
}

Interval reciprocal(const Interval& a) {
  if (a.lo == 0 && a.hi == 0) return nothing();
  if (!holds_zero(a)) return {down(1 / a.hi), up(1 / a.lo)};
  Interval r = entire();
  if (a.lo == 0) r.lo = down(1 / a.hi);
  if (a.hi == 0) r.hi = up(1 / a.lo);
  return doubted(r);
}

// base ** n for base >= 0 by squaring; each product rounded the same way.
double power_below(double base, unsigned long n) {
  if (n == 1 || base == 0) return base;
  double r = 1;
  for (double square = base; n; n >>= 1, square = std::max(0.0, down(square * square)))
    if (n & 1) r = std::max(0.0, down(r * square));
  return std::isnan(r) ? 0 : r;
}

double power_above(double base, unsigned long n) {
  if (n == 1 || base == 0) return base;
  double r = 1;
  for (double square = base; n; n >>= 1, square = up(square * square))
    if (n & 1) r = up(r * square);
  return std::isnan(r) ? kInf : r;
}

Interval integer_power(const Interval& a, long exponent) {
  const unsigned long n = static_cast<unsigned long>(std::labs(exponent));
  Interval r;
  if (n % 2 == 0 || a.lo >= 0) {
    const Interval m = magnitude(a);
    r = {power_below(m.lo, n), power_above(m.hi, n)};
  } else if (a.hi <= 0) {
    r = {-power_above(-a.lo, n), -power_below(-a.hi, n)};
  } else {
    r = {-power_above(-a.lo, n), power_above(a.hi, n)};
  }
  return exponent < 0 ? reciprocal(r) : r;
}

Interval logarithm(const Interval& a) {
  if (a.hi <= 0) return nothing();
  if (a.lo <= 0) return doubted({-kInf, above(std::log(a.hi))});
  return rising(a, [](double v) { return std::log(v); });
}

// x ** y = exp(y log x) for x >= 0; 0 ** y is 0 for y > 0.
Interval real_power(const Interval& a, const Interval& b) {
  Interval x = cut(a, 0, kInf);
  if (x.empty || (x.hi == 0 && b.hi <= 0)) return nothing();
  Interval r{kInf, -kInf};
  for (const double s : {x.lo, x.hi})
    for (const double t : {b.lo, b.hi}) {
      const double v = std::pow(s, t);  // never nan for s >= 0 here: 1 ** inf is 1, 0 ** -y inf
      r.lo = std::min(r.lo, below(v));
      r.hi = std::max(r.hi, above(v));
    }
  r.lo = std::max(r.lo, 0.0);
  if (x.lo == 0) {
    r.lo = 0;
    if (b.lo < 0) r.hi = kInf;
  }
  if (holds_zero(b)) {
    r.lo = std::min(r.lo, 1.0);
    r.hi = std::max(r.hi, 1.0);
  }
  r.doubtful = x.doubtful || (x.lo == 0 && b.lo <= 0);
  return r;
}

// Whether offset + period k may lie in a. Arguments past 1e9 count as if it did: no scene needs them.
bool meets(const Interval& a, double offset, double period) {
  if (!(std::fabs(a.lo) < 1e9 && std::fabs(a.hi) < 1e9)) return true;
  const double first = (a.lo - offset) / period, last = (a.hi - offset) / period;
  const double slack = 1e-15 * (2 + std::fabs(first) + std::fabs(last));
  return std::floor(last + slack) >= std::ceil(first - slack);
}

template <class F>
Interval wave(const Interval& a, F f, double peak) {
  constexpr double pi = std::numbers::pi;
  Interval r{-1, 1};
  if (!a.finite()) return r;
  const double s = f(a.lo), t = f(a.hi);
  if (!meets(a, peak, 2 * pi)) r.hi = std::min(1.0, above(std::max(s, t)));
  if (!meets(a, peak + pi, 2 * pi)) r.lo = std::max(-1.0, below(std::min(s, t)));
  return r;
}

Interval angle(const Interval& y, const Interval& x) {
  constexpr double pi = 0x1.921fb54442d19p+1;  // above pi
  if (holds_zero(y) && x.lo <= 0) {
    if (y.lo == 0 && y.hi == 0 && x.lo == 0 && x.hi == 0) return nothing();
    return doubted({y.lo >= 0 ? 0 : -pi, pi});
  }
  Interval r{kInf, -kInf};
  for (const double s : {y.lo, y.hi})
    for (const double t : {x.lo, x.hi}) {
      const double v = std::atan2(s, t);
      r.lo = std::min(r.lo, below(v));
      r.hi = std::max(r.hi, above(v));
    }
  return r;
}

template <class F>
Interval step(const Interval& a, F f) {
  Interval r{f(a.lo), f(a.hi)};
  r.doubtful = r.lo != r.hi;
  return r;
}

Interval modulo(const Interval& a, const Interval& b) {
  if (b.lo == 0 && b.hi == 0) return nothing();
  if (!holds_zero(b)) {
    const Interval k = step(a * reciprocal(b), [](double v) { return std::floor(v); });
    if (k.lo == k.hi && std::isfinite(k.lo)) return a - b * k;
  }
  return doubted({std::min(0.0, b.lo), std::max(0.0, b.hi)});
}

Interval truth(bool may_be_false, bool may_be_true) { return {may_be_false ? 0.0 : 1.0, may_be_true ? 1.0 : 0.0}; }
bool may_be(const Interval& condition, bool value) { return value ? condition.hi > 0 : condition.lo == 0; }

Interval piecewise(std::span<const Interval* const> args) {
  Interval r{kInf, -kInf};
  bool any = false, doubtful = false;
  for (std::size_t i = 0; i + 1 < args.size(); i += 2) {
    const Interval &value = *args[i], &condition = *args[i + 1];
    if (!may_be(condition, true)) continue;
    doubtful = doubtful || value.doubtful || condition.doubtful;
    if (!value.empty) {
      r.lo = std::min(r.lo, value.lo);
      r.hi = std::max(r.hi, value.hi);
      any = true;
    }
    if (!may_be(condition, false)) {
      if (!any) return nothing();
      r.doubtful = doubtful;
      return r;
    }
    doubtful = true;  // another branch may hold as well
  }
  return any ? doubted(r) : nothing();
}

Interval compute(Op op, long exponent, std::span<const Interval* const> args) {
  const auto a = [&]() -> const Interval& { return *args[0]; };
  const auto b = [&]() -> const Interval& { return *args[1]; };
  const auto fold = [&](auto f) {
    Interval r = a();
    for (std::size_t i = 1; i < args.size(); ++i) r = f(r, *args[i]);
    return r;
  };
  const auto least = [](const Interval& s, const Interval& t) { return Interval{std::min(s.lo, t.lo), std::min(s.hi, t.hi)}; };
  const auto greatest = [](const Interval& s, const Interval& t) { return Interval{std::max(s.lo, t.lo), std::max(s.hi, t.hi)}; };
  const auto inside = [](const Interval& cutted, auto f) {
    if (cutted.empty) return cutted;
    Interval r = f(cutted);
    r.doubtful = cutted.doubtful;
    return r;
  };
  switch (op) {
    case Op::Add: return fold([](const Interval& s, const Interval& t) { return s + t; });
    case Op::Mul: return fold([](const Interval& s, const Interval& t) { return s * t; });
    case Op::Pow:
      if (exponent) return integer_power(a(), exponent);
      if (b().lo == 0.5 && b().hi == 0.5)
        return inside(cut(a(), 0, kInf), [](const Interval& c) { return Interval{std::max(0.0, down(std::sqrt(c.lo))), up(std::sqrt(c.hi))}; });
      return real_power(a(), b());
    case Op::Sin: return wave(a(), [](double v) { return std::sin(v); }, std::numbers::pi / 2);
    case Op::Cos: return wave(a(), [](double v) { return std::cos(v); }, 0);
    case Op::Tan:
      if (meets(a(), std::numbers::pi / 2, std::numbers::pi)) return doubted(entire());
      return rising(a(), [](double v) { return std::tan(v); });
    case Op::Asin: return inside(cut(a(), -1, 1), [](const Interval& c) { return rising(c, [](double v) { return std::asin(v); }); });
    case Op::Acos: return inside(cut(a(), -1, 1), [](const Interval& c) { return Interval{std::max(0.0, below(std::acos(c.hi))), above(std::acos(c.lo))}; });
    case Op::Atan: return rising(a(), [](double v) { return std::atan(v); });
    case Op::Atan2: return angle(a(), b());
    case Op::Sinh: return rising(a(), [](double v) { return std::sinh(v); });
    case Op::Cosh: return rising(magnitude(a()), [](double v) { return std::cosh(v); });
    case Op::Tanh: return within(rising(a(), [](double v) { return std::tanh(v); }), -1, 1);
    case Op::Exp: return within(rising(a(), [](double v) { return std::exp(v); }), 0, kInf);
    case Op::Log: return logarithm(a());
    case Op::Cbrt: return rising(a(), [](double v) { return std::cbrt(v); });
    case Op::Abs: return magnitude(a());
    case Op::Sign: return step(a(), [](double v) { return static_cast<double>((v > 0) - (v < 0)); });
    case Op::Floor: return step(a(), [](double v) { return std::floor(v); });
    case Op::Ceiling: return step(a(), [](double v) { return std::ceil(v); });
    case Op::Min:
    case Op::And: return fold(least);
    case Op::Max:
    case Op::Or: return fold(greatest);
    case Op::Mod: return modulo(a(), b());
    case Op::Less: return truth(a().hi >= b().lo, a().lo < b().hi);
    case Op::LessEqual: return truth(a().hi > b().lo, a().lo <= b().hi);
    case Op::Equal:
    case Op::Unequal: {
      const bool apart = a().hi < b().lo || b().hi < a().lo, same = a().lo == b().hi && a().hi == b().lo;
      return op == Op::Equal ? truth(!same, !apart) : truth(!apart, !same);
    }
    case Op::Not: return truth(may_be(a(), true), may_be(a(), false));
    default: throw ExpressionError("no interval for this operator");
  }
}

}  // namespace

Interval operator*(const Interval& a, const Interval& b) {
  if ((a.lo == 0 && a.hi == 0) || (b.lo == 0 && b.hi == 0)) return Interval(0);
  double lo = kInf, hi = -kInf;
  for (const double p : {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi}) {
    const double v = std::isnan(p) ? 0 : p;  // 0 * inf: the infinite end is a bound, never reached
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  return {down(lo), up(hi)};
}

Interval apply(Op op, long exponent, std::span<const Interval* const> args) {
  if (op == Op::Piecewise) return piecewise(args);
  bool doubtful = false;
  for (const Interval* a : args) {
    if (a->empty) return op < Op::Less ? nothing() : doubted({0, 1});  // a comparison of what has no value decides nothing
    doubtful = doubtful || a->doubtful;
  }
  Interval r = compute(op, exponent, args);
  if (!r.empty && (std::isnan(r.lo) || std::isnan(r.hi))) return doubted(entire());
  r.doubtful = r.doubtful || doubtful;
  return r;
}

}  // namespace irt::numerics
