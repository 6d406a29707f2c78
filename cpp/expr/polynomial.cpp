// Recognition of polynomials: nested sums of monomials, and degrees.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/node.h"

namespace irt {
namespace {

int axis_of(const Expr& e) {
  if (e.op() != Op::Symbol || e.name().size() != 1) return -1;
  return e.name() == "x" ? 0 : e.name() == "y" ? 1 : e.name() == "z" ? 2 : -1;
}

// The parts of an expression in postorder, where each is among them, and which are free of x, y, z.
class Parts {
 public:
  explicit Parts(const Expr& e) : all_(postorder(e)) {
    places_.reserve(all_.size());
    for (const Expr& p : all_) {
      const bool free = axis_of(p) < 0 && std::all_of(p.args().begin(), p.args().end(), [&](const Expr& a) { return is_free(a); });
      places_.emplace(p.key(), free_.size());
      free_.push_back(free);
    }
  }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }
  std::size_t place(const Expr& p) const { return places_.at(p.key()); }
  bool is_free(const Expr& p) const { return free_[place(p)]; }

 private:
  std::vector<Expr> all_;
  std::unordered_map<const Node*, std::size_t> places_;
  std::vector<bool> free_;
};

// Exponents of x, y, z in a product that has nothing else but factors free of them, and those factors.
std::optional<std::pair<std::array<int, 3>, Expr>> monomial(const Expr& e, const Parts& parts) {
  std::array<int, 3> exponents{};
  std::vector<Expr> rest;
  for (const Expr& f : e.op() == Op::Mul ? e.args() : std::span(&e, 1)) {
    const Expr& base = f.op() == Op::Pow ? f.arg(0) : f;
    const auto n = f.op() == Op::Pow ? natural(f.arg(1)) : std::optional<long>(1);
    if (parts.is_free(f)) {
      rest.push_back(f);
    } else if (const int axis = axis_of(base); axis >= 0 && n && *n <= limits::kDegree) {
      exponents[axis] += static_cast<int>(*n);
    } else {
      return std::nullopt;
    }
  }
  // Factors of a product that is canonical are one in the same order.
  const Expr factor = rest.empty() ? Expr(1L) : rest.size() == 1 ? rest[0] : Store::make(Op::Mul, std::move(rest));
  return std::pair(exponents, factor);
}

using Monomials = std::vector<std::pair<std::array<int, 3>, Expr>>;

// Their sum, nested by powers of the axis and of those after it.
Expr nest(const Monomials& terms, int axis) {
  static const char* const kNames[] = {"x", "y", "z"};
  if (axis == 3) {
    if (terms.size() == 1) return terms[0].second;
    std::vector<Expr> all;
    for (const auto& t : terms) all.push_back(t.second);
    return add(all);
  }
  std::map<int, Monomials> by_power;
  for (const auto& t : terms) by_power[t.first[axis]].push_back(t);
  const Expr at = symbol(kNames[axis]);
  const auto times = [&](int exponent, const Expr& e) { return exponent == 0 ? e : mul(exponent == 1 ? at : pow(at, Expr(static_cast<long>(exponent))), e); };
  std::optional<Expr> sum;
  int power = 0;
  for (auto it = by_power.rbegin(); it != by_power.rend(); ++it) {
    const Expr inner = nest(it->second, axis + 1);
    sum = sum ? add(times(power - it->first, *sum), inner) : inner;
    power = it->first;
  }
  return times(power, *sum);
}

}  // namespace

Expr nested(const Expr& e) {
  const Parts parts(e);
  std::vector<Expr> results;
  for (const Expr& p : parts) {
    std::vector<Expr> args;
    for (const Expr& a : p.args()) args.push_back(results[parts.place(a)]);
    // Most parts of a large polynomial are monomials, which stay as they are.
    const bool same = std::equal(args.begin(), args.end(), p.args().begin());
    Expr r = p;
    if (p.op() == Op::Add && !parts.is_free(p)) {
      Monomials terms;
      std::vector<Expr> others;
      for (std::size_t i = 0; i < p.arity(); ++i) {
        if (auto m = monomial(p.arg(i), parts)) {
          terms.push_back(std::move(*m));
        } else {
          others.push_back(args[i]);
        }
      }
      if (!terms.empty()) others.push_back(nest(terms, 0));
      if (!terms.empty() || !same) r = add(others);
    } else if (!same) {
      r = call(p.op(), args);
    }
    results.push_back(std::move(r));
  }
  return results.back();
}

std::optional<long> degree(const Expr& e) {
  // An upper bound first, without expanding; it is exact unless leading terms cancel in a sum.
  const Parts parts(e);
  std::vector<std::optional<long>> degrees;
  bool sums_of_equals = false;
  for (const Expr& p : parts) {
    std::optional<long> r;
    const auto of = [&](std::size_t i) { return degrees[parts.place(p.arg(i))]; };
    if (p.is_condition()) {
    } else if (axis_of(p) >= 0) {
      r = 1;
    } else if (p.op() == Op::Add) {
      r = of(0);
      long ties = 0;
      for (std::size_t i = 1; i < p.arity(); ++i) {
        if (!r || !of(i)) {
          r.reset();
          break;
        }
        ties = *of(i) == *r ? ties + 1 : *of(i) > *r ? 0 : ties;
        r = std::max(*r, *of(i));
      }
      // Distinct monomials cannot cancel; anything that needs expanding could.
      for (const Expr& a : p.args())
        if (ties > 0 && a.key()->weight > 0)
          for (const Expr& f : a.op() == Op::Mul ? a.args() : std::span(&a, 1))
            sums_of_equals = sums_of_equals || f.op() == Op::Add || (f.op() == Op::Pow && f.arg(0).op() == Op::Add);
    } else if (p.op() == Op::Mul) {
      r = 0;
      for (std::size_t i = 0; r && i < p.arity(); ++i) r = of(i) ? std::optional(*r + *of(i)) : std::nullopt;
    } else if (const auto n = p.op() == Op::Pow ? natural(p.arg(1)) : std::nullopt; n && of(0) && *n <= limits::kExponent) {
      r = *of(0) * *n;
    }
    if (parts.is_free(p) && !p.is_condition()) r = 0;
    if (r && *r > limits::kDegree) throw LimitError(fmt::format("the polynomial's degree is {} or more; the limit is {}", *r, limits::kDegree));
    degrees.push_back(r);
  }
  const auto bound = degrees.back();
  if (!bound || !sums_of_equals || *bound > 60) return bound;
  try {
    // Of monomials, a node's weight is its degree.
    const Expr sum = expand(e);
    std::int64_t most = 0;
    for (const Expr& t : sum.op() == Op::Add ? sum.args() : std::span(&sum, 1)) most = std::max(most, t.key()->weight);
    return most;
  } catch (const LimitError&) {
    return bound;
  }
}

}  // namespace irt
