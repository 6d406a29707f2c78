// Substitution, derivatives, simplification.
#include "expr/calculus.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/node.h"

namespace irt {
namespace {

using Memo = std::unordered_map<const Node*, Expr>;

// e rebuilt from new arguments; the same node where none changed.
Expr rebuild(const Expr& e, const Memo& memo) {
  std::vector<Expr> args;
  bool changed = false;
  for (const Expr& a : e.args()) {
    args.push_back(memo.at(a.key()));
    changed = changed || !(args.back() == a);
  }
  return changed ? call(e.op(), args) : e;
}

Expr function(Op op, const Expr& a) { return call(op, std::span(&a, 1)); }
Expr one() { return Expr(1L); }
Expr square(const Expr& a) { return pow(a, Expr(2L)); }
Expr inverse(const Expr& a) { return pow(a, Expr(-1L)); }

// d e / d (argument i), for functions of one or two arguments.
Expr partial(const Expr& e, std::size_t i) {
  const Expr& a = e.arg(0);
  switch (e.op()) {
    case Op::Sin: return function(Op::Cos, a);
    case Op::Cos: return neg(function(Op::Sin, a));
    case Op::Tan: return add(one(), square(e));
    case Op::Asin: return inverse(sqrt(sub(one(), square(a))));
    case Op::Acos: return neg(inverse(sqrt(sub(one(), square(a)))));
    case Op::Atan: return inverse(add(one(), square(a)));
    case Op::Atan2: {
      const Expr r2 = add(square(a), square(e.arg(1)));
      return i == 0 ? div(e.arg(1), r2) : neg(div(a, r2));
    }
    case Op::Sinh: return function(Op::Cosh, a);
    case Op::Cosh: return function(Op::Sinh, a);
    case Op::Tanh: return sub(one(), square(e));
    case Op::Exp: return e;
    case Op::Log: return inverse(a);
    case Op::Cbrt: return div(number(mpq_class(1, 3)), square(e));
    case Op::Abs: return function(Op::Sign, a);
    case Op::Mod: return i == 0 ? one() : neg(function(Op::Floor, div(a, e.arg(1))));
    default: return Expr(0L);  // sign, floor, ceiling
  }
}

// Min and Max: the derivative of the argument that decides.
Expr extreme_derivative(const Expr& e, const Memo& d) {
  std::vector<Expr> branches;
  for (std::size_t i = 0; i < e.arity(); ++i) {
    std::vector<Expr> conditions;
    for (std::size_t j = 0; j < e.arity(); ++j) {
      if (j == i) continue;
      const Expr pair[] = {e.op() == Op::Min ? e.arg(i) : e.arg(j), e.op() == Op::Min ? e.arg(j) : e.arg(i)};
      conditions.push_back(call(Op::LessEqual, pair));
    }
    branches.push_back(d.at(e.arg(i).key()));
    branches.push_back(i + 1 == e.arity() ? call(Op::True, {}) : call(Op::And, conditions));
  }
  return call(Op::Piecewise, branches);
}

Expr derivative(const Expr& e, const std::string& symbol, const Memo& d) {
  const auto of = [&](const Expr& a) -> const Expr& { return d.at(a.key()); };
  switch (e.op()) {
    case Op::Number:
    case Op::Pi:
    case Op::E: return Expr(0L);
    case Op::Symbol: return Expr(e.name() == symbol ? 1L : 0L);
    case Op::Add: {
      std::vector<Expr> terms;
      for (const Expr& a : e.args()) terms.push_back(of(a));
      return add(terms);
    }
    case Op::Mul: {
      std::vector<Expr> terms;
      for (std::size_t i = 0; i < e.arity(); ++i) {
        if (of(e.arg(i)) == Expr(0L)) continue;
        std::vector<Expr> factors(e.args().begin(), e.args().end());
        factors[i] = of(e.arg(i));
        terms.push_back(mul(factors));
      }
      return add(terms);
    }
    case Op::Pow: {
      const Expr &b = e.arg(0), &n = e.arg(1);
      const Expr by_base = of(b) == Expr(0L) ? Expr(0L) : mul(mul(n, pow(b, sub(n, one()))), of(b));
      if (of(n) == Expr(0L)) return by_base;
      return add(by_base, mul(mul(e, function(Op::Log, b)), of(n)));
    }
    case Op::Min:
    case Op::Max: return extreme_derivative(e, d);
    case Op::Piecewise: {
      std::vector<Expr> args;
      for (std::size_t i = 0; i < e.arity(); i += 2) {
        args.push_back(of(e.arg(i)));
        args.push_back(e.arg(i + 1));
      }
      return call(Op::Piecewise, args);
    }
    default: break;
  }
  std::vector<Expr> terms;
  for (std::size_t i = 0; i < e.arity(); ++i)
    if (!(of(e.arg(i)) == Expr(0L))) terms.push_back(mul(partial(e, i), of(e.arg(i))));
  return add(terms);
}

bool even(const Expr& n) { return n.op() == Op::Number && n.number().get_den() == 1 && mpz_even_p(n.number().get_num_mpz_t()); }

// -a for a product with a negative number in front, or a sum whose first term has one.
std::optional<Expr> without_minus(const Expr& a) {
  const auto negative = [](const Expr& e) { return sgn(split_coefficient(e).first) < 0; };
  if (negative(a)) return neg(a);
  if (a.op() == Op::Add && negative(a.arg(0))) {
    std::vector<Expr> terms;
    for (const Expr& t : a.args()) terms.push_back(neg(t));
    return add(terms);
  }
  return std::nullopt;
}

Expr simplified(const Expr& e) {
  switch (e.op()) {
    case Op::Pow:
      // |a|**2n = a**2n; (-a)**2n = a**2n
      if (even(e.arg(1))) {
        if (e.arg(0).op() == Op::Abs) return pow(e.arg(0).arg(0), e.arg(1));
        if (const auto a = without_minus(e.arg(0))) return pow(*a, e.arg(1));
      }
      // (a**2n)**(1/2) = |a**n|
      if (e.arg(1) == number(mpq_class(1, 2)) && e.arg(0).op() == Op::Pow && even(e.arg(0).arg(1)) && sgn(e.arg(0).arg(1).number()) > 0)
        return function(Op::Abs, pow(e.arg(0).arg(0), number(e.arg(0).arg(1).number() / 2)));
      break;
    case Op::Sin:
    case Op::Tan:
    case Op::Asin:
    case Op::Atan:
    case Op::Sinh:
    case Op::Tanh:
    case Op::Cbrt:
    case Op::Sign:
      if (const auto a = without_minus(e.arg(0))) return neg(function(e.op(), *a));
      break;
    case Op::Cos:
    case Op::Cosh:
      if (e.arg(0).op() == Op::Abs) return function(e.op(), e.arg(0).arg(0));
      if (const auto a = without_minus(e.arg(0))) return function(e.op(), *a);
      break;
    case Op::Abs: {
      if (const auto a = without_minus(e.arg(0))) return function(Op::Abs, *a);
      const Expr& a = e.arg(0);
      if ((a.op() == Op::Pow && even(a.arg(1))) || a.op() == Op::Exp || a.op() == Op::Cosh || a.op() == Op::Pi) return a;
      break;
    }
    case Op::Log:
      if (e.arg(0).op() == Op::Exp) return e.arg(0).arg(0);
      break;
    case Op::Add: {
      // sin(a)**2 + cos(a)**2 = 1, with equal coefficients
      for (const Expr& s : e.args()) {
        const auto [c, r] = split_coefficient(s);
        if (r.op() != Op::Pow || !(r.arg(1) == Expr(2L)) || r.arg(0).op() != Op::Sin) continue;
        const Expr partner = mul(number(c), square(function(Op::Cos, r.arg(0).arg(0))));
        for (const Expr& t : e.args())
          if (t == partner) {
            std::vector<Expr> rest{number(c)};
            for (const Expr& u : e.args())
              if (!(u == s) && !(u == t)) rest.push_back(u);
            return add(rest);
          }
      }
      break;
    }
    default: break;
  }
  return e;
}

}  // namespace

std::set<std::string> free_symbols(const Expr& e) {
  std::set<std::string> names;
  for (const Expr& p : postorder(e))
    if (p.op() == Op::Symbol) names.insert(p.name());
  return names;
}

Expr substitute(const Expr& e, const std::vector<std::pair<Expr, Expr>>& pairs) {
  Memo replacement, memo;
  for (const auto& [from, to] : pairs) replacement.emplace(from.key(), to);
  // What has become undefined is an error only where it is needed: a Piecewise whose condition fails does not.
  std::unordered_map<const Node*, ExpressionError> undefined;
  const auto of = [&](const Expr& a) -> const Expr& {
    if (const auto it = undefined.find(a.key()); it != undefined.end()) throw it->second;
    return memo.at(a.key());
  };
  for (const Expr& p : postorder(e)) {
    if (const auto it = replacement.find(p.key()); it != replacement.end()) {
      memo.emplace(p.key(), it->second);
      continue;
    }
    try {
      std::vector<Expr> args;
      if (p.op() == Op::Piecewise) {
        for (std::size_t i = 0; i < p.arity() && (i == 0 || args.back().op() != Op::True); i += 2) {
          const Expr& condition = of(p.arg(i + 1));
          args.push_back(condition.op() == Op::False ? Expr(0L) : of(p.arg(i)));
          args.push_back(condition);
        }
      } else {
        for (const Expr& a : p.args()) args.push_back(of(a));
      }
      memo.emplace(p.key(), std::ranges::equal(args, p.args()) ? p : call(p.op(), args));
    } catch (const ExpressionError& error) {
      undefined.emplace(p.key(), error);
    }
  }
  return of(e);
}

Expr differentiate(const Expr& e, const std::string& symbol) {
  if (e.is_condition()) throw ExpressionError("a condition has no derivative");
  count_nodes(e);
  Memo d;
  std::size_t arguments = 0;
  for (const Expr& p : postorder(e)) {
    if (p.is_condition()) continue;
    const Expr& r = d.emplace(p.key(), derivative(p, symbol, d)).first->second;
    arguments += r.arity();
    if (arguments > limits::kDerivativeArguments)
      throw LimitError(fmt::format("the derivative has {} arguments or more in all; the limit is {}; the formula is too deep for it", arguments, limits::kDerivativeArguments));
  }
  return d.at(e.key());
}

Expr simplify(const Expr& e) {
  count_nodes(e);
  Expr current = e;
  // Each pass can open the way for another; few are ever needed.
  for (int pass = 0; pass < 8; ++pass) {
    Memo memo;
    for (const Expr& p : postorder(current)) try {
        memo.emplace(p.key(), simplified(rebuild(p, memo)));
      } catch (const ExpressionError&) {
        memo.emplace(p.key(), p);  // undefined everywhere, which only the formula as it is can say
      }
    const Expr next = memo.at(current.key());
    if (next == current) break;
    current = next;
  }
  return current;
}

}  // namespace irt
