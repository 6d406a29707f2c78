// Expression to program: iterative, sharing common subexpressions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "error.h"
#include "expr/build.h"
#include "expr/fraction.h"
#include "caps.h"
#include "program/numbering.h"

namespace irt::program {
namespace {

using numerics::Bounds;

// Sums and products of bounds: one rounding, undone by a step outward unless it was exact.
double down(double v, bool exact) { return exact ? v : std::nextafter(v, -HUGE_VAL); }
double up(double v, bool exact) { return exact ? v : std::nextafter(v, HUGE_VAL); }

Bounds plus(Bounds a, Bounds b) {
  const auto exact = [](double p, double q, double s) {
    const double t = s - p;
    return (p - (s - t)) + (q - t) == 0;  // Knuth's two-sum error
  };
  const double lo = a.lo + b.lo, hi = a.hi + b.hi;
  return {down(lo, exact(a.lo, b.lo, lo)), up(hi, exact(a.hi, b.hi, hi))};
}

Bounds times_bounds(Bounds a, Bounds b) {
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  for (double p : {a.lo, a.hi})
    for (double q : {b.lo, b.hi}) {
      const double v = p * q;
      const bool exact = std::fma(p, q, -v) == 0;
      lo = std::min(lo, down(v, exact));
      hi = std::max(hi, up(v, exact));
    }
  return {lo, hi};
}

class Lowering {
 public:
  Program run(const Expr& f, bool isovalue, const Expr* g, bool poles) {
    const auto whole = poles ? fraction(f) : std::nullopt;
    collect_parameters(f, g, whole);
    program_.result = value_of(f);
    if (g) program_.clip = value_of(*g);
    if (whole) program_.numerator = value_of(whole->numerator);
    program_.isovalue = isovalue;
    if (isovalue) {
      const Value iso = emit({.code = Code::Parameter, .index = static_cast<std::int64_t>(program_.parameters.size())});
      program_.result = binary(Code::Sub, program_.result, iso);
      if (whole) program_.numerator = binary(Code::Sub, program_.numerator, binary(Code::Mul, iso, value_of(whole->denominator)));
    }
    prune(program_);
    return std::move(program_);
  }

 private:
  Program program_;
  std::unordered_map<const Node*, bool> constant_;  // trees without symbols
  std::unordered_map<const Node*, Value> done_;
  Numbering numbering_{program_};

  void collect_parameters(const Expr& f, const Expr* g, const std::optional<Fraction>& whole) {
    std::set<std::string> names;
    std::vector<std::pair<Expr, bool>> stack{{f, false}};
    if (g) stack.emplace_back(*g, false);
    if (whole) stack.insert(stack.end(), {{whole->numerator, false}, {whole->denominator, false}});
    while (!stack.empty()) {
      auto [e, ready] = stack.back();
      stack.pop_back();
      if (constant_.count(e.key())) continue;
      if (e.op() == Op::Symbol) {
        if (e.name() != "x" && e.name() != "y" && e.name() != "z") names.insert(e.name());
        constant_[e.key()] = false;
      } else if (ready || e.arity() == 0) {
        bool constant = !e.is_condition() && e.op() != Op::Piecewise;
        for (const Expr& a : e.args()) constant = constant && constant_.at(a.key());
        constant_[e.key()] = constant;
      } else {
        stack.emplace_back(e, true);
        for (const Expr& a : e.args()) stack.emplace_back(a, false);
      }
    }
    program_.parameters.assign(names.begin(), names.end());
    if (names.size() > limits::kParameters)
      throw LimitError(fmt::format("the formula has {} parameters; the limit is {}", names.size(), limits::kParameters));
  }

  Value value_of(const Expr& f) {
    std::vector<std::pair<Expr, bool>> stack{{f, false}};
    while (!stack.empty()) {
      auto [e, ready] = stack.back();
      stack.pop_back();
      if (done_.count(e.key())) continue;
      if (constant_.at(e.key())) {
        done_[e.key()] = constant(numerics::enclose_constant(e));
      } else if (ready || e.arity() == 0) {
        done_[e.key()] = build(e);
      } else {
        stack.emplace_back(e, true);
        for (const Expr& a : e.args()) stack.emplace_back(a, false);
      }
    }
    return done_.at(f.key());
  }

  Value of(const Expr& e) const { return done_.at(e.key()); }

  Value emit(const Instruction& i) {
    const Value v = numbering_.emit(i);
    if (program_.code.size() > limits::kOperations)
      throw LimitError(fmt::format("the formula needs {} operations or more; the limit of one kernel is {}; shorten it or split it", program_.code.size(),
                                   limits::kOperations));
    return v;
  }

