// Functions, conditions and Piecewise in canonical form: only what is exact is folded.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_set>

#include "error.h"
#include "expr/build.h"
#include "expr/node.h"

namespace irt {
namespace {

constexpr std::array kFunctions = {
    FunctionName{"sin", Op::Sin, 1},        FunctionName{"cos", Op::Cos, 1},         FunctionName{"tan", Op::Tan, 1},
    FunctionName{"asin", Op::Asin, 1},      FunctionName{"acos", Op::Acos, 1},       FunctionName{"atan", Op::Atan, 1},
    FunctionName{"atan2", Op::Atan2, 2},    FunctionName{"sinh", Op::Sinh, 1},       FunctionName{"cosh", Op::Cosh, 1},
    FunctionName{"tanh", Op::Tanh, 1},      FunctionName{"exp", Op::Exp, 1},         FunctionName{"log", Op::Log, 1},
    FunctionName{"cbrt", Op::Cbrt, 1},      FunctionName{"Abs", Op::Abs, 1},         FunctionName{"sign", Op::Sign, 1},
    FunctionName{"floor", Op::Floor, 1},    FunctionName{"ceiling", Op::Ceiling, 1}, FunctionName{"Min", Op::Min, -1},
    FunctionName{"Max", Op::Max, -1},       FunctionName{"Mod", Op::Mod, 2},         FunctionName{"Eq", Op::Equal, 2},
    FunctionName{"Ne", Op::Unequal, 2},     FunctionName{"And", Op::And, -1},        FunctionName{"Or", Op::Or, -1},
    FunctionName{"Not", Op::Not, 1},
};

mpz_class floor_of(const mpq_class& q) {
  mpz_class r;
  mpz_fdiv_q(r.get_mpz_t(), q.get_num_mpz_t(), q.get_den_mpz_t());
  return r;
}

Expr truth(bool v) { return Store::make(v ? Op::True : Op::False, {}); }

// f of the number q where that is exact.
std::optional<Expr> fold(Op op, const mpq_class& q) {
  switch (op) {
    case Op::Sin:
    case Op::Tan:
    case Op::Asin:
    case Op::Atan:
    case Op::Sinh:
    case Op::Tanh:
      if (q == 0) return Expr(0L);
      break;
    case Op::Cos:
    case Op::Cosh:
      if (q == 0) return Expr(1L);
      break;
    case Op::Exp:
      if (q == 0) return Expr(1L);
      if (q == 1) return Store::make(Op::E, {});
      break;
    case Op::Log:
      if (q == 1) return Expr(0L);
      if (sgn(q) <= 0) throw ExpressionError(fmt::format("log({}) has no value", q.get_str()));
      break;
    case Op::Acos:
      if (q == 1) return Expr(0L);
      break;
    case Op::Cbrt: {
      mpz_class num, den;
      if (mpz_root(num.get_mpz_t(), q.get_num_mpz_t(), 3) && mpz_root(den.get_mpz_t(), q.get_den_mpz_t(), 3))
        return number(mpq_class(num, den));
      break;
    }
    case Op::Abs: return number(abs(q));
    case Op::Sign: return Expr(static_cast<long>(sgn(q)));
    case Op::Floor: return number(mpq_class(floor_of(q)));
    case Op::Ceiling: return number(mpq_class(-floor_of(-q)));
    default: break;
  }
  return std::nullopt;
}

Expr extreme(Op op, std::span<const Expr> args) {
  std::vector<Expr> kept;
  std::unordered_set<const Node*> seen;
  std::optional<mpq_class> best;
  const auto take = [&](const Expr& a) {
    if (a.op() == Op::Number) {
      if (!best || (op == Op::Min ? a.number() < *best : a.number() > *best)) best = a.number();
    } else if (seen.insert(a.key()).second) {
      kept.push_back(a);
    }
  };
  for (const Expr& a : args) {
    if (a.op() == op) {
      for (const Expr& b : a.args()) take(b);
    } else {
      take(a);
    }
  }
  if (best) kept.push_back(number(*best));
  if (kept.size() == 1) return kept[0];
  std::sort(kept.begin(), kept.end(), [](const Expr& a, const Expr& b) { return compare(a, b) < 0; });
  return Store::make(op, std::move(kept));
}

Expr comparison(Op op, const Expr& a, const Expr& b) {
  if (a.op() == Op::Number && b.op() == Op::Number) {
    const int c = cmp(a.number(), b.number());
    return truth(op == Op::Less ? c < 0 : op == Op::LessEqual ? c <= 0 : op == Op::Equal ? c == 0 : c != 0);
  }
  if ((op == Op::Equal || op == Op::Unequal) && compare(a, b) > 0) return Store::make(op, {b, a});
  return Store::make(op, {a, b});
}

Expr connective(Op op, std::span<const Expr> args) {
  const Op neutral = op == Op::And ? Op::True : Op::False, absorbing = op == Op::And ? Op::False : Op::True;
  std::vector<Expr> kept;
  for (const Expr& a : args) {
    if (a.op() == absorbing) return a;
    if (a.op() == neutral) continue;
    if (std::find(kept.begin(), kept.end(), a) == kept.end()) kept.push_back(a);
  }
  if (kept.empty()) return Store::make(neutral, {});
  if (kept.size() == 1) return kept[0];
  return Store::make(op, std::move(kept));
}

Expr piecewise(std::span<const Expr> args) {
  if (args.empty() || args.size() % 2) throw ExpressionError("Piecewise takes pairs (value, condition)");
  std::vector<Expr> kept;
  for (std::size_t i = 0; i < args.size(); i += 2) {
    if (args[i].is_condition()) throw ExpressionError("Piecewise takes pairs (value, condition): a value is missing");
    if (!args[i + 1].is_condition())
      throw ExpressionError("Piecewise takes pairs (value, condition): a condition is a comparison, Eq, Ne, And, Or, Not or True");
    if (args[i + 1].op() == Op::False) continue;
    kept.push_back(args[i]);
    kept.push_back(args[i + 1]);
    if (args[i + 1].op() == Op::True) break;
  }
  if (kept.empty()) throw ExpressionError("Piecewise has no condition that can hold");
  if (kept[1].op() == Op::True) return kept[0];
  return Store::make(Op::Piecewise, std::move(kept));
}

}  // namespace

std::span<const FunctionName> functions() { return kFunctions; }

const char* function_name(Op op) {
  for (const FunctionName& f : kFunctions)
    if (f.op == op) return f.name;
  return op == Op::Piecewise ? "Piecewise" : nullptr;
}

Expr call(Op op, std::span<const Expr> args) {
  if (op == Op::Add) return add(args);
  if (op == Op::Mul) return mul(args);
  if (op == Op::True || op == Op::False || op == Op::Pi || op == Op::E) return Store::make(op, {});
  if (op == Op::Piecewise) return piecewise(args);
  int arity = op == Op::Pow || op == Op::Less || op == Op::LessEqual ? 2 : 1;
  for (const FunctionName& f : kFunctions)
    if (f.op == op) arity = f.arity;
  const char* name = function_name(op);
  if (arity < 0 ? args.empty() : args.size() != static_cast<std::size_t>(arity))
    throw ExpressionError(fmt::format("{} takes {} argument{}, not {}", name ? name : "a comparison", arity < 0 ? "at least 1" : std::to_string(arity),
                                      arity == 1 || arity < 0 ? "" : "s", args.size()));
  const bool logical = op == Op::And || op == Op::Or || op == Op::Not;
  for (const Expr& a : args)
    if (a.is_condition() != logical)
      throw ExpressionError(logical ? fmt::format("{} takes conditions, such as x < 0", name)
                                    : "a condition cannot be used as a number; use Piecewise to give it values");
  switch (op) {
    case Op::Pow: return pow(args[0], args[1]);
    case Op::Min:
    case Op::Max: return extreme(op, args);
    case Op::Less:
    case Op::LessEqual:
    case Op::Equal:
    case Op::Unequal: return comparison(op, args[0], args[1]);
    case Op::And:
    case Op::Or: return connective(op, args);
    case Op::Not:
      if (args[0].op() == Op::True || args[0].op() == Op::False) return truth(args[0].op() == Op::False);
      if (args[0].op() == Op::Not) return args[0].arg(0);
      break;
    case Op::Mod:
      if (args[1].op() == Op::Number && sgn(args[1].number()) == 0) throw ExpressionError("Mod by zero has no value");
      if (args[0].op() == Op::Number && args[1].op() == Op::Number) {
        const mpq_class quotient = args[0].number() / args[1].number();
        return number(args[0].number() - args[1].number() * mpq_class(floor_of(quotient)));
      }
      break;
    case Op::Abs:
      if (args[0].op() == Op::Abs) return args[0];
      break;
    default: break;
  }
  if (args.size() == 1 && args[0].op() == Op::Number)
    if (const auto v = fold(op, args[0].number())) return *v;
  return Store::make(op, {args.begin(), args.end()});
}

}  // namespace irt
