// Polynomials along a ray: straight-line arithmetic on truncated power series in the ray's parameter (S3, S4 section 3.1.1).
//
// Deviation from both papers: the formula is never expanded. Every value of the program becomes its own few coefficients, so factors
// stay factors, and powers above the fourth, which a polynomial of degree 4 cancels, are never computed. Beside the
// coefficients goes one number, the value of the program with every - turned into + (docs/architecture.md): times the number of
// roundings it bounds the error of the polynomial anywhere on the piece.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "caps.h"
#include "error.h"
#include "program/operators.h"
#include "program/text.h"

namespace irt::program {
namespace {

// Half-ulps: of a coordinate on the ray (origin, direction, their sum), of a parameter, of a function of parameters, of a division.
constexpr int kCoordinate = 4, kParameter = 1, kFunction = 8, kDivision = 5;

// A value along the ray; no coefficients: it is no polynomial.
struct Series {
  std::vector<std::string> c;  // lowest first
  std::string size;            // bounds the magnitude of all that went into it
  int roundings = 0;           // half-ulps of `size` by which the value may err

  bool polynomial() const { return !c.empty(); }
  bool constant() const { return c.size() == 1; }
};

class Coefficients {
 public:
  Coefficients(const Program& program, Precision precision) : program_(program), precision_(precision), series_(program.code.size()) {}

  Emitted run() {
    for (Value v = 0; v < static_cast<Value>(program_.code.size()); ++v) {
      series_[static_cast<std::size_t>(v)] = series(v);
      if (!at(v).polynomial()) choose(v);
    }
    const std::string result = sign_of(program_.result);
    std::string ends, each;
    std::size_t highest = 0;
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      const Series& f = at(leaves_[i]);
      const std::size_t degree = f.c.size() - 1;
      for (std::size_t k = 0; k <= degree; ++k) ends += fmt::format("  c[{}][{}] = {};\n", i, k, f.c[k]);
      ends += fmt::format("  error[{}] = R({:.1f}) * ULP * {};\n", i, 0.5 * static_cast<double>(f.roundings + 2 * static_cast<int>(degree) + 2), f.size);
      highest = std::max(highest, degree);
      each += fmt::format(" DO({}, {})", i, degree);
    }
    Emitted out;
    out.source = fmt::format("#define TERMS {}\n#define LEAVES {}\n#define IRT_DEGREE {}\n#define EACH_LEAF(DO){}\n", limits::kClosedDegree + 1, leaves_.size(), highest, each) +
                 "// Coefficients in e of each leaf at o + e d, |e| <= 1, lowest first, and what rounding may have made of its values.\n"
                 "static inline void irt_coefficients(F ox, F oy, F oz, F dx, F dy, F dz PARAMETERS, F c[][TERMS], F* error) {\n" +
                 text_ + ends + "}\n// The sign of f from those of the leaves.\nstatic inline F irt_tree(const F* s) {\n" + choices_ +
                 fmt::format("  return {};\n}}\n", result);
    return out;
  }

 private:
  const Program& program_;
  Precision precision_;
  std::vector<Series> series_;
  std::string text_, choices_;
  std::vector<Value> leaves_;
  std::map<Value, std::size_t> leaf_index_;

  const Series& at(Value v) const { return series_[static_cast<std::size_t>(v)]; }

  std::string let(const std::string& name, const std::string& value) {
    text_ += fmt::format("  const F {} = {};\n", name, value);
    return name;
  }

  // Sums, differences: term by term.
  Series sum(const std::string& name, const Series& a, const Series& b, char sign) {
    Series r;
    for (std::size_t k = 0; k < std::max(a.c.size(), b.c.size()); ++k) {
      const std::string value = k >= b.c.size()   ? a.c[k]
                                : k < a.c.size()  ? fmt::format("{} {} {}", a.c[k], sign, b.c[k])
                                : sign == '-'     ? "-" + b.c[k]
                                                  : b.c[k];
      r.c.push_back(let(fmt::format("{}_{}", name, k), value));
    }
    r.size = let(name + "_m", fmt::format("{} + {}", a.size, b.size));
    r.roundings = std::max(a.roundings, b.roundings) + 1;
    return r;
  }

  // Products: convolution, cut off behind the highest power that counts.
  Series product(const std::string& name, const Series& a, const Series& b) {
    Series r;
    const std::size_t terms = std::min<std::size_t>(a.c.size() + b.c.size() - 1, limits::kClosedDegree + 1);
    for (std::size_t k = 0; k < terms; ++k) {
      std::string value;
      for (std::size_t i = 0; i < a.c.size(); ++i)
        if (k >= i && k - i < b.c.size())
          value = value.empty() ? fmt::format("{} * {}", a.c[i], b.c[k - i]) : fmt::format("fma({}, {}, {})", a.c[i], b.c[k - i], value);
      r.c.push_back(let(fmt::format("{}_{}", name, k), value));
    }
    r.size = let(name + "_m", fmt::format("{} * {}", a.size, b.size));
    r.roundings = a.roundings + b.roundings + static_cast<int>(std::min(a.c.size(), b.c.size()));
    return r;
  }

