// Printing with as few parentheses as the grammar of parse.h allows.
#include "expr/print.h"

#include <cctype>
#include <fmt/format.h>

#include "caps.h"
#include "error.h"
#include "expr/build.h"

namespace irt {
namespace {

// How strongly a text binds.
enum Strength { kSum, kProduct, kMinus, kPower, kAtom };

struct Text {
  std::string text;
  Strength strength;
};

class Printer {
 public:
  explicit Printer(bool latex) : latex_(latex) {}

  Text print(const Expr& e) {
    if (++depth_ > limits::kPrintDepth || size_ > limits::kFormulaLength)
      throw LimitError(fmt::format("the formula has {} levels or more, {} characters so far; the limits of printing are {} and {}", depth_, size_, limits::kPrintDepth,
                                   limits::kFormulaLength));
    Text t = dispatch(e);
    size_ += t.text.size();
    --depth_;
    return t;
  }

 private:
  bool latex_;
  int depth_ = 0;
  std::size_t size_ = 0;

  std::string wrap(const std::string& s) const { return latex_ ? "\\left(" + s + "\\right)" : "(" + s + ")"; }

  std::string at_least(const Expr& e, Strength strength) {
    const Text t = print(e);
    return t.strength < strength ? wrap(t.text) : t.text;
  }

  Text number(const mpq_class& q) const {
    const bool minus = sgn(q) < 0;
    if (q.get_den() == 1) return {q.get_str(), minus ? kMinus : kAtom};
    if (!latex_) return {q.get_str(), minus ? kMinus : kProduct};
    const std::string s = fmt::format("\\frac{{{}}}{{{}}}", mpz_class(abs(q.get_num())).get_str(), q.get_den().get_str());
    return {minus ? "-" + s : s, minus ? kMinus : kAtom};
  }

  Text sum(const Expr& e) {
    std::string s;
    for (const Expr& a : e.args()) {
      std::string term = print(a).text;
      if (s.empty()) {
        s = term;
      } else if (term[0] == '-') {
        s += " - " + term.substr(1);
      } else {
        s += " + " + term;
      }
    }
    return {s, kSum};
  }

  // b ** -q as what stands below the line, or nothing; (1/x) ** -2 stays as it is, since (1/x) ** 2 is another tree.
  static std::optional<Expr> below(const Expr& e) {
    if (e.op() != Op::Pow || e.arg(1).op() != Op::Number || sgn(e.arg(1).number()) >= 0) return std::nullopt;
    const Expr b = pow(e.arg(0), irt::number(-e.arg(1).number()));
    if (b != e.arg(0) && !(b.op() == Op::Pow && b.arg(0) == e.arg(0))) return std::nullopt;
    return b;
  }

  Text product(std::span<const Expr> factors) {
    mpq_class c = 1;
    std::vector<std::string> above, under;
    for (const Expr& f : factors) {
      if (f.op() == Op::Number) {
        c = f.number();
      } else if (const auto b = below(f)) {
        under.push_back(latex_ ? print(*b).text : at_least(*b, kPower));
      } else {
        above.push_back(at_least(f, kMinus));
      }
    }
    const bool minus = sgn(c) < 0;
    const mpz_class top = abs(c.get_num());
    if (top != 1 || above.empty()) above.insert(above.begin(), top.get_str());
    if (c.get_den() != 1) under.insert(under.begin(), c.get_den().get_str());
    std::string s;
    if (latex_) {
      const auto join = [](const std::vector<std::string>& parts) {
        std::string t;
        for (const std::string& p : parts) t += (t.empty() ? "" : std::isdigit(static_cast<unsigned char>(p[0])) ? " \\cdot " : " ") + p;
        return t;
      };
      s = under.empty() ? join(above) : fmt::format("\\frac{{{}}}{{{}}}", join(above), join(under));
    } else {
      for (const std::string& p : above) s += (s.empty() ? "" : "*") + p;
      for (const std::string& p : under) s += "/" + p;
    }
    return {minus ? "-" + s : s, minus || (latex_ && under.empty()) || !latex_ ? (minus ? kMinus : kProduct) : kAtom};
  }