  Value constant(Bounds b) { return emit({.code = Code::Constant, .value = b, .nonnegative = b.lo >= 0}); }

  Value unary(Code code, Value a, bool nonnegative = false) {
    return emit({.code = code, .a = a, .nonnegative = nonnegative});
  }

  Value binary(Code code, Value a, Value b, bool nonnegative = false) {
    return emit({.code = code, .a = a, .b = b, .nonnegative = nonnegative});
  }

  bool nonnegative(Value v) const { return program_[v].nonnegative; }
  bool negative_constant(Value v) const { return program_.is_constant(v) && program_[v].value.hi < 0; }

  Value negate(Value v) {
    if (program_.is_constant(v)) return constant({-program_[v].value.hi, -program_[v].value.lo});
    if (program_[v].code == Code::Neg) return program_[v].a;
    return unary(Code::Neg, v);
  }

  bool is_one(Value v) const { return program_.is_constant(v) && program_[v].value.lo == 1 && program_[v].value.hi == 1; }

  Value multiply(Value a, Value b) {
    if (is_one(a)) return b;
    if (is_one(b)) return a;
    if (a == b) return unary(Code::Sqr, a, true);
    if (program_.is_constant(b)) std::swap(a, b);  // the constant first
    return binary(Code::Mul, a, b, nonnegative(a) && nonnegative(b));
  }

  Value integer_power(Value a, long n) {
    if (n == 1) return a;
    if (n == 2) return unary(Code::Sqr, a, true);
    return emit({.code = Code::Power, .a = a, .index = n, .nonnegative = n % 2 == 0 || nonnegative(a)});
  }

  // A term and the sign with which it enters a sum.
  struct Signed {
    Value value;
    bool minus;
  };

  // The terms of a sum that are numbers times powers of one coordinate become one polynomial in it, where they are many
  // and high enough to cancel. Returns those terms; appends the polynomials to `terms`.
  std::set<const Node*> group_polynomials(const Expr& e, std::vector<Signed>& terms) {
    constexpr long kLowest = 6, kHighest = 64;
    constexpr std::size_t kFewest = 3;
    const mpq_class smallest(1e-25);
    struct Term {
      const Node* key;
      long power;
      mpq_class coefficient;
    };
    std::map<std::string, std::vector<Term>> groups;
    for (const Expr& a : e.args()) {
      const auto [c, rest] = split_coefficient(a);
      const bool power = rest.op() == Op::Pow && rest.arg(1).op() == Op::Number && rest.arg(1).number().get_den() == 1;
      const Expr& base = power ? rest.arg(0) : rest;
      if (base.op() != Op::Symbol || (base.name() != "x" && base.name() != "y" && base.name() != "z")) continue;
      const long n = power ? rest.arg(1).number().get_num().get_si() : 1;
      if (n >= 1 && n <= kHighest) groups[base.name()].push_back({a.key(), n, c});
    }
    std::set<const Node*> taken;
    for (const auto& [name, found] : groups) {
      long degree = 0;
      for (const Term& t : found) degree = std::max(degree, t.power);
      if (found.size() < kFewest || degree < kLowest) continue;
      // Taylor forms bound roundings, which are parts of the terms; not that coefficients, or what they are multiplied by, may vanish in single precision.
      if (std::any_of(found.begin(), found.end(), [&](const Term& t) { return abs(t.coefficient) < smallest; })) continue;
      // Even polynomials are polynomials of the square: a quarter of the work, half of the rounding.
      const bool even = std::all_of(found.begin(), found.end(), [](const Term& t) { return t.power % 2 == 0; });
      const long share = even ? 2 : 1;
      std::vector<Bounds> coefficients(static_cast<std::size_t>(degree / share) + 1, Bounds{0, 0});
      for (const Term& t : found) {
        coefficients[static_cast<std::size_t>(t.power / share)] = numerics::enclose_constant(number(t.coefficient));
        taken.insert(t.key);
      }
      program_.polynomials.push_back(std::move(coefficients));
      const Value coordinate = emit({.code = Code::Coordinate, .index = name[0] - 'x'});
      const Value base = even ? unary(Code::Sqr, coordinate, true) : coordinate;
      terms.push_back({emit({.code = Code::Polynomial, .a = base, .index = static_cast<std::int64_t>(program_.polynomials.size() - 1)}), false});
    }
    return taken;
  }

