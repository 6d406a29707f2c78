// Roots of polynomials along a ray; see ray_polynomial.h.
#include "numerics/ray_polynomial.h"

#include <algorithm>
#include <array>

#include "caps.h"
#include "error.h"
#include "numerics/mpfr_interval.h"

namespace irt::numerics {
namespace {

// The three arithmetics behind one set of names ----------------------------------------------------------------------

int sign_of(const Interval& v) { return v.sign(); }
int sign_of(const Fixed& v) { return v.sign(); }
int sign_of(const mpq_class& v) { return sgn(v); }

// Whether the sign 0 says that the value is zero, rather than that it is not known.
template <class T>
constexpr bool kExact = std::is_same_v<T, mpq_class>;

// Doubles never take long.
template <class T>
void pause(const Stop& stop) {
  if constexpr (!std::is_same_v<T, Interval>) stop();
}

Interval half(const Interval& v) { return {0.5 * v.lo - 0x1p-1074, 0.5 * v.hi + 0x1p-1074}; }
Fixed half(const Fixed& v) { return v.half(); }
mpq_class half(const mpq_class& v) { return v / 2; }

double middle(const Interval& v) { return 0.5 * (v.lo + v.hi); }
double middle(const Fixed& v) { return v.middle(); }
double middle(const mpq_class& v) { return v.get_d(); }

Interval over(const Interval& v, const mpz_class& n) {
  const double d = n.get_d();
  // n may not be a double; two units more do.
  return {down(down(v.lo / d)), up(up(v.hi / d))};
}
Fixed over(const Fixed& v, const mpz_class& n) { return n.fits_ulong_p() ? v.over(n.get_ui()) : v * Fixed(mpq_class(1, n)); }
mpq_class over(const mpq_class& v, const mpz_class& n) { return v / n; }

template <class T>
T whole(const mpz_class& n) {
  return T(mpq_class(n));
}
template <>
Interval whole<Interval>(const mpz_class& n) {
  const double d = n.get_d();
  return n == d ? Interval(d) : Interval(down(d), up(up(d)));  // get_d truncates
}

template <class T>
using Coefficients = std::vector<T>;

template <class T>
Coefficients<T> product(const Coefficients<T>& a, const Coefficients<T>& b, const Stop& stop) {
  Coefficients<T> r(a.size() + b.size() - 1, T(0.0));
  for (std::size_t i = 0; i < a.size(); ++i, pause<T>(stop))
    for (std::size_t j = 0; j < b.size(); ++j) r[i + j] = r[i + j] + a[i] * b[j];
  return r;
}

template <class T>
void raise(Coefficients<T>& a, std::size_t size) {
  while (a.size() < size) {
    a.push_back(a.back());
    for (std::size_t i = a.size() - 2; i > 0; --i) a[i] = a[i] + a[i - 1];
  }
}

template <class T>
Coefficients<T> power(Coefficients<T> base, long n, const Stop& stop) {
  Coefficients<T> r{T(1.0)};
  for (; n; n >>= 1) {
    if (n & 1) r = product(r, base, stop);
    if (n > 1) base = product(base, base, stop);
  }
  return r;
}

// s_i to Bernstein coefficients.
template <class T>
void to_bernstein(Coefficients<T>& s) {
  const std::size_t d = s.size() - 1;
  mpz_class binomial = 1;
  for (std::size_t i = 1; i < d; ++i) {
    binomial = binomial * static_cast<unsigned long>(d - i + 1) / static_cast<unsigned long>(i);
    s[i] = over(s[i], binomial);
  }
}

// b becomes the right half, the result is the left one.
template <class T>
Coefficients<T> split(Coefficients<T>& b, const Stop& stop) {
  Coefficients<T> left;
  left.reserve(b.size());
  for (std::size_t n = b.size(); n > 0; --n, pause<T>(stop)) {
    left.push_back(b[0]);
    for (std::size_t i = 0; i + 1 < n; ++i) b[i] = half(b[i] + b[i + 1]);
  }
  return left;
}

// The polynomial's range at u in [0, 1], from Bernstein coefficients, by Horner's rule with binomials.
template <class T>
T value(const Coefficients<T>& b, double at) {
  const T u(at), v = T(1.0) - u;
  const std::size_t d = b.size() - 1;
  T factor(1.0), sum = b[0];
  mpz_class binomial = 1;
  for (std::size_t i = 1; i <= d; ++i) {
    binomial = binomial * static_cast<unsigned long>(d - i + 1) / static_cast<unsigned long>(i);
    factor = factor * u;
    sum = sum * v + b[i] * factor * whole<T>(binomial);
  }
  return sum;
}

double value(const std::vector<double>& b, double u) {
  const std::size_t d = b.size() - 1;
  const double v = 1 - u;
  double factor = 1, sum = b[0], binomial = 1;
  for (std::size_t i = 1; i <= d; ++i) {
    binomial = binomial * static_cast<double>(d - i + 1) / static_cast<double>(i);
    factor *= u;
    sum = sum * v + b[i] * factor * binomial;
  }
  return sum;
}

// The most sign changes that the coefficients may have, whatever the unknown signs are.
template <class T>
int most_changes(const Coefficients<T>& b) {
  // Most changes so far, ending in plus or in minus; none yet: -1000.
  int plus = -1000, minus = -1000;
  for (const T& c : b) {
    const int s = sign_of(c);
    if (s == 0 && kExact<T>) continue;
    const int p = std::max({0, plus, minus + 1}), m = std::max({0, minus, plus + 1});
    const bool first = plus < 0 && minus < 0;
    if (s > 0) {
      plus = first ? 0 : std::max(plus, minus + 1);
      minus = -1000;
    } else if (s < 0) {
      minus = first ? 0 : std::max(minus, plus + 1);
      plus = -1000;
    } else {
      plus = first ? 0 : p;
      minus = first ? 0 : m;
    }
  }
  return std::max({0, plus, minus});
}

struct Piece {
  double a, b;  // in u; dyadic and exact
};

// The first root of `b` inside (0, 1) that the arithmetic isolates, between ends of opposite signs. `point`: a piece as
// small as they get, or an exact root.
template <class T>
struct Found {
  enum { none, isolated, point, open } what = none;
  Piece piece{0, 1};
  Coefficients<T> local;                       // isolated: of the piece
  std::vector<std::pair<Piece, Coefficients<T>>> rest;  // to the right of it, last first
};

constexpr int kDeepest = 50;  // halvings: to 1e-15 of the range

// Looks only at pieces that meet `window`.
template <class T>
Found<T> next_root(std::vector<std::pair<Piece, Coefficients<T>>> stack, Piece window, const Stop& stop) {
  Found<T> found;
  while (!stack.empty()) {
    auto [piece, b] = std::move(stack.back());
    stack.pop_back();
    if (piece.b < window.a || piece.a > window.b) continue;
    if (kExact<T> && sign_of(b.front()) == 0) {
      found.what = Found<T>::point;
      found.piece = {piece.a, piece.a};
      // What follows starts with the root divided out: u = 0 is a root of b, b / u has coefficients b_i d / i.
      Coefficients<T> rest;
      for (std::size_t i = 1; i < b.size(); ++i) rest.push_back(over(b[i] * T(static_cast<double>(b.size() - 1)), static_cast<unsigned long>(i)));
      if (!rest.empty()) stack.emplace_back(piece, std::move(rest));
      found.rest = std::move(stack);
      return found;
    }
    const int changes = most_changes(b);
    const int left = sign_of(b.front()), right = sign_of(b.back());
    if (changes == 0) {
      // All of one sign (or unknown, single coefficients: a constant).
      if (left != 0 || right != 0 || kExact<T>) continue;
    }
    if (changes == 1 && left * right < 0) {
      found.what = Found<T>::isolated;
      found.piece = piece;
      found.local = std::move(b);
      found.rest = std::move(stack);
      return found;
    }
    if (piece.b - piece.a <= std::ldexp(1.0, -kDeepest)) {
      // Several roots closer together than doubles tell apart; an odd number of them is a change of sign all the same.
      found.what = left * right < 0 ? Found<T>::point : Found<T>::open;
      found.piece = piece;
      found.rest = std::move(stack);
      return found;
    }
    const double m = 0.5 * (piece.a + piece.b);
    Coefficients<T> first = split(b, stop);
    stack.emplace_back(Piece{m, piece.b}, std::move(b));
    stack.emplace_back(Piece{piece.a, m}, std::move(first));
  }
  return found;
}

// [lo, hi], with the sign s at lo and -s at hi, halved to `width` as far as T knows the sign in the middle.
template <class T>
std::pair<double, double> halved(const Coefficients<T>& b, int s, double lo, double hi, double width) {
  while (hi - lo > width) {
    const double m = 0.5 * (lo + hi);
    const int at = m > lo && m < hi ? sign_of(value(b, m)) : 0;
    if (at == 0) break;
    (at == s ? lo : hi) = m;
  }
  return {lo, hi};
}

// A bracket around the one root between 0 and 1, whose ends have opposite signs: its ends there. width_at(u): how wide it is to
// be around a root at u.
template <class T, class Width>
std::pair<double, double> narrow(const Coefficients<T>& b, const Width& width_at) {
  std::vector<double> rough;
  double scale = 0;
  for (const T& c : b) rough.push_back(middle(c)), scale = std::max(scale, std::fabs(rough.back()));
  const int s = sign_of(b.front());
  if (!(scale > 0 && std::isfinite(scale))) return halved(b, s, 0, 1, width_at(0.5));
  double lo = 0, hi = 1;
  for (int k = 0; k < 60 && hi - lo > 1e-17; ++k) {
    const double m = 0.5 * (lo + hi);
    if (m <= lo || m >= hi) break;
    ((value(rough, m) > 0) == (s > 0) ? lo : hi) = m;
  }
  const double root = 0.5 * (lo + hi), width = width_at(root);
  // Tried from narrow to wide; the ends themselves are proven already.
  for (double w = 0.4 * width; w < 1; w *= 4) {
    const double p = std::max(0.0, root - w), q = std::min(1.0, root + w);
    const int sp = p <= 0 ? s : sign_of(value(b, p)), sq = q >= 1 ? -s : sign_of(value(b, q));
    if (sp == s && sq == -s) return halved(b, s, p, q, width);
  }
  return halved(b, s, 0, 1, width);
}

// Exact polynomials: the part without multiple factors ---------------------------------------------------------------

using Exact = std::vector<mpq_class>;

void trim(Exact& p) {
  while (!p.empty() && sgn(p.back()) == 0) p.pop_back();
}

// Power basis in u from Bernstein coefficients: forward differences times binomials.
Exact to_powers(Exact b, const Stop& stop) {
  Exact r;
  mpz_class binomial = 1;
  const std::size_t d = b.size() - 1;
  for (std::size_t k = 0; k <= d; ++k, stop()) {
    if (k) binomial = binomial * static_cast<unsigned long>(d - k + 1) / static_cast<unsigned long>(k);
    r.push_back(b[0] * binomial);
    for (std::size_t i = 0; i + 1 < b.size(); ++i) b[i] = b[i + 1] - b[i];
    b.pop_back();
  }
  trim(r);
  return r;
}

Exact from_powers(const Exact& p, const Stop& stop) {
  // b_i = sum_k C(i, k) / C(d, k) p_k
  const unsigned long d = p.size() - 1;
  Exact b(p.size());
  for (unsigned long i = 0; i <= d; ++i, stop())
    for (unsigned long k = 0; k <= i; ++k) {
      mpz_class over_i, over_d;
      mpz_bin_uiui(over_i.get_mpz_t(), i, k);
      mpz_bin_uiui(over_d.get_mpz_t(), d, k);
      b[i] += p[k] * mpq_class(over_i, over_d);
    }
  return b;
}

// a = q b + r
std::pair<Exact, Exact> divide(Exact a, const Exact& b, const Stop& stop) {
  Exact q(a.size() >= b.size() ? a.size() - b.size() + 1 : 0);
  while (a.size() >= b.size()) {
    const mpq_class f = a.back() / b.back();
    const std::size_t shift = a.size() - b.size();
    q[shift] = f;
    for (std::size_t i = 0; i < b.size(); ++i, stop()) a[shift + i] -= f * b[i];
    a.pop_back();
    trim(a);
  }
  return {q, a};
}

void make_monic(Exact& p) {
  const mpq_class lead = p.back();
  for (mpq_class& c : p) c /= lead;
}

// Whether p has no multiple factors, as far as its image modulo a prime tells: a common factor of p and its derivative is one of their images as well, where the
// prime does not divide the leading coefficient. Euclid's algorithm with rationals takes seconds at degree 200, where there is hardly ever anything to find.
bool surely_simple(const Exact& p) {
  constexpr std::uint64_t prime = (std::uint64_t{1} << 61) - 1;
  const auto times = [](std::uint64_t x, std::uint64_t y) { return static_cast<std::uint64_t>(static_cast<unsigned __int128>(x) * y % prime); };
  const auto inverse = [&](std::uint64_t x) {
    std::uint64_t r = 1;
    for (std::uint64_t n = prime - 2; n; n >>= 1, x = times(x, x))
      if (n & 1) r = times(r, x);
    return r;
  };
  std::vector<std::uint64_t> a, b;
  for (const mpq_class& c : p) {
    const std::uint64_t denominator = mpz_fdiv_ui(c.get_den_mpz_t(), prime);
    if (denominator == 0) return false;
    a.push_back(times(mpz_fdiv_ui(c.get_num_mpz_t(), prime), inverse(denominator)));
  }
  if (a.back() == 0) return false;
  for (std::size_t k = 1; k < a.size(); ++k) b.push_back(times(a[k], k));
  while (!b.empty()) {
    const std::uint64_t lead = inverse(b.back());
    while (a.size() >= b.size()) {
      const std::uint64_t f = prime - times(a.back(), lead);
      const std::size_t shift = a.size() - b.size();
      for (std::size_t i = 0; i < b.size(); ++i) a[shift + i] = (a[shift + i] + times(f, b[i])) % prime;
      while (!a.empty() && a.back() == 0) a.pop_back();
    }
    std::swap(a, b);
  }
  return a.size() == 1;
}

Exact without_multiples(const Exact& p, const Stop& stop) {
  if (surely_simple(p)) return p;
  Exact a = p, b;
  for (std::size_t k = 1; k < p.size(); ++k) b.push_back(p[k] * static_cast<unsigned long>(k));
  while (!b.empty()) {
    make_monic(b);
    Exact r = divide(a, b, stop).second;
    a = std::move(b);
    b = std::move(r);
  }
  return divide(p, a, stop).first;
}

int sign_at(const Exact& powers, const mpq_class& at) {
  mpq_class sum = 0;
  for (std::size_t k = powers.size(); k-- > 0;) sum = sum * at + powers[k];
  return sgn(sum);
}

// Where the ray polynomial is looked at: a little more than the clip, by amounts that keep symmetric scenes' roots off the
// points of subdivision.
struct Range {
  double t0, t1;
  double at(double u, bool upward) const {
    const Interval t = Interval(t0) + Interval(u) * (Interval(t1) - Interval(t0));
    return upward ? t.hi : t.lo;
  }
};

Range around(const Clip& clip) {
  const double span = std::max(clip.leave_hi - clip.enter_lo, 1e-12 * std::max(std::fabs(clip.enter_lo), std::fabs(clip.leave_hi)));
  return {clip.enter_lo - 0.0137 * span, clip.leave_hi + 0.0193 * span};
}

enum class Place { before, inside, after, edge };

Place place(const Clip& clip, double lo, double hi) {
  if (hi < clip.enter_lo) return Place::before;
  if (lo > clip.leave_hi) return Place::after;
  return lo >= clip.enter_hi && hi <= clip.leave_lo ? Place::inside : Place::edge;
}

// The first root in the clip of a polynomial given by s_i; undecided where T does not know enough.
template <class T>
Root search(Coefficients<T> s, const Range& range, const Clip& clip, Arithmetic arithmetic, const Stop& stop) {
  to_bernstein(s);
  const double span = range.t1 - range.t0;
  std::vector<std::pair<Piece, Coefficients<T>>> stack;
  stack.emplace_back(Piece{0, 1}, std::move(s));
  // No wider than rounding makes it: where no sign is known, all of it outside the clip is cut into the smallest pieces.
  const Piece window{down(down(clip.enter_lo - range.t0) / up(span)), up(up(clip.leave_hi - range.t0) / down(span))};
  for (;;) {
    Found<T> found = next_root(std::move(stack), window, stop);
    if (found.what == Found<T>::none) return {Kind::miss, 0, 0, arithmetic};
    Piece p = found.piece;
    Root root{Kind::undecided, range.at(p.a, false), range.at(p.b, true), arithmetic};
    if (found.what == Found<T>::isolated) {
      const double length = p.b - p.a;
      const auto width_at = [&](double u) { return std::min(1.0, wanted_width(range.at(p.a + length * u, false), span) / (span * length)); };
      const auto [a, b] = narrow(found.local, width_at);
      root.lo = range.at(p.a + length * a, false);
      root.hi = range.at(p.a + length * b, true);
      root.kind = root.hi - root.lo <= 1.5 * wanted_width(root.lo, span) ? Kind::hit : Kind::undecided;
    }
    if (found.what == Found<T>::point) root.kind = Kind::hit;
    switch (place(clip, root.lo, root.hi)) {
      case Place::before: stack = std::move(found.rest); continue;
      case Place::after: return {Kind::miss, 0, 0, arithmetic};
      case Place::edge: root.kind = Kind::undecided; [[fallthrough]];
      case Place::inside: return root;
    }
  }
}

Root search_exactly(Exact s, const Range& range, const Clip& clip, const Stop& stop) {
  to_bernstein(s);
  const Exact powers = to_powers(std::move(s), stop);
  if (powers.empty()) return {Kind::touch, clip.enter_lo, clip.enter_lo, Arithmetic::exact};  // the ray lies in the surface
  if (powers.size() == 1) return {Kind::miss, 0, 0, Arithmetic::exact};
  const Exact simple = without_multiples(powers, stop);
  Coefficients<mpq_class> b = from_powers(simple, stop);
  const unsigned long d = b.size() - 1;
  for (unsigned long i = 0; i <= d; ++i) {
    mpz_class binomial;
    mpz_bin_uiui(binomial.get_mpz_t(), d, i);
    b[i] *= binomial;  // search divides by them
  }
  Root root = search<mpq_class>(std::move(b), range, clip, Arithmetic::exact, stop);
  if (root.kind == Kind::undecided && clip.enter_lo == clip.enter_hi && root.lo <= clip.enter_lo && clip.enter_lo <= root.hi) {
    // A root at the start of the ray, which counts, is none that rounding may have moved there.
    const mpq_class start(clip.enter_lo), t0(range.t0), t1(range.t1);
    if (sign_at(powers, mpq_class((start - t0) / (t1 - t0))) == 0) root = {Kind::hit, clip.enter_lo, clip.enter_lo, Arithmetic::exact};
  }
  if (root.kind != Kind::hit) return root;
  // Odd multiplicity changes the sign of the polynomial itself.
  const double span = range.t1 - range.t0, pad = 1e-15 * (std::fabs(root.lo) + span);
  const double before = (root.lo - pad - range.t0) / span, after = (root.hi + pad - range.t0) / span;
  if (sign_at(powers, before) * sign_at(powers, after) > 0) root.kind = Kind::touch;
  return root;
}

// Exact values of rational constants, where all are.
std::optional<mpq_class> exact_value(const Formula& formula, const Formula::Step& step, const std::vector<std::optional<mpq_class>>& values) {
  const auto arg = [&](std::size_t i) -> const std::optional<mpq_class>& { return values[step.args[i]]; };
  for (std::size_t i = 0; i < step.args.size(); ++i)
    if (!arg(i)) return std::nullopt;
  switch (step.e.op()) {
    case Op::Number: return step.e.number();
    case Op::Symbol: return mpq_class(formula.parameter(step.e.name()));
    case Op::Add:
    case Op::Mul: {
      mpq_class r = *arg(0);
      for (std::size_t i = 1; i < step.args.size(); ++i) step.e.op() == Op::Add ? r += *arg(i) : r *= *arg(i);
      return r;
    }
    case Op::Pow: {
      if (!step.exponent || std::labs(step.exponent) > 1000 || (step.exponent < 0 && sgn(*arg(0)) == 0)) return std::nullopt;
      mpz_class num, den;
      mpz_pow_ui(num.get_mpz_t(), arg(0)->get_num_mpz_t(), static_cast<unsigned long>(std::labs(step.exponent)));
      mpz_pow_ui(den.get_mpz_t(), arg(0)->get_den_mpz_t(), static_cast<unsigned long>(std::labs(step.exponent)));
      mpq_class r = step.exponent > 0 ? mpq_class(num, den) : mpq_class(den, num);
      r.canonicalize();
      return r;
    }
    default: return std::nullopt;
  }
}

mpq_class exactly(const Real& v) {
  mpq_class q;
  mpfr_get_q(q.get_mpq_t(), v);
  return q;
}

}  // namespace

double wanted_width(double t, double span) { return 1e-12 * std::max(std::fabs(t), 1e-3 * span); }

std::optional<PolynomialPlan> PolynomialPlan::of(const Formula& formula) {
  PolynomialPlan plan;
  plan.formula_ = &formula;
  const std::size_t count = formula.f() + 1;
  std::vector<std::optional<mpq_class>> exact(count);
  std::vector<MpfrInterval> bounds;
  constexpr mpfr_prec_t kBits = Fixed::kBits;
  for (std::size_t i = 0; i < count; ++i) {
    const Formula::Step& step = formula.steps()[i];
    bounds.emplace_back(kBits);
    int degree = -1;
    if (step.constant) {
      if (step.e.is_condition()) return std::nullopt;
      std::vector<const MpfrInterval*> args;
      for (const std::uint32_t k : step.args) args.push_back(&bounds[k]);
      bounds[i] = formula.constant(step, args, kBits);
      if (bounds[i].empty || bounds[i].doubtful || !mpfr_number_p((mpfr_srcptr)bounds[i].lo) || !mpfr_number_p((mpfr_srcptr)bounds[i].hi))
        return std::nullopt;
      exact[i] = exact_value(formula, step, exact);
      degree = 0;
    } else if (step.axis >= 0) {
      degree = 1;
    } else if (step.e.op() == Op::Add) {
      degree = 0;
      for (const std::uint32_t k : step.args) degree = std::max(degree, plan.degree_[k]);
    } else if (step.e.op() == Op::Mul) {
      degree = 0;
      for (const std::uint32_t k : step.args) degree += plan.degree_[k];
    } else if (step.e.op() == Op::Pow && step.exponent > 0 && step.exponent <= limits::kRayDegree) {
      degree = plan.degree_[step.args[0]] * static_cast<int>(step.exponent);
    }
    if (degree < 0 || degree > limits::kRayDegree) return std::nullopt;
    plan.degree_.push_back(degree);
  }
  if (plan.degree_.back() == 0) return std::nullopt;
  for (std::size_t i = 0; i < count; ++i) {
    const bool constant = formula.steps()[i].constant;
    plan.in_double_.push_back(constant ? formula.steps()[i].value : Interval(0));
    plan.in_fixed_.push_back(constant ? Fixed(exactly(bounds[i].lo), exactly(bounds[i].hi)) : Fixed());
    // A constant that stands only as an exponent or inside an irrational one does not count, but none is worth telling apart.
    plan.rational_ = plan.rational_ && (!constant || exact[i]);
    plan.exact_.push_back(constant && exact[i] ? *exact[i] : mpq_class());
  }
  return plan;
}

template <class T>
std::vector<T> PolynomialPlan::along(const Ray& ray, double t0, double t1, const std::vector<T>& constants, const Stop& stop) const {
  std::vector<Coefficients<T>> values(degree_.size());
  for (std::size_t i = 0; i < degree_.size(); ++i) {
    const Formula::Step& step = formula_->steps()[i];
    Coefficients<T>& r = values[i];
    if (step.constant) {
      r = {constants[i]};
    } else if (step.axis >= 0) {
      const T o(ray.origin[step.axis]), d(ray.direction[step.axis]);
      r = {o + d * T(t0), o + d * T(t1)};
    } else if (step.e.op() == Op::Pow) {
      r = power(values[step.args[0]], step.exponent, stop);
    } else if (step.e.op() == Op::Mul) {
      r = values[step.args[0]];
      for (std::size_t k = 1; k < step.args.size(); ++k) r = product(r, values[step.args[k]], stop);
    } else {
      r = values[step.args[0]];
      for (std::size_t k = 1; k < step.args.size(); ++k) {
        Coefficients<T> term = values[step.args[k]];
        raise(r, term.size());
        raise(term, r.size());
        for (std::size_t j = 0; j < r.size(); ++j) r[j] = r[j] + term[j];
      }
    }
  }
  return std::move(values.back());
}

std::vector<Interval> PolynomialPlan::coefficients(const Ray& ray, double t0, double t1) const {
  std::vector<Interval> c = along(ray, t0, t1, in_double_, [] {});
  to_bernstein(c);
  return c;
}

Root PolynomialPlan::first_root(const Ray& ray, const Clip& clip, const Stop& stop) const {
  const Range range = around(clip);
  Root root = search(along(ray, range.t0, range.t1, in_double_, stop), range, clip, Arithmetic::dbl, stop);
  if (root.kind != Kind::undecided) return root;
  root = search(along(ray, range.t0, range.t1, in_fixed_, stop), range, clip, Arithmetic::fixed, stop);
  if (root.kind != Kind::undecided || !rational_) return root;
  return search_exactly(along(ray, range.t0, range.t1, exact_, stop), range, clip, stop);
}

}  // namespace irt::numerics