  Text power(const Expr& e) {
    if (below(e)) return product(std::span(&e, 1));
    const Expr& exponent = e.arg(1);
    if (exponent.op() == Op::Number && exponent.number() == mpq_class(1, 2))
      return {latex_ ? fmt::format("\\sqrt{{{}}}", print(e.arg(0)).text) : fmt::format("sqrt({})", print(e.arg(0)).text), kAtom};
    const std::string base = at_least(e.arg(0), kAtom);
    if (latex_) return {fmt::format("{}^{{{}}}", base, print(exponent).text), kPower};
    return {fmt::format("{}**{}", base, at_least(exponent, kAtom)), kPower};
  }

  std::string list(const Expr& e) {
    std::string s;
    for (const Expr& a : e.args()) s += (s.empty() ? "" : ", ") + print(a).text;
    return s;
  }

  Text piecewise(const Expr& e) {
    std::string s;
    for (std::size_t i = 0; i < e.arity(); i += 2) {
      const std::string value = print(e.arg(i)).text, condition = print(e.arg(i + 1)).text;
      s += latex_ ? fmt::format("{} & {} \\\\ ", value, condition) : fmt::format("{}({}, {})", i ? ", " : "", value, condition);
    }
    return {latex_ ? "\\begin{cases} " + s + "\\end{cases}" : "Piecewise(" + s + ")", kAtom};
  }

  Text comparison(const Expr& e, const char* sign) {
    return {fmt::format("{} {} {}", print(e.arg(0)).text, sign, print(e.arg(1)).text), kSum};
  }

  static std::string latex_name(const std::string& name) {
    static constexpr const char* kGreek[] = {"alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda",
                                             "mu", "nu", "xi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega"};
    for (const char* g : kGreek)
      if (name == g) return std::string("\\") + g;
    if (name.size() == 1) return name;
    std::string escaped;
    for (char c : name) escaped += c == '_' ? std::string("\\_") : std::string(1, c);
    return "\\mathit{" + escaped + "}";
  }

  Text function(const Expr& e) {
    const std::string name = function_name(e.op());
    if (!latex_) return {fmt::format("{}({})", name, list(e)), kAtom};
    switch (e.op()) {
      case Op::Abs: return {fmt::format("\\left|{}\\right|", list(e)), kAtom};
      case Op::Floor: return {fmt::format("\\lfloor {} \\rfloor", list(e)), kAtom};
      case Op::Ceiling: return {fmt::format("\\lceil {} \\rceil", list(e)), kAtom};
      case Op::Cbrt: return {fmt::format("\\sqrt[3]{{{}}}", list(e)), kAtom};
      case Op::Exp: return {fmt::format("e^{{{}}}", list(e)), kPower};
      case Op::Equal: return comparison(e, "=");
      case Op::Unequal: return comparison(e, "\\neq");
      case Op::Sin:
      case Op::Cos:
      case Op::Tan:
      case Op::Sinh:
      case Op::Cosh:
      case Op::Tanh:
      case Op::Log: return {fmt::format("\\{}\\left({}\\right)", name, list(e)), kAtom};
      default: return {fmt::format("\\operatorname{{{}}}\\left({}\\right)", name, list(e)), kAtom};
    }
  }

  Text dispatch(const Expr& e) {
    switch (e.op()) {
      case Op::Number: return number(e.number());
      case Op::Pi: return {latex_ ? "\\pi" : "pi", kAtom};
      case Op::E: return {latex_ ? "e" : "E", kAtom};
      case Op::Symbol: return {latex_ ? latex_name(e.name()) : e.name(), kAtom};
      case Op::Add: return sum(e);
      case Op::Mul: return product(e.args());
      case Op::Pow: return power(e);
      case Op::Piecewise: return piecewise(e);
      case Op::Less: return comparison(e, "<");
      case Op::LessEqual: return comparison(e, latex_ ? "\\leq" : "<=");
      case Op::True: return {latex_ ? "\\text{True}" : "True", kAtom};
      case Op::False: return {latex_ ? "\\text{False}" : "False", kAtom};
      default: return function(e);
    }
  }
};

}  // namespace

std::string to_string(const Expr& e) { return Printer(false).print(e).text; }
std::string to_latex(const Expr& e) { return Printer(true).print(e).text; }

}  // namespace irt