  Series power(const std::string& name, Series base, std::int64_t n) {
    std::optional<Series> result;
    for (int count = 0;; ++count) {
      if (n & 1) result = result ? product(fmt::format("{}_p{}", name, count), *result, base) : base;
      if ((n >>= 1) == 0) return *result;
      base = product(fmt::format("{}_s{}", name, count), base, base);
    }
  }

  Series number(const numerics::Bounds& value) const {
    const double c = nearest(value, precision_);
    return {{"(F)" + literal(c)}, "(F)" + literal(std::fabs(c)), value.lo == c && value.hi == c ? 0 : 1};
  }

  // Horner's rule.
  Series polynomial(const std::string& name, const Series& base, const std::vector<numerics::Bounds>& coefficients) {
    Series r = number(coefficients.back());
    for (std::size_t k = coefficients.size() - 1; k-- > 0;)
      r = sum(fmt::format("{}_h{}", name, k), product(fmt::format("{}_g{}", name, k), r, base), number(coefficients[k]), '+');
    return r;
  }

  Series series(Value v) {
    const Instruction& in = program_[v];
    const std::string r = name(v);
    const auto known = [&](Value w) { return w < 0 || at(w).polynomial(); };
    const auto constant = [&](Value w) { return w < 0 || at(w).constant(); };
    if (!known(in.a) || !known(in.b) || !known(in.c)) return {};
    switch (in.code) {
      case Code::Constant: return number(in.value);
      case Code::Coordinate: {
        const char axis = "xyz"[in.index];
        return {{fmt::format("o{}", axis), fmt::format("d{}", axis)}, let(r + "_m", fmt::format("fabs(o{0}) + fabs(d{0})", axis)), kCoordinate};
      }
      case Code::Parameter: {
        const std::string p = let(r, fmt::format("(F)p[{}]", 2 * in.index));
        return {{p}, fmt::format("fabs({})", p), kParameter};
      }
      case Code::Neg: {
        Series s = at(in.a);
        for (std::size_t k = 0; k < s.c.size(); ++k) s.c[k] = let(fmt::format("{}_{}", r, k), "-" + s.c[k]);
        return s;
      }
      case Code::Add: return sum(r, at(in.a), at(in.b), '+');
      case Code::Sub: return sum(r, at(in.a), at(in.b), '-');
      case Code::Mul: return product(r, at(in.a), at(in.b));
      case Code::Sqr: return product(r, at(in.a), at(in.a));
      case Code::Power: return power(r, at(in.a), in.index);
      case Code::Polynomial: return polynomial(r, at(in.a), program_.polynomials[static_cast<std::size_t>(in.index)]);
      case Code::Div:
        if (constant(in.b)) {
          Series s = at(in.a);
          for (std::size_t k = 0; k < s.c.size(); ++k) s.c[k] = let(fmt::format("{}_{}", r, k), fmt::format("{} / {}", s.c[k], at(in.b).c[0]));
          s.size = let(r + "_m", fmt::format("fabs({} / {})", s.size, at(in.b).c[0]));
          s.roundings += at(in.b).roundings + kDivision;
          return s;
        }
        return {};
      default:
        // What has only parameters in it is a number, whatever the operator; one without operands has a rule above.
        if (in.a < 0 || !constant(in.a) || !constant(in.b) || !constant(in.c) || in.code >= Code::Less) return {};
        const auto text = [&](Value w) { return w < 0 ? std::string() : at(w).c[0]; };
        const std::string value = let(r, fill(describe(in.code).point, text(in.a), text(in.b), text(in.c), r, literal(nearest(in.value, precision_))));
        return {{value}, fmt::format("fabs({})", value), kFunction};
    }
  }

  // The sign of v: of a leaf, or of what min, max and - make of leaves.
  std::string sign_of(Value v) {
    if (!at(v).polynomial()) return fmt::format("t{}", v);
    const auto [it, fresh] = leaf_index_.emplace(v, leaves_.size());
    if (fresh) {
      if (leaves_.size() == limits::kLeaves)
        throw LimitError(fmt::format("the formula has {} polynomials or more under its set operations; the limit of closed forms is {}; use \"contract\"", leaves_.size() + 1, limits::kLeaves));
      leaves_.push_back(v);
    }
    return fmt::format("s[{}]", it->second);
  }

  void choose(Value v) {
    const Instruction& in = program_[v];
    const bool scales = in.code == Code::Mul && program_.is_constant(in.a);
    if (in.code != Code::Min && in.code != Code::Max && in.code != Code::Neg && !scales)
      throw MethodError(fmt::format("closed forms know polynomials of degree {} at most, and Min, Max and R-functions of them, not {}; "
                                    "\"contract\", \"raa\" and \"ia\" do", limits::kClosedDegree, describe(in.code).name));
    const std::string value = scales ? (program_[in.a].value.lo < 0 ? "-" : "") + sign_of(in.b)
                              : in.code == Code::Neg ? "-" + sign_of(in.a)
                                                     : fmt::format("{}({}, {})", describe(in.code).name, sign_of(in.a), sign_of(in.b));
    choices_ += fmt::format("  const F t{} = {};\n", v, value);
  }
};

}  // namespace

Emitted emit_coefficients(const Program& program, Precision precision) { return Coefficients(program, precision).run(); }

}  // namespace irt::program
