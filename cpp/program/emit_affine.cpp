// Affine emitter (S1 section 4.3): values are forms x + y e + z u over a piece of ray, and ranges where an operator needs
// them or where the result is one (steps, constants). A value is converted from one to the other at most once.
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
  AffineEmitter(const Program& program, Precision precision, bool infinite)
      : program_(program), precision_(precision), infinite_(infinite), has_form_(program.code.size()), has_range_(program.code.size()),
        loses_(program.code.size()) {}

  Emitted run() {
    out_.files = {"interval.cl", "affine.cl"};
    for (Value v = 0; v < static_cast<Value>(program_.code.size()); ++v)
      if (!program_.is_constant(v) || v == program_.result) emit(v);
    const bool ranged = program_.derivative || only_range(program_.result);
    out_.result = ranged ? Result::range : loses_[static_cast<std::size_t>(program_.result)] == kEnd ? Result::both : Result::form;
    std::string result = ranged ? range(program_.result) : form(program_.result);
    if (out_.result == Result::both) {
      const std::string ends = range(program_.result);
      text_ += fmt::format("  const FORM both = {{{0}.x, {0}.y, {0}.z, {1}.lo, {1}.hi}};\n", result, ends);
      result = "both";
    }
    const std::string region = range(program_.clip), numerator = range(program_.numerator);
    out_.functions = taylor_functions(program_, precision_);
    for (long n : powers_) out_.functions.insert(power_function(n));
    out_.source = enclosure_head(program_, "RA") + text_ + finish_masks(program_) + finish_region(program_, region, numerator) +
                  fmt::format("  return {};\n}}\n", result);
    return std::move(out_);
  }

 private:
  const Program& program_;
  Precision precision_;
  bool infinite_;
  std::vector<char> has_form_, has_range_, loses_;
  std::set<long> powers_;
  std::string text_;
  Emitted out_;

  // In has_form_: the form is a number times another one, and not in the text yet: sums of it need not have it (scaled_sum).
  static constexpr char kScaled = 2;

  std::string form(Value v) {
    char& has = has_form_[static_cast<std::size_t>(v)];
    if (has != 1) text_ += fmt::format("  const RA {} = {};\n", name(v), has == kScaled ? scale(v) : fmt::format("ra_from_range({})", range(v)));
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
    if (!has) {
      const std::string value = form(v);
      text_ += fmt::format("  const IA {} = {}ra_range({}){};\n", name(v, 'q'), program_[v].nonnegative ? "ia_nonnegative(" : "", value, program_[v].nonnegative ? ")" : "");
    }
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

  // What forms lose and ranges keep, so that ranges go along with the forms from there on. A range that has lost an end is none of a form, and high
  // powers bend so much that only their ranges tell anything of long pieces: there the result is both. What jumps stays as wide in the shortest
  // piece: later forms of it, as squares, reach where nothing is.
  static constexpr char kNothing = 0, kJump = 1, kEnd = 2;
  static constexpr long kSteep = 20;  // exponents above it cost less with their ranges than without (docs/performance.md)

  char loses(Value v) const {
    switch (program_[v].code) {
      case Code::Recip:
      case Code::Div:
      case Code::Log:
      case Code::Tan:
      case Code::Pow: return kEnd;
      case Code::Exp:
      case Code::Sinh:
      case Code::Cosh: return infinite_ ? kEnd : kNothing;
      case Code::RealPower: return program_[v].value.lo < 0 ? kEnd : kNothing;
      case Code::Power: return program_[v].index > kSteep ? kEnd : kNothing;
      case Code::Atan2:
      case Code::Mod:
      case Code::Select: return kJump;
      default: return kNothing;
    }
  }

  void emit(Value v) {
    const Instruction& in = program_[v];
    const Operator& op = describe(in.code);
    if (is_condition(in.code) || in.code == Code::Undefined || op.ranged || !(op.affine || in.code == Code::Power || in.code == Code::Polynomial || op.arity == 0))
      return emit_ranged(v);
    // What has forgotten where on the ray it is gains nothing from forms.
    if (in.a >= 0 && only_range(in.a) && only_range(in.b)) {
      out_.files.insert(op.interval_file);
      loses_[static_cast<std::size_t>(v)] = inherits(v);
      const std::string a = range(in.a), b = range(in.b);
      return define_range(v, interval_rule(program_, v, a, b, precision_, powers_));
    }
    emit_form(v);
    if (!(loses_[static_cast<std::size_t>(v)] = inherits(v)) || has_range_[static_cast<std::size_t>(v)]) return;
    text_ += fmt::format("  const IA {} = {};\n", name(v, 'q'), range_beside_form(v));
    has_range_[static_cast<std::size_t>(v)] = 1;
  }

  char inherits(Value v) const {
    const Instruction& in = program_[v];
    char most = loses(v);
    for (Value w : {in.a, in.b, in.c})
      if (w >= 0) most = std::max(most, loses_[static_cast<std::size_t>(w)]);
    return most;
  }

  // A range that goes along with a form.
  std::string range_beside_form(Value v) {
    const Instruction& in = program_[v];
    // Of a coordinate's power the exact range, whose upper end the form has as well.
    if (in.code == Code::Power && in.index > kSteep && in.index % 2 == 0 && program_[in.a].code == Code::Coordinate) {
      powers_.insert(in.index);
      return fmt::format("RA_EVEN_POWER_RANGE({0}, power_{1}, power_{2}, R({3}.0))", form(in.a), in.index, in.index - 2, in.index / 2);
    }
    const std::string a = range(in.a), b = range(in.b), alone = interval_rule(program_, v, a, b, precision_, powers_);
    return fmt::format("ia_meet(ra_range({}), {})", form(v), alone);
  }

  // Operators whose affine rule needs no ranges.
  void emit_form(Value v) {
    const Instruction& in = program_[v];
    const Operator& op = describe(in.code);
    switch (in.code) {
      case Code::Coordinate: return define(v, coordinate(in.index));
      case Code::Parameter: return define_range(v, fmt::format("ia((F)p[{}], (F)p[{}])", 2 * in.index, 2 * in.index + 1));
      case Code::Constant: return define_range(v, range(v));
      case Code::Add:
        if (program_.is_constant(in.b)) {
          // A constant past the largest real is a range, and so is what it is added to.
          if (std::isinf(nearest(program_[in.b].value, precision_)))
            return define_range(v, interval_rule(program_, v, range(in.a), range(in.b), precision_, powers_));
          return define(v, shift(in.a, program_[in.b].value));
        }
        [[fallthrough]];
      case Code::Sub:
        if (const std::string sum = scaled_sum(in.a, in.b, in.code == Code::Sub); !sum.empty()) return define(v, sum);
        break;
      case Code::Mul:
        if (!program_.is_constant(in.a)) break;
        if (factor(v) == 0) {
          const auto b = outward(program_[in.a].value, precision_);
          return define(v, fmt::format("ra_mul(ra_from_range(ia((F){}, (F){})), {})", literal(b.lo), literal(b.hi), form(in.b)));
        }
        has_form_[static_cast<std::size_t>(v)] = kScaled;
        return emit_inherited(program_, v, text_);
      case Code::Power: return define(v, power(v));
      case Code::Polynomial:
        out_.files.insert({"polynomial.cl", "affine_polynomial.cl"});
        return define(v, fmt::format("RA_POLYNOMIAL({}, taylor_{})", form(in.a), in.index));
      default: break;
    }
    out_.files.insert(op.affine_file);
    const std::string a = form(in.a), b = op.arity == 2 ? ", " + form(in.b) : "";
    define(v, fmt::format("{}({}{})", op.affine, a, b));
  }

  // The range of the result, and a form where there is a rule for it and an operand that has one.
  void emit_ranged(Value v) {
    const Instruction& in = program_[v];
    const Operator& op = describe(in.code);
    out_.files.insert(op.interval_file);
    const std::string a = range(in.a), b = range(in.b), c = range(in.c);
    if (emit_masked(program_, v, a, b, c, precision_, 'q', text_)) {
      has_range_[static_cast<std::size_t>(v)] = 1;
    } else {
      define_range(v, interval_rule(program_, v, a, b, precision_, powers_));
    }
    loses_[static_cast<std::size_t>(v)] = inherits(v);
    const bool chooses = in.code == Code::Select;
    if (!op.affine || (chooses ? only_range(in.b) && only_range(in.c) : only_range(in.a) && only_range(in.b))) return;
    out_.files.insert(op.affine_file);
    const std::string q = name(v, 'q');
    std::string value;
    if (chooses) {
      value = fmt::format("ra_select({}, {}, {}, {})", a, form(in.b), form(in.c), q);
    } else if (in.code == Code::RealPower) {
      const auto e = outward(in.value, precision_);
      value = fmt::format("ra_pow_constant({}, {}, {}, {}, {})", form(in.a), a, q, literal(e.lo), literal(e.hi));
    } else if (op.arity == 2) {
      value = fmt::format("{}({}, {}, {}, {}, {})", op.affine, form(in.a), form(in.b), a, b, q);
    } else {
      value = fmt::format("{}({}, {}, {})", op.affine, form(in.a), in.code == Code::Exp ? exponent_range(program_, in.a, a) : a, q);
    }
    text_ += fmt::format("  const RA {} = {};\n", name(v), value);
    has_form_[static_cast<std::size_t>(v)] = 1;
  }

  std::string shift(Value a, const numerics::Bounds& exact) {
    const auto b = outward(exact, precision_);
    const double c = nearest(exact, precision_);
    return fmt::format("ra_shift({}, {}, {})", form(a), literal(c), literal(std::max(b.hi - c, c - b.lo)));
  }

  // c where v is c times something and c a number of ordinary size; else 0.
  double factor(Value v) const {
    const Instruction& in = program_[v];
    if (in.code != Code::Mul || !program_.is_constant(in.a)) return 0;
    const double c = nearest(program_[in.a].value, precision_);
    return std::fabs(c) > 1e-30 && std::fabs(c) < 1e30 ? c : 0;
  }

  // By how many ulp that may be off.
  const char* unknown(Value v) const {
    const numerics::Bounds& exact = program_[program_[v].a].value;
    return exact.lo == exact.hi && exact.lo == factor(v) ? "R(0.0)" : "R(1.0)";
  }

  std::string scale(Value v) {
    const double c = factor(v);
    const std::string scaled = fmt::format("ra_scale({}, {}, {})", form(program_[v].b), literal(std::fabs(c)), unknown(v));
    return c < 0 ? fmt::format("ra_neg({})", scaled) : scaled;
  }

  // a + b, or a - b, where one of the two is a number times something: one operation for each part of the form instead of two.
  std::string scaled_sum(Value a, Value b, bool minus) {
    const auto sum = [&](Value scaled, double c, const std::string& other) {
      return fmt::format("ra_scale_add({}, {}, {}, {})", form(program_[scaled].b), literal(c), unknown(scaled), other);
    };
    if (const double c = factor(a); c != 0 && !only_range(a)) return sum(a, c, minus ? fmt::format("ra_neg({})", form(b)) : form(b));
    if (const double c = factor(b); c != 0 && !only_range(b)) return sum(b, minus ? -c : c, form(a));
    return {};
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

Emitted emit_affine(const Program& program, Precision precision, bool infinite) { return AffineEmitter(program, precision, infinite).run(); }

}  // namespace irt::program
