// Affine emitter (S1 section 4.3): values are forms x + y e + z u over a piece of ray. Operators without an affine rule
// work on ranges; a value is converted from form to range and back at most once, where it is first needed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "program/operators.h"
#include "program/partial.h"
#include "program/text.h"

namespace irt::program {
namespace {

class AffineEmitter {
 public:
  AffineEmitter(const Program& program, Precision precision)
      : program_(program), precision_(precision), has_form_(program.code.size()), has_range_(program.code.size()) {}

  Emitted run() {
    out_.files = {"interval.cl", "affine.cl"};
    for (Value v = 0; v < static_cast<Value>(program_.code.size()); ++v)
      if (!program_.is_constant(v) || v == program_.result) emit(v);
    const bool ranged = only_range(program_.result);
    const std::string result = ranged ? range(program_.result) : form(program_.result);
    out_.range_result = ranged;
    std::string functions;
    for (long n : powers_) functions += power_function(n);
    out_.source = functions + taylor_functions(program_, precision_) +
                  "// Affine enclosure over a piece of ray.\n"
                  "static inline FORM irt_affine(RA x, RA y, RA z PARAMETERS, I* undefined, I* rough) {\n" +
                  text_ + finish_masks(program_) + fmt::format("  return {};\n}}\n", result);
    return std::move(out_);
  }

 private:
  const Program& program_;
  Precision precision_;
  std::vector<char> has_form_, has_range_;
  std::set<long> powers_;
  std::string text_;
  Emitted out_;

  std::string form(Value v) {
    char& has = has_form_[static_cast<std::size_t>(v)];
    if (!has) text_ += fmt::format("  const RA {} = ra_from_range({});\n", name(v), range(v));
    has = 1;
    return name(v);
  }

  std::string range(Value v) {
    if (v < 0) return {};
    if (program_.is_constant(v)) {
      const auto b = outward(program_[v].value, precision_);
      return fmt::format("ia((F){}, (F){})", literal(b.lo), literal(b.hi));
    }
    if (is_condition(program_[v].code)) return name(v, 'q');
    char& has = has_range_[static_cast<std::size_t>(v)];
    if (!has) text_ += fmt::format("  const IA {} = ra_range({});\n", name(v, 'q'), name(v));
    has = 1;
    return name(v, 'q');
  }

  bool only_range(Value v) const {
    if (v < 0 || program_.is_constant(v)) return true;
    return has_range_[static_cast<std::size_t>(v)] && !has_form_[static_cast<std::size_t>(v)];
  }

  void define(Value v, const std::string& value) {
    text_ += fmt::format("  const RA {} = {};\n", name(v), value);
    has_form_[static_cast<std::size_t>(v)] = 1;
    emit_inherited(program_, v, text_);
  }

  void define_range(Value v, const std::string& value) {
    text_ += fmt::format("  const IA {} = {};\n", name(v, 'q'), value);
    has_range_[static_cast<std::size_t>(v)] = 1;
    emit_inherited(program_, v, text_);
  }

  void emit(Value v) {
    const Instruction& in = program_[v];
    const Operator& op = describe(in.code);
    // What has forgotten where on the ray it is gains nothing from forms, which cannot hold half-infinite ranges either.
    if ((op.affine || in.code == Code::Power) && in.a >= 0 && only_range(in.a) && only_range(in.b)) {
      const std::string a = range(in.a), b = range(in.b);
      return define_range(v, interval_rule(program_, v, a, b, precision_, powers_));
    }
    switch (in.code) {
      case Code::Coordinate: return define(v, std::string(1, "xyz"[in.index]));
      case Code::Parameter: return define_range(v, fmt::format("ia((F)p[{}], (F)p[{}])", 2 * in.index, 2 * in.index + 1));
      case Code::Constant: return define_range(v, range(v));
      case Code::Add:
        if (program_.is_constant(in.b)) return define(v, shift(in.a, program_[in.b].value));
        break;
      case Code::Mul:
        if (program_.is_constant(in.a)) return define(v, scale(in.b, program_[in.a].value));
        break;
      case Code::Power: return define(v, power(v));
      case Code::Polynomial:
        out_.files.insert({"polynomial.cl", "affine_polynomial.cl"});
        return define(v, fmt::format("RA_POLYNOMIAL({}, taylor_{})", form(in.a), in.index));
      default: break;
    }
    if (op.affine) {
      const std::string a = form(in.a), b = op.arity == 2 ? ", " + form(in.b) : "";
      return define(v, fmt::format("{}({}{})", op.affine, a, b));
    }
    out_.files.insert(op.interval_file);
    const std::string a = range(in.a), b = range(in.b), c = range(in.c);
    if (emit_masked(program_, v, a, b, c, precision_, 'q', text_)) {
      has_range_[static_cast<std::size_t>(v)] = 1;
      return;
    }
    define_range(v, fill(std::string(op.interval) + (op.arity == 2 ? "($a, $b)" : "($a)"), a, b, "", ""));
  }

  std::string shift(Value a, const numerics::Bounds& exact) {
    const auto b = outward(exact, precision_);
    const double c = nearest(exact, precision_);
    return fmt::format("ra_shift({}, {}, {})", form(a), literal(c), literal(std::max(b.hi - c, c - b.lo)));
  }

  std::string scale(Value a, const numerics::Bounds& exact) {
    const double c = nearest(exact, precision_);
    if (!(std::fabs(c) > 1e-30 && std::fabs(c) < 1e30)) {
      const auto b = outward(exact, precision_);
      return fmt::format("ra_mul(ra_from_range(ia((F){}, (F){})), {})", literal(b.lo), literal(b.hi), form(a));
    }
    const bool known = exact.lo == c && exact.hi == c;
    const std::string scaled = fmt::format("ra_scale({}, {}, {})", form(a), literal(std::fabs(c)), known ? "R(1.5)" : "R(2.5)");
    return c < 0 ? fmt::format("ra_neg({})", scaled) : scaled;
  }

  std::string power(Value v) {
    const Instruction& in = program_[v];
    const long n = in.index;
    const std::string a = form(in.a);
    // Above 4 one linear approximation of the whole power loses less than a chain of squares and products.
    if (n == 3) return fmt::format("ra_mul(ra_sqr({0}), {0})", a);
    if (n == 4) return fmt::format("ra_sqr(ra_sqr({}))", a);
    powers_.insert(n - 1);
    powers_.insert(n - 2);
    out_.files.insert("affine_power.cl");
    return fmt::format("RA_POWER({0}, power_{1}, power_{2}, R({3}.0), {4})", a, n - 1, n - 2, n, n % 2 == 0 ? "ALL" : "NONE");
  }
};

}  // namespace

Emitted emit_affine(const Program& program, Precision precision) { return AffineEmitter(program, precision).run(); }

}  // namespace irt::program
