// Canonical forms of sums, products and powers.
#include "expr/build.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "caps.h"
#include "error.h"
#include "expr/node.h"

namespace irt {
namespace {

bool is_number(const Expr& e) { return e.op() == Op::Number; }
bool is_integer(const Expr& e) { return is_number(e) && e.number().get_den() == 1; }

void check_value(const Expr& e) {
  if (e.is_condition()) throw ExpressionError("a condition cannot be used as a number; use Piecewise to give it values");
}

std::size_t bits(const mpq_class& q) {
  return std::max(mpz_sizeinbase(q.get_num_mpz_t(), 2), mpz_sizeinbase(q.get_den_mpz_t(), 2));
}

void check_bits(const mpq_class& q) {
  if (bits(q) > limits::kNumberBits) throw LimitError(fmt::format("a number in the formula has {} bits; the limit is {}", bits(q), limits::kNumberBits));
}

// q ** n, or nothing where it would be too large to keep.
std::optional<mpq_class> integer_power(const mpq_class& q, const mpz_class& n) {
  if (sgn(q) == 0 && sgn(n) < 0) throw ExpressionError("division by zero");
  if (q == 0 || q == 1) return sgn(n) == 0 ? mpq_class(1) : q;
  if (q == -1) return mpz_even_p(n.get_mpz_t()) ? mpq_class(1) : mpq_class(-1);
  if (!n.fits_slong_p() || std::abs(static_cast<double>(n.get_si())) * static_cast<double>(bits(q)) > limits::kNumberBits)
    return std::nullopt;
  const unsigned long m = std::labs(n.get_si());
  mpz_class num, den;
  mpz_pow_ui(num.get_mpz_t(), q.get_num_mpz_t(), m);
  mpz_pow_ui(den.get_mpz_t(), q.get_den_mpz_t(), m);
  mpq_class r = sgn(n) < 0 ? mpq_class(den, num) : mpq_class(num, den);
  r.canonicalize();
  return r;
}

// The exact n-th root of q >= 0, or nothing.
std::optional<mpq_class> exact_root(const mpq_class& q, unsigned long n) {
  mpz_class num, den;
  if (!mpz_root(num.get_mpz_t(), q.get_num_mpz_t(), n) || !mpz_root(den.get_mpz_t(), q.get_den_mpz_t(), n)) return std::nullopt;
  return mpq_class(num, den);
}

int rank(const Expr& e) {
  switch (e.op()) {
    case Op::Number: return 0;
    case Op::Pi:
    case Op::E: return 1;
    case Op::Symbol: return 2;
    case Op::Pow: return 3;
    case Op::Mul: return 4;
    case Op::Add: return 5;
    default: return 10 + static_cast<int>(e.op());
  }
}

int compare_deep(const Expr& a, const Expr& b, int depth) {
  if (a == b) return 0;
  // x and x**2 are neighbours.
  const Expr& base_a = a.op() == Op::Pow && depth < 40 ? a.arg(0) : a;
  const Expr& base_b = b.op() == Op::Pow && depth < 40 ? b.arg(0) : b;
  if (&base_a != &a || &base_b != &b) {
    if (const int c = compare_deep(base_a, base_b, depth + 1)) return c;
    if (a.op() != Op::Pow) return -1;
    if (b.op() != Op::Pow) return 1;
    return compare_deep(a.arg(1), b.arg(1), depth + 1);
  }
  if (rank(a) != rank(b)) return rank(a) < rank(b) ? -1 : 1;
  if (a.op() == Op::Number) return cmp(a.number(), b.number()) < 0 ? -1 : 1;
  if (a.op() == Op::Symbol) return a.name() < b.name() ? -1 : 1;
  if (depth < 40) {
    for (std::size_t i = 0; i < std::min(a.arity(), b.arity()); ++i)
      if (const int c = compare_deep(a.arg(i), b.arg(i), depth + 1)) return c;
    if (a.arity() != b.arity()) return a.arity() < b.arity() ? -1 : 1;
    if (a.op() != b.op()) return a.op() < b.op() ? -1 : 1;
  }
  return a.hash() < b.hash() ? -1 : 1;
}

bool less(const Expr& a, const Expr& b) { return compare(a, b) < 0; }

// A term of a sum, and what is left of it without its coefficient.
struct Term {
  explicit Term(const Expr& e) : whole(e), rest(split_coefficient(e).second) {}
  Expr whole, rest;
};

// High powers first, numbers last.
bool term_less(const Term& a, const Term& b) {
  const auto wa = a.whole.key()->weight, wb = b.whole.key()->weight;
  if (wa != wb) return wa > wb;
  if (const int c = compare(a.rest, b.rest)) return c < 0;
  return compare(a.whole, b.whole) < 0;
}

// c * rest, for a rest that is already canonical.
Expr with_coefficient(const mpq_class& c, const Expr& rest) {
  if (c == 1) return rest;
  if (is_number(rest)) return number(c * rest.number());
  if (sgn(c) == 0) return mul(Expr(0L), rest);
  std::vector<Expr> args{number(c)};
  if (rest.op() == Op::Mul) {
    args.insert(args.end(), rest.args().begin(), rest.args().end());
  } else {
    args.push_back(rest);
  }
  return Store::make(Op::Mul, std::move(args));
}

struct ExprHash {
  std::size_t operator()(const Expr& e) const { return e.hash(); }
};

}  // namespace

bool is_identifier(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !name.empty() && name.size() <= limits::kIdentifierLength && letter(name[0]) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

Expr number(const mpq_class& value) {
  const Expr e = Store::number(value);
  check_bits(e.number());
  return e;
}

Expr from_double(double value) {
  if (!std::isfinite(value))
    throw ExpressionError(fmt::format("{} is not a number that a formula can hold; only finite numbers are", value));
  return Store::number(mpq_class(value));
}

Expr symbol(const std::string& name) {
  if (!is_identifier(name))
    throw ExpressionError(fmt::format("'{}' is not a symbol: a letter or _, then letters, digits and _, at most {} in all, in ASCII",
                                      name.substr(0, 80), limits::kIdentifierLength));
  if (name == "E") return Store::make(Op::E, {});
  if (name == "pi") return Store::make(Op::Pi, {});
  return Store::symbol(name);
}

int compare(const Expr& a, const Expr& b) { return compare_deep(a, b, 0); }

std::pair<mpq_class, Expr> split_coefficient(const Expr& e) {
  if (is_number(e)) return {e.number(), Expr(1L)};
  if (e.op() != Op::Mul || !is_number(e.arg(0))) return {1, e};
  if (e.arity() == 2) return {e.arg(0).number(), e.arg(1)};
  return {e.arg(0).number(), Store::make(Op::Mul, {e.args().begin() + 1, e.args().end()})};
}

// The terms with like ones collected, in order; a sum whose coefficient has become 1 is among them as it is.
static std::vector<Expr> collected(std::span<const Expr> terms) {
  mpq_class constant = 0;
  std::vector<Expr> order;
  std::unordered_map<Expr, mpq_class, ExprHash> coefficient;
  const auto take = [&](const Expr& t) {
    check_value(t);
    if (is_number(t)) {
      constant += t.number();
      return;
    }
    auto [c, rest] = split_coefficient(t);
    const auto [it, fresh] = coefficient.try_emplace(rest, 0);
    if (fresh) order.push_back(rest);
    it->second += c;
  };
  for (const Expr& t : terms) {
    if (t.op() == Op::Add) {
      for (const Expr& a : t.args()) take(a);
    } else {
      take(t);
    }
  }
  std::vector<Term> terms_kept;
  std::unordered_set<Expr, ExprHash> zeros;
  for (const Expr& rest : order) {
    Expr term = with_coefficient(coefficient.at(rest), rest);
    if (is_number(term)) {
      constant += term.number();
      continue;
    }
    // What is left of zero times a product may be there already.
    if (sgn(coefficient.at(rest)) == 0)
      if (const Expr left = split_coefficient(term).second; !(left == rest) && (coefficient.contains(left) || !zeros.insert(left).second)) continue;
    terms_kept.emplace_back(term);
  }
  std::sort(terms_kept.begin(), terms_kept.end(), term_less);
  std::vector<Expr> kept;
  for (Term& t : terms_kept) kept.push_back(std::move(t.whole));
  check_bits(constant);
  if (sgn(constant) != 0) kept.push_back(number(constant));
  return kept;
}

Expr add(std::span<const Expr> terms) {
  std::vector<Expr> kept = collected(terms);
  // 2 (x + y) - (x + y) + z is x + y + z.
  while (std::ranges::any_of(kept, [](const Expr& e) { return e.op() == Op::Add; })) kept = collected(kept);
  if (kept.empty()) return Expr(0L);
  if (kept.size() == 1) return kept[0];
  return Store::make(Op::Add, std::move(kept));
}

// The factors with powers of one base collected; numbers go into the constant. Where `again`, there may be equal factors among the results.
static std::vector<Expr> collected(std::span<const Expr> factors, mpq_class& constant, bool& again) {
  // Integer powers of one base multiply where both stand above the line, or both below it. Roots and powers by what is no number are
  // bases of their own: sqrt(x) sqrt(x) is sqrt(x)**2, which is defined where they are.
  struct Exponents {
    mpz_class above = 0, below = 0;
  };
  std::vector<Expr> order;
  std::unordered_map<Expr, Exponents, ExprHash> powers;
  for (const Expr& f : factors) {
    if (is_number(f)) {
      constant *= f.number();
      continue;
    }
    Expr base = f;
    mpz_class n = 1;
    if (f.op() == Op::Pow && is_integer(f.arg(1))) {
      base = f.arg(0);
      n = f.arg(1).number().get_num();
    } else if (f.op() == Op::Pow && is_number(f.arg(1)) && sgn(f.arg(1).number()) < 0) {
      base = pow(f.arg(0), number(-f.arg(1).number()));
      n = -1;
    }
    const auto [it, fresh] = powers.try_emplace(base);
    if (fresh) order.push_back(base);
    (sgn(n) > 0 ? it->second.above : it->second.below) += n;
  }
  std::vector<Expr> kept;
  for (const Expr& base : order) {
    const Exponents& e = powers.at(base);
    for (const mpz_class& n : {e.above, e.below}) {
      if (sgn(n) == 0) continue;
      const Expr p = pow(base, number(mpq_class(n)));
      if (is_number(p)) {
        constant *= p.number();
        continue;
      }
      // sqrt(x)**3 is x**(3/2), another base, and E**2 is exp(2).
      again = again || (abs(n) != 1 && (p.op() != Op::Pow || p.arg(0) != base));
      kept.push_back(p);
    }
  }
  return kept;
}

Expr mul(std::span<const Expr> factors) {
  mpq_class constant = 1;
  std::vector<Expr> kept;
  for (const Expr& f : factors) {
    check_value(f);
    if (f.op() == Op::Mul) {
      kept.insert(kept.end(), f.args().begin(), f.args().end());
    } else {
      kept.push_back(f);
    }
  }
  for (bool again = true; again;) {
    again = false;
    kept = collected(kept, constant, again);
  }
  check_bits(constant);
  if (kept.empty()) return number(constant);
  // Zero times what is defined everywhere is zero, whatever else stands there.
  if (sgn(constant) == 0) std::erase_if(kept, [](const Expr& e) { return e.key()->total; });
  if (kept.empty()) return Expr(0L);
  std::sort(kept.begin(), kept.end(), less);
  if (constant != 1) kept.insert(kept.begin(), number(constant));
  if (kept.size() == 1) return kept[0];
  return Store::make(Op::Mul, std::move(kept));
}

Expr pow(const Expr& base, const Expr& exponent) {
  check_value(base);
  check_value(exponent);
  if (base.op() == Op::E) return call(Op::Exp, std::span(&exponent, 1));
  if (!is_number(exponent)) return Store::make(Op::Pow, {base, exponent});
  const mpq_class& q = exponent.number();
  if (q == 0) return Expr(1L);
  if (q == 1) return base;
  const bool integer = q.get_den() == 1;
  if (is_number(base)) {
    const mpq_class& b = base.number();
    if (integer) {
      if (const auto v = integer_power(b, q.get_num())) return number(*v);
      throw LimitError(fmt::format("a number of {} bits to the power {:.40} may have {:.40} bits; the limit is {}", bits(b), q.get_str(),
                                   mpz_class(abs(q.get_num()) * bits(b)).get_str(), limits::kNumberBits));
    }
    if (sgn(b) < 0)
      throw ExpressionError(fmt::format("({})**({}) is not real; for odd roots of negative numbers use cbrt", b.get_str(), q.get_str()));
    if (sgn(b) == 0) return sgn(q) > 0 ? Expr(0L) : throw ExpressionError("division by zero");
    if (q.get_den().fits_ulong_p())
      if (const auto root = exact_root(b, q.get_den().get_ui()))
        if (const auto v = integer_power(*root, q.get_num())) return number(*v);
  }
  if (base.op() == Op::Pow && is_number(base.arg(1))) {
    const mpq_class& inner = base.arg(1).number();
    const mpq_class product = inner * q;
    const bool inner_integer = inner.get_den() == 1;
    // (b^m)^n = b^(mn) for integers unless both are negative; roots only where the product is still no integer.
    const bool same_domain = inner_integer ? integer && (sgn(inner) > 0 || sgn(q) > 0) : integer && product.get_den() != 1;
    if (same_domain) return pow(base.arg(0), number(product));
  }
  if (integer && base.op() == Op::Mul && is_number(base.arg(0)) && sgn(base.arg(0).number()) != 0) {
    auto [c, rest] = split_coefficient(base);
    if (const auto v = integer_power(c, q.get_num())) return mul(number(*v), pow(rest, exponent));
  }
  return Store::make(Op::Pow, {base, exponent});
}

Expr sqrt(const Expr& a) { return pow(a, number(mpq_class(1, 2))); }

std::vector<Expr> postorder(const Expr& root) {
  std::vector<Expr> out;
  std::unordered_set<const Node*> seen;
  std::vector<std::pair<Expr, std::size_t>> stack{{root, 0}};
  seen.insert(root.key());
  while (!stack.empty()) {
    auto& [e, next] = stack.back();
    if (next < e.arity()) {
      const Expr child = e.arg(next++);
      if (seen.insert(child.key()).second) stack.emplace_back(child, 0);
    } else {
      out.push_back(e);
      stack.pop_back();
    }
  }
  return out;
}

std::optional<long> natural(const Expr& e) {
  if (e.op() != Op::Number || e.number().get_den() != 1 || sgn(e.number()) < 0 || !e.number().get_num().fits_slong_p()) return std::nullopt;
  return e.number().get_num().get_si();
}

std::size_t count_nodes(const Expr& root) {
  const std::size_t n = postorder(root).size();
  if (n > limits::kNodes) throw LimitError(fmt::format("the formula has {} distinct parts; the limit is {}", n, limits::kNodes));
  return n;
}

}  // namespace irt