  Value sum(const Expr& e) {
    // Products with a negative number in front are subtracted; numbers come last.
    std::vector<Signed> terms;
    std::optional<Value> shift;
    const std::set<const Node*> grouped = group_polynomials(e, terms);
    for (const Expr& a : e.args()) {
      if (grouped.count(a.key())) continue;
      const Value v = of(a);
      if (program_.is_constant(v)) {
        shift = shift ? constant(plus(program_[*shift].value, program_[v].value)) : v;
      } else if (program_[v].code == Code::Neg) {
        terms.push_back({program_[v].a, true});
      } else {
        terms.push_back({v, false});
      }
    }
    std::stable_partition(terms.begin(), terms.end(), [](const Signed& t) { return !t.minus; });
    Value total = terms[0].value;
    bool minus = terms[0].minus;  // only where all terms are
    for (std::size_t i = 1; i < terms.size(); ++i) {
      const Value v = terms[i].value;
      total = terms[i].minus == minus ? binary(Code::Add, total, v, nonnegative(total) && nonnegative(v))
                                      : binary(Code::Sub, total, v);
    }
    if (minus) total = negate(total);
    return shift ? binary(Code::Add, total, *shift, nonnegative(total) && nonnegative(*shift)) : total;
  }

  Value product(const Expr& e) {
    std::optional<Value> number, above, below;
    const auto times = [&](std::optional<Value>& into, Value v) { into = into ? multiply(*into, v) : v; };
    for (const Expr& a : e.args()) {
      if (constant_.at(a.key())) {
        const Value v = of(a);
        number = number ? constant(times_bounds(program_[*number].value, program_[v].value)) : v;
      } else if (const auto d = denominator(a)) {
        times(below, *d);
      } else {
        times(above, of(a));
      }
    }
    bool minus = false;
    if (number && negative_constant(*number)) {
      minus = true;
      number = negate(*number);
    }
    if (number && is_one(*number)) number.reset();
    Value v;
    if (below && above) {
      v = binary(Code::Div, *above, *below, nonnegative(*above) && nonnegative(*below));
    } else if (below) {
      v = unary(Code::Recip, *below, nonnegative(*below));
    } else {
      v = *above;
    }
    if (number) v = multiply(*number, v);
    return minus ? negate(v) : v;
  }

  // What stands below the line in b ** -n, or nothing. The value of the power itself is pruned later if not used.
  std::optional<Value> denominator(const Expr& e) {
    if (e.op() != Op::Pow || e.arg(1).op() != Op::Number || sgn(e.arg(1).number()) >= 0) return std::nullopt;
    const Value v = of(e);
    return program_[v].code == Code::Recip ? std::optional(program_[v].a) : std::nullopt;
  }

  Value power(const Expr& e) {
    const Expr& exponent = e.arg(1);
    if (e.arg(0).op() == Op::E) return unary(Code::Exp, of(exponent), true);
    const Value a = of(e.arg(0));
    if (!constant_.at(exponent.key())) return binary(Code::Pow, a, of(exponent), true);
    if (exponent.op() == Op::Number) {
      const mpq_class& q = exponent.number();
      if (q.get_den() == 1) {
        if (abs(q.get_num()) > limits::kExponent)
          throw LimitError(fmt::format("exponent {} is too large; the limit is {}", q.get_str(), limits::kExponent));
        const long n = q.get_num().get_si();
        const Value p = integer_power(a, std::abs(n));
        return n < 0 ? unary(Code::Recip, p, nonnegative(p)) : p;
      }
      if (q.get_den() == 2 && abs(q.get_num()) == 1) {
        const Value root = unary(Code::Sqrt, a, true);
        return sgn(q) < 0 ? unary(Code::Recip, root, true) : root;
      }
    }
    return emit({.code = Code::RealPower, .a = a, .value = numerics::enclose_constant(exponent), .nonnegative = true});
  }

  Value fold(Code code, const Expr& e, bool all, bool any) {
    Value v = of(e.arg(0));
    for (std::size_t i = 1; i < e.arity(); ++i) {
      const Value w = of(e.arg(i));
      const bool sign = (all && nonnegative(v) && nonnegative(w)) || (any && (nonnegative(v) || nonnegative(w)));
      v = binary(code, v, w, sign);
    }
    return v;
  }

  Value piecewise(const Expr& e) {
    std::size_t n = e.arity();
    Value v;
    if (n >= 2 && e.arg(n - 1).op() == Op::True) {
      v = of(e.arg(n - 2));
      n -= 2;
    } else {
      v = emit({.code = Code::Undefined});
    }
    for (; n >= 2; n -= 2) {
      const Value yes = of(e.arg(n - 2));
      v = emit({.code = Code::Select, .a = of(e.arg(n - 1)), .b = yes, .c = v,
                .nonnegative = nonnegative(yes) && nonnegative(v)});
    }
    return v;
  }

