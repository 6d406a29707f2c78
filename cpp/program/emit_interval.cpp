// Interval emitter (S1 section 4.2): every value is a pair of ends, rounded outward by the helpers.
#include <fmt/format.h>

#include <cmath>

#include "program/operators.h"
#include "program/partial.h"
#include "program/text.h"

namespace irt::program {
namespace {

// Scales by constants whose products stay far from underflow and overflow of single precision.
bool plain(double c) { return std::fabs(c) > 1e-30 && std::fabs(c) < 1e30; }

std::string pair(const numerics::Bounds& b) { return fmt::format("ia((F){}, (F){})", literal(b.lo), literal(b.hi)); }

std::string constant_operand(const Program& program, Value v, Precision precision) {
  return pair(outward(program[v].value, precision));
}

}  // namespace

std::string exponent_range(const Program& program, Value v, const std::string& range) {
  return program[v].nonpositive ? fmt::format("ia_nonpositive({})", range) : range;
}

std::string interval_rule(const Program& program, Value v, const std::string& a, const std::string& b, Precision precision,
                          std::set<long>& powers) {
  const Instruction& in = program[v];
  const Operator& op = describe(in.code);
  switch (in.code) {
    case Code::Constant: return constant_operand(program, v, precision);
    case Code::Coordinate: return coordinate(in.index);
    case Code::Parameter: return fmt::format("ia((F)p[{}], (F)p[{}])", 2 * in.index, 2 * in.index + 1);
    case Code::Add:
      if (program.is_constant(in.b)) {
        const auto c = outward(program[in.b].value, precision);
        return fmt::format("ia_shift({}, {}, {})", a, literal(c.lo), literal(c.hi));
      } else {
        return fmt::format("ia_add({}, {})", a, b);
      }
    case Code::Mul: {
      const double c = program.is_constant(in.a) ? nearest(program[in.a].value, precision) : 0;
      if (plain(c)) {
        const auto& exact = program[in.a].value;
        const bool known = exact.lo == c && exact.hi == c;
        const std::string scaled =
            fmt::format("ia_scale({}, {}, {})", b, literal(std::fabs(c)), known ? "EXACT" : "R(2.0)");
        return c < 0 ? fmt::format("ia_neg({})", scaled) : scaled;
      } else {
        const bool both = program[in.a].nonnegative && program[in.b].nonnegative;
        return fmt::format("{}({}, {})", both ? "ia_mul_nonnegative" : "ia_mul", a, b);
      }
    }
    case Code::Power: {
      powers.insert(in.index);
      const char* rule = in.index % 2 == 0 ? "IA_POWER_EVEN" : "IA_POWER_ODD";
      return fmt::format("{}({}, power_{}, {})", rule, a, in.index, literal(0.5 * static_cast<double>(in.index)));
    }
    case Code::Exp: return fmt::format("{}({})", op.interval, exponent_range(program, in.a, a));
    case Code::Polynomial: return fmt::format("IA_POLYNOMIAL({}, taylor_{})", a, in.index);
    default: return fill(std::string(op.interval) + (op.arity == 2 ? "($a, $b)" : "($a)"), a, b, "", name(v));
  }
}

Emitted emit_interval(const Program& program, Precision precision) {
  Emitted out;
  std::string text = enclosure_head(program, "IA");
  std::set<long> powers;
  std::set<std::string> real_powers;
  out.files.insert("interval.cl");
  const auto operand = [&](Value v) {
    return v < 0 ? std::string() : program.is_constant(v) ? constant_operand(program, v, precision) : name(v);
  };
  for (Value v = 0; v < static_cast<Value>(program.code.size()); ++v) {
    const Instruction& in = program[v];
    const Operator& op = describe(in.code);
    const std::string r = name(v), a = operand(in.a), b = operand(in.b);
    if (in.code == Code::Constant && v != program.result) continue;  // constants stand where they are used
    out.files.insert(op.interval_file);
    if (emit_masked(program, v, a, b, operand(in.c), precision, 'v', text)) continue;
    const std::string value = interval_rule(program, v, a, b, precision, powers);
    text += fmt::format("  const IA {} = {};\n", r, value);
    emit_inherited(program, v, text);
  }
  text += finish_masks(program) + finish_region(program, operand(program.clip), operand(program.numerator)) + fmt::format("  return {};\n}}\n", name(program.result));
  out.functions = taylor_functions(program, precision);
  for (long n : powers) out.functions.insert(power_function(n));
  out.source = text;
  return out;
}

}  // namespace irt::program
