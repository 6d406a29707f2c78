// Expansion: products and whole powers of sums multiplied out.
//
// What is a sum of products of powers is held as such on the way: a number for each monomial, which is a list of atoms (whatever is
// neither sum nor product nor whole power) with their exponents. Trees are made of what is left in the end, and of arguments of functions.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/node.h"

namespace irt {
namespace {

using Monomial = std::vector<std::pair<std::uint32_t, std::int64_t>>;  // atom and exponent, by atom

struct MonomialHash {
  std::size_t operator()(const Monomial& m) const {
    std::size_t h = m.size();
    for (const auto& [atom, n] : m) h = (h ^ (static_cast<std::size_t>(n) << 32 ^ atom)) * 0x9e3779b97f4a7c15ull, h ^= h >> 29;
    return h;
  }
};

using Sum = std::unordered_map<Monomial, mpq_class, MonomialHash>;  // never empty

class Expansion {
 public:
  // Each part once, arguments first; `uses`: how often it is an argument of those that follow.
  void visit(const Expr& p, std::size_t uses) {
    if (p.is_condition()) {
      conditions_.emplace(p.key(), call(p.op(), arguments(p)));
    } else {
      sums_.emplace(p.key(), Held{defined_sum_of(p), std::nullopt, uses});
    }
    for (const Expr& a : p.args())
      if (const auto it = sums_.find(a.key()); it != sums_.end() && --it->second.uses == 0) sums_.erase(it);
  }

  Expr expanded(const Expr& e) {
    if (e.is_condition()) return conditions_.at(e.key());
    Held& held = sums_.at(e.key());
    if (!held.tree) held.tree = tree(held.sum);
    return *held.tree;
  }

 private:
  struct Held {
    Sum sum;
    std::optional<Expr> tree;
    std::size_t uses;
  };
  std::vector<Expr> atoms_;
  std::unordered_map<const Node*, std::uint32_t> indices_;
  std::unordered_map<const Node*, Expr> conditions_;
  std::unordered_map<const Node*, Held> sums_;
  std::size_t made_ = 0;  // products of terms

  std::vector<Expr> arguments(const Expr& p) {
    std::vector<Expr> args;
    for (const Expr& a : p.args()) args.push_back(expanded(a));
    return args;
  }

  // Of what expands into an undefined constant (log(x - (x + 1))), which only the formula as it is can say: itself, an atom.
  Sum defined_sum_of(const Expr& p) {
    try {
      return sum_of(p);
    } catch (const ExpressionError&) {
      return terms_of(p);
    }
  }

  Sum sum_of(const Expr& p) {
    const auto sum = [&](std::size_t i) -> const Sum& { return sums_.at(p.arg(i).key()).sum; };
    if (p.op() == Op::Add) {
      Sum r;
      for (std::size_t i = 0; i < p.arity(); ++i)
        for (const auto& [m, c] : sum(i)) r[m] += c;
      return without_zeros(std::move(r));
    }
    if (p.op() == Op::Mul) {
      Sum r{{{}, 1}};
      for (std::size_t i = 0; i < p.arity(); ++i) r = product(r, sum(i));
      return r;
    }
    if (const auto n = p.op() == Op::Pow ? natural(p.arg(1)) : std::nullopt; n && *n > 0 && sum(0).size() > 1) {
      // Repeated squaring would make the intermediate sums no smaller.
      Sum r = sum(0);
      for (long k = 1; k < *n; ++k) r = product(r, sum(0));
      return r;
    }
    if (p.arity() == 0) return terms_of(p);
    const std::vector<Expr> args = arguments(p);
    if (const auto n = p.op() == Op::Pow ? natural(args[1]) : std::nullopt; n && args[0].op() == Op::Mul) {
      std::vector<Expr> factors;
      for (const Expr& f : args[0].args()) factors.push_back(pow(f, args[1]));
      return terms_of(mul(factors));
    }
    return terms_of(call(p.op(), args));
  }

  std::uint32_t index(const Expr& atom) {
    const auto [it, fresh] = indices_.try_emplace(atom.key(), static_cast<std::uint32_t>(atoms_.size()));
    if (fresh) atoms_.push_back(atom);
    return it->second;
  }

