// Fractions: sums are brought to a common denominator, from the leaves up; never recursive.
#include "expr/fraction.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "expr/build.h"

namespace irt {
namespace {

// A numerator may have as many arguments as the formula, times this, and a few more.
constexpr std::size_t kGrowth = 2, kMore = 64;
// Larger formulas are left as they are: kernels of that size cannot afford a second value.
constexpr std::size_t kParts = 2000;

bool is_one(const Expr& e) { return e == Expr(1L); }

// The signs that show in the form of e: 1 above zero, 0 never below; -1: nothing shows.
int shown_sign(const Expr& e, const std::unordered_map<const Node*, int>& known) {
  const auto of = [&](const Expr& a) { return known.at(a.key()); };
  switch (e.op()) {
    case Op::Number: return sgn(e.number()) > 0 ? 1 : sgn(e.number()) == 0 ? 0 : -1;
    case Op::Pi:
    case Op::E:
    case Op::Exp:
    case Op::Cosh: return 1;
    case Op::Abs: return 0;
    case Op::Add: {
      int sign = 0;
      for (const Expr& a : e.args()) {
        if (of(a) < 0) return -1;
        sign = std::max(sign, of(a));
      }
      return sign;
    }
    case Op::Mul: {
      int sign = 1;
      for (const Expr& a : e.args()) sign = std::min(sign, of(a));
      return sign;
    }
    case Op::Pow: {
      if (e.arg(1).op() != Op::Number) return -1;
      const mpq_class& n = e.arg(1).number();
      if (n.get_den() != 1) return of(e.arg(0)) > 0 ? 1 : 0;  // defined for bases that are not negative only
      if (mpz_even_p(n.get_num().get_mpz_t()) && sgn(n) > 0) return of(e.arg(0)) > 0 ? 1 : 0;
      return of(e.arg(0)) > 0 || sgn(n) > 0 ? of(e.arg(0)) : -1;
    }
    default: return -1;
  }
}

std::size_t count_arguments(const std::vector<Expr>& parts) {
  std::size_t n = 0;
  for (const Expr& p : parts) n += p.arity();
  return n;
}

Expr product_but(const std::vector<Expr>& all, std::size_t left_out) {
  std::vector<Expr> rest;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i != left_out) rest.push_back(all[i]);
  return mul(rest);
}

Fraction sum(const std::vector<Fraction>& terms) {
  std::vector<Expr> denominators;
  for (const Fraction& t : terms)
    if (!is_one(t.denominator) && std::find(denominators.begin(), denominators.end(), t.denominator) == denominators.end())
      denominators.push_back(t.denominator);
  std::vector<Expr> numerators;
  for (const Fraction& t : terms) {
    const auto own = static_cast<std::size_t>(std::find(denominators.begin(), denominators.end(), t.denominator) - denominators.begin());
    numerators.push_back(mul(t.numerator, product_but(denominators, own)));
  }
  return {add(numerators), mul(denominators)};
}

Fraction product(const std::vector<Fraction>& factors) {
  std::vector<Expr> numerators, denominators;
  for (const Fraction& f : factors) {
    numerators.push_back(f.numerator);
    denominators.push_back(f.denominator);
  }
  return {mul(numerators), mul(denominators)};
}

}  // namespace

std::optional<Fraction> fraction(const Expr& e) {
  const std::vector<Expr> order = postorder(e);
  if (order.size() > kParts) return std::nullopt;
  const std::size_t most = kGrowth * count_arguments(order) + kMore;
  std::unordered_map<const Node*, Fraction> done;
  std::unordered_map<const Node*, int> signs;
  std::unordered_map<const Node*, bool> varies;  // with where one is
  for (const Expr& v : order) {
    signs[v.key()] = shown_sign(v, signs);
    varies[v.key()] = v.op() == Op::Symbol ? v.name() == "x" || v.name() == "y" || v.name() == "z"
                                           : std::any_of(v.args().begin(), v.args().end(), [&](const Expr& a) { return varies.at(a.key()); });
    Fraction f{v, Expr(1L)};
    std::vector<Fraction> parts;
    if (v.op() == Op::Add || v.op() == Op::Mul)
      for (const Expr& a : v.args()) parts.push_back(done.at(a.key()));
    if (std::any_of(parts.begin(), parts.end(), [](const Fraction& p) { return !is_one(p.denominator); })) {
      f = v.op() == Op::Add ? sum(parts) : product(parts);
      if (count_arguments(postorder(f.numerator)) > most) return std::nullopt;
    } else if (v.op() == Op::Pow && v.arg(1).op() == Op::Number && v.arg(1).number().get_den() == 1) {
      const Fraction& base = done.at(v.arg(0).key());
      const bool divides = sgn(v.arg(1).number()) < 0;
      const Expr n = number(abs(v.arg(1).number()));
      if (divides && varies.at(v.arg(0).key()) && signs.at(v.arg(0).key()) <= 0) {
        f = {pow(base.denominator, n), pow(base.numerator, n)};
      } else if (!divides && !is_one(base.denominator)) {
        f = {pow(base.numerator, n), pow(base.denominator, n)};
      }
    } else if (v.op() == Op::Tan && varies.at(v.arg(0).key())) {
      f = {call(Op::Sin, v.args()), call(Op::Cos, v.args())};
    }
    done.emplace(v.key(), f);
  }
  const Fraction& whole = done.at(e.key());
  if (is_one(whole.denominator)) return std::nullopt;
  return whole;
}

}  // namespace irt
