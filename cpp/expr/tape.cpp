// The tape: one step for each distinct part of the expression, block by block to stay in the cache.
#include "expr/tape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "expr/build.h"
#include "expr/calculus.h"

namespace irt {
namespace {

constexpr std::size_t kBlock = 256;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Where something is undefined, it and what is made of it are nan: infinity is what is too large, never a division by zero.
// Conditions are 1, 0, or nan where they compare what is undefined.
bool undefined(double a) { return std::isnan(a); }
bool undefined(double a, double b) { return std::isnan(a) || std::isnan(b); }

double integer_power(double v, long n) {
  if (v == 0 && n < 0) return kNan;
  double r = 1, square = v;
  for (unsigned long m = static_cast<unsigned long>(std::labs(n)); m; m >>= 1, square *= square)
    if (m & 1) r *= square;
  return n < 0 ? 1 / r : r;
}

double modulo(double a, double b) {
  double r = std::fmod(a, b);
  if (r != 0 && (r < 0) != (b < 0)) r += b;
  return r;
}

double apply(Op op, double a) {
  switch (op) {
    case Op::Sin: return std::sin(a);
    case Op::Cos: return std::cos(a);
    case Op::Tan: return std::tan(a);
    case Op::Asin: return std::asin(a);
    case Op::Acos: return std::acos(a);
    case Op::Atan: return std::atan(a);
    case Op::Sinh: return std::sinh(a);
    case Op::Cosh: return std::cosh(a);
    case Op::Tanh: return std::tanh(a);
    case Op::Exp: return std::exp(a);
    case Op::Log: return a > 0 ? std::log(a) : kNan;
    case Op::Cbrt: return std::cbrt(a);
    case Op::Abs: return std::fabs(a);
    case Op::Sign: return undefined(a) ? kNan : static_cast<double>((a > 0) - (a < 0));
    case Op::Floor: return std::floor(a);
    case Op::Ceiling: return std::ceil(a);
    case Op::Not: return undefined(a) ? kNan : a == 0;
    default: return kNan;
  }
}

double apply(Op op, double a, double b) {
  switch (op) {
    case Op::Add: return a + b;
    case Op::Mul: return a * b;
    case Op::Mod: return modulo(a, b);
    case Op::And: return a == 0 || b == 0 ? 0 : undefined(a, b) ? kNan : 1;
    case Op::Or: return a == 1 || b == 1 ? 1 : undefined(a, b) ? kNan : 0;
    default: break;
  }
  if (undefined(a, b)) return kNan;
  switch (op) {
    case Op::Pow: return a < 0 || (a == 0 && b < 0) ? kNan : std::pow(a, b);
    case Op::Atan2: return a == 0 && b == 0 ? kNan : std::atan2(a, b);
    case Op::Min: return std::min(a, b);
    case Op::Max: return std::max(a, b);
    case Op::Less: return a < b;
    case Op::LessEqual: return a <= b;
    case Op::Equal: return a == b;
    case Op::Unequal: return a != b;
    default: return kNan;
  }
}

}  // namespace

Tape::Tape(const Expr& e) {
  count_nodes(e);
  for (const std::string& s : free_symbols(e)) symbols_.push_back(s);
  std::unordered_map<const Node*, std::size_t> index;
  for (const Expr& p : postorder(e)) {
    Step step{.op = p.op(), .args = {}};
    for (const Expr& a : p.args()) step.args.push_back(index.at(a.key()));
    switch (p.op()) {
      case Op::Number: step.value = p.number().get_d(); break;
      case Op::Pi: step.value = std::numbers::pi; break;
      case Op::E: step.value = std::numbers::e; break;
      case Op::True: step.value = 1; break;
      case Op::Symbol: step.input = static_cast<std::size_t>(std::lower_bound(symbols_.begin(), symbols_.end(), p.name()) - symbols_.begin()); break;
      case Op::Pow:
        if (const Expr& n = p.arg(1); n.op() == Op::Number && n.number().get_den() == 1 && n.number().get_num().fits_slong_p())
          step.exponent = n.number().get_num().get_si();
        break;
      default: break;
    }
    index.emplace(p.key(), steps_.size());
    steps_.push_back(std::move(step));
  }
}

void Tape::block(const Step& step, std::vector<double>& values, std::size_t at, std::span<const double* const> inputs, std::size_t first,
                 std::size_t n) const {
  double* r = &values[at * kBlock];
  const auto arg = [&](std::size_t i) { return &values[step.args[i] * kBlock]; };
  switch (step.op) {
    case Op::Number:
    case Op::Pi:
    case Op::E:
    case Op::True:
    case Op::False: std::fill_n(r, n, step.value); return;
    case Op::Symbol: std::copy_n(inputs[step.input] + first, n, r); return;
    case Op::Pow:
      if (step.exponent) {
        for (std::size_t i = 0; i < n; ++i) r[i] = integer_power(arg(0)[i], step.exponent);
        return;
      }
      break;
    case Op::Piecewise:
      std::fill_n(r, n, kNan);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < step.args.size(); k += 2)
          if (const double holds = arg(k + 1)[i]; holds != 0) {
            r[i] = undefined(holds) ? kNan : arg(k)[i];
            break;
          }
      return;
    default: break;
  }
  if (step.args.size() == 1) {
    for (std::size_t i = 0; i < n; ++i) r[i] = apply(step.op, arg(0)[i]);
    return;
  }
  for (std::size_t i = 0; i < n; ++i) r[i] = apply(step.op, arg(0)[i], arg(1)[i]);
  for (std::size_t k = 2; k < step.args.size(); ++k)
    for (std::size_t i = 0; i < n; ++i) r[i] = apply(step.op, r[i], arg(k)[i]);
}

void Tape::run(std::span<const double* const> inputs, double* result, std::size_t count) const {
  std::vector<double> values(steps_.size() * kBlock);
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t n = std::min(kBlock, count - first);
    for (std::size_t s = 0; s < steps_.size(); ++s) block(steps_[s], values, s, inputs, first, n);
    std::copy_n(&values[(steps_.size() - 1) * kBlock], n, result + first);
  }
}

}  // namespace irt