  Expr tree(const Sum& s) const {
    std::vector<Expr> terms;
    terms.reserve(s.size());
    for (const auto& [m, c] : s) {
      std::vector<Expr> factors{number(c)};
      for (const auto& [atom, n] : m) factors.push_back(pow(atoms_[atom], Expr(static_cast<long>(n))));
      terms.push_back(mul(factors));
    }
    return add(terms);
  }

  // Of a tree whose sums and products are multiplied out as far as they will be.
  Sum terms_of(const Expr& e) {
    Sum r;
    for (const Expr& t : e.op() == Op::Add ? e.args() : std::span(&e, 1)) {
      mpq_class c = 1;
      Monomial m;
      for (const Expr& f : t.op() == Op::Mul ? t.args() : std::span(&t, 1)) {
        if (f.op() == Op::Number) {
          c *= f.number();
          continue;
        }
        const auto n = f.op() == Op::Pow ? natural(f.arg(1)) : std::nullopt;
        const bool power = n && *n <= limits::kDegree;
        m.emplace_back(index(power ? f.arg(0) : f), power ? *n : 1);
      }
      std::sort(m.begin(), m.end());
      for (std::size_t i = m.size(); i-- > 1;)
        if (m[i].first == m[i - 1].first) {
          m[i - 1].second += m[i].second;
          m.erase(m.begin() + static_cast<std::ptrdiff_t>(i));
        }
      r[m] += c;
    }
    return without_zeros(std::move(r));
  }

  // Nothing times what is defined everywhere is nothing; 0 log(x) stays. The sum of no terms is the term 0.
  Sum without_zeros(Sum s) const {
    std::erase_if(s, [&](const auto& term) {
      return sgn(term.second) == 0 &&
             std::all_of(term.first.begin(), term.first.end(), [&](const auto& factor) { return atoms_[factor.first].key()->total; });
    });
    if (s.empty()) s.emplace();
    return s;
  }

  Sum product(const Sum& a, const Sum& b) {
    if (a.size() * b.size() > limits::kExpandTerms)
      throw LimitError(fmt::format("expand would make {} terms; the limit is {}", a.size() * b.size(), limits::kExpandTerms));
    if ((made_ += a.size() * b.size()) > limits::kExpandProducts)
      throw LimitError(fmt::format("expand would multiply {} pairs of terms or more; the limit is {}", made_, limits::kExpandProducts));
    Sum r;
    Monomial m;
    mpq_class c;
    for (const auto& [p, x] : a)
      for (const auto& [q, y] : b) {
        m.clear();
        auto i = p.begin(), j = q.begin();
        while (i != p.end() || j != q.end())
          if (j == q.end() || (i != p.end() && i->first < j->first)) {
            m.push_back(*i++);
          } else if (i == p.end() || j->first < i->first) {
            m.push_back(*j++);
          } else {
            std::int64_t n;
            if (__builtin_add_overflow(i->second, j->second, &n)) throw LimitError("expand would make an exponent of 64 bits; the limit is 63");
            m.emplace_back(i->first, n);
            ++i, ++j;
          }
        c = x * y;
        const mpq_class& sum = r[m] += c;
        if (const std::size_t bits = std::max(mpz_sizeinbase(sum.get_num_mpz_t(), 2), mpz_sizeinbase(sum.get_den_mpz_t(), 2)); bits > limits::kNumberBits)
          throw LimitError(fmt::format("expand would make a number of {} bits; the limit is {}", bits, limits::kNumberBits));
      }
    return without_zeros(std::move(r));
  }
};

}  // namespace

Expr expand(const Expr& e) {
  count_nodes(e);
  const std::vector<Expr> parts = postorder(e);
  std::unordered_map<const Node*, std::size_t> uses;
  for (const Expr& p : parts)
    for (const Expr& a : p.args()) ++uses[a.key()];
  Expansion expansion;
  for (const Expr& p : parts) expansion.visit(p, uses[p.key()]);
  return expansion.expanded(e);
}

}  // namespace irt