  Value build(const Expr& e) {
    const auto one = [&](Code code, bool sign = false) { return unary(code, of(e.arg(0)), sign); };
    const auto two = [&](Code code) { return binary(code, of(e.arg(0)), of(e.arg(1))); };
    const auto odd = [&](Code code) { return one(code, nonnegative(of(e.arg(0)))); };
    switch (e.op()) {
      case Op::Number:
      case Op::Pi:
      case Op::E: return constant(numerics::enclose_constant(e));
      case Op::Symbol: {
        static const std::string axes = "xyz";
        if (e.name().size() == 1)
          if (const auto axis = axes.find(e.name()); axis != std::string::npos)
            return emit({.code = Code::Coordinate, .index = static_cast<std::int64_t>(axis)});
        const auto at = std::lower_bound(program_.parameters.begin(), program_.parameters.end(), e.name());
        return emit({.code = Code::Parameter, .index = at - program_.parameters.begin()});
      }
      case Op::Add: return sum(e);
      case Op::Mul: return product(e);
      case Op::Pow: return power(e);
      case Op::Sin: return one(Code::Sin);
      case Op::Cos: return one(Code::Cos);
      case Op::Tan: return one(Code::Tan);
      case Op::Asin: return odd(Code::Asin);
      case Op::Acos: return one(Code::Acos, true);
      case Op::Atan: return odd(Code::Atan);
      case Op::Atan2: return two(Code::Atan2);
      case Op::Sinh: return odd(Code::Sinh);
      case Op::Cosh: return one(Code::Cosh, true);
      case Op::Tanh: return odd(Code::Tanh);
      case Op::Exp: return one(Code::Exp, true);
      case Op::Log: return one(Code::Log);
      case Op::Cbrt: return odd(Code::Cbrt);
      case Op::Abs: return one(Code::Abs, true);
      case Op::Sign: return odd(Code::Sign);
      case Op::Floor: return odd(Code::Floor);
      case Op::Ceiling: return odd(Code::Ceiling);
      case Op::Min: return fold(Code::Min, e, true, false);
      case Op::Max: return fold(Code::Max, e, false, true);
      case Op::Mod: return two(Code::Mod);
      case Op::Piecewise: return piecewise(e);
      case Op::Less: return two(Code::Less);
      case Op::LessEqual: return two(Code::LessEqual);
      case Op::Equal: return two(Code::Equal);
      case Op::Unequal: return unary(Code::Not, two(Code::Equal));
      case Op::And: return fold(Code::And, e, false, false);
      case Op::Or: return fold(Code::Or, e, false, false);
      case Op::Not: return one(Code::Not);
      case Op::True: return emit({.code = Code::True});
      case Op::False: return unary(Code::Not, emit({.code = Code::True}));
    }
    throw ExpressionError("unknown operator");
  }
};

}  // namespace

Program lower(const Expr& f, bool isovalue, const Expr* g, bool poles) {
  if (f.is_condition() || (g && g->is_condition()))
    throw ExpressionError("a condition is not a formula; use Piecewise to give it values");
  return Lowering().run(f, isovalue, g, poles);
}

void prune(Program& program) {
  std::vector<char> live(program.code.size(), 0);
  for (Value v : {program.result, program.clip, program.numerator, program.function})
    if (v >= 0) live[static_cast<std::size_t>(v)] = 1;
  for (std::size_t i = program.code.size(); i-- > 0;) {
    if (!live[i]) continue;
    const Instruction& in = program.code[i];
    for (Value v : {in.a, in.b, in.c})
      if (v >= 0) live[static_cast<std::size_t>(v)] = 1;
  }
  std::vector<Value> renamed(program.code.size(), -1);
  std::vector<Instruction> kept;
  for (std::size_t i = 0; i < program.code.size(); ++i) {
    if (!live[i]) continue;
    Instruction in = program.code[i];
    for (Value* v : {&in.a, &in.b, &in.c})
      if (*v >= 0) *v = renamed[static_cast<std::size_t>(*v)];
    renamed[i] = static_cast<Value>(kept.size());
    kept.push_back(in);
  }
  for (Value* v : {&program.result, &program.clip, &program.numerator, &program.function})
    if (*v >= 0) *v = renamed[static_cast<std::size_t>(*v)];
  program.code = std::move(kept);
}

}  // namespace irt::program
