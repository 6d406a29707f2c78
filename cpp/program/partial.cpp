// Masks of partial operators, conditions and choices.
#include "program/partial.h"

#include <fmt/format.h>

#include "program/operators.h"
#include "program/text.h"

namespace irt::program {
namespace {

// The masks of the operands, joined; "" where no operand has any.
std::string joined(const Program& program, const Instruction& in, char kind) {
  std::string text;
  for (Value w : {in.a, in.b, in.c})
    if (w >= 0 && program[w].partial && !(kind == 'u' && is_condition(program[w].code)))
      text += (text.empty() ? "" : " | ") + mask(kind, w);
  return text;
}

std::string mask_or_none(const Program& program, Value v, char kind) {
  return program[v].partial ? mask(kind, v) : "NONE";
}

void emit_select(const Program& program, Value v, const std::string& b, const std::string& c, char prefix,
                 std::string& text) {
  const Instruction& in = program[v];
  const std::string t = name(in.a, prefix), ub = mask_or_none(program, in.b, 'u'), uc = mask_or_none(program, in.c, 'u');
  text += fmt::format("  const IA {} = ia_select({}, {}, {}, {}, {});\n", name(v, prefix), t, b, c, ub, uc);
  text += fmt::format("  const I u{0} = ({1}.yes & {2}) | ({1}.no & {3}) | ({2} & {3});\n", v, t, ub, uc);
  text += fmt::format("  const I r{0} = ~({1}.yes | {1}.no) | (~{1}.no & {2}) | (~{1}.yes & {3});\n", v, t,
                      mask_or_none(program, in.b, 'r'), mask_or_none(program, in.c, 'r'));
}

void emit_condition(const Program& program, Value v, const std::string& a, const std::string& b, char prefix,
                    std::string& text) {
  const Instruction& in = program[v];
  const Operator& op = describe(in.code);
  if (in.code == Code::True) {
    text += fmt::format("  const TRI {} = tri(ALL, NONE);\n", name(v, prefix));
    return;
  }
  const bool compares = in.code == Code::Less || in.code == Code::LessEqual || in.code == Code::Equal;
  const std::string x = compares ? a : name(in.a, prefix), y = compares ? b : name(in.b, prefix);
  std::string value = op.arity == 2 ? fmt::format("{}({}, {})", op.interval, x, y) : fmt::format("{}({})", op.interval, x);
  // What compares a value that may be undefined decides nothing there.
  if (const std::string rough = joined(program, in, 'r'); compares && !rough.empty())
    value = fmt::format("tri_unless({}, {})", value, rough);
  text += fmt::format("  const TRI {} = {};\n", name(v, prefix), value);
  if (in.partial) text += fmt::format("  const I r{} = {};\n", v, joined(program, in, 'r'));
}

}  // namespace

bool emit_masked(const Program& program, Value v, const std::string& a, const std::string& b, const std::string& c,
                 Precision precision, char prefix, std::string& text) {
  const Instruction& in = program[v];
  const Operator& op = describe(in.code);
  const std::string result = name(v, prefix);
  if (is_condition(in.code)) {
    emit_condition(program, v, a, b, prefix, text);
    return true;
  }
  if (in.code == Code::Select) {
    emit_select(program, v, b, c, prefix, text);
    return true;
  }
  if (in.code == Code::Undefined) {
    text += fmt::format("  const IA {0} = ia((F)0, (F)0);\n  const I u{1} = ALL, r{1} = ALL;\n", result, v);
    return true;
  }
  if (!op.partial) return false;
  text += fmt::format("  I u{0}, r{0};\n", v);
  if (in.code == Code::RealPower) {
    const auto e = outward(in.value, precision);
    text += fmt::format("  const IA {} = ia_pow_constant({}, {}, {}, &u{}, &r{});\n", result, a, literal(e.lo),
                        literal(e.hi), v, v);
  } else if (op.arity == 2) {
    text += fmt::format("  const IA {} = {}({}, {}, &u{}, &r{});\n", result, op.interval, a, b, v, v);
  } else {
    text += fmt::format("  const IA {} = {}({}, &u{}, &r{});\n", result, op.interval, a, v, v);
  }
  for (char kind : {'u', 'r'})
    if (const std::string more = joined(program, in, kind); !more.empty())
      text += fmt::format("  {} |= {};\n", mask(kind, v), more);
  return true;
}

void emit_inherited(const Program& program, Value v, std::string& text) {
  const Instruction& in = program[v];
  if (!in.partial) return;
  text += fmt::format("  const I u{} = {}, r{} = {};\n", v, joined(program, in, 'u'), v, joined(program, in, 'r'));
}

std::string finish_masks(const Program& program) {
  const auto both = [&](char kind) {
    const std::string result = mask_or_none(program, program.result, kind);
    return program.function < 0 ? result : result + " | " + mask_or_none(program, program.function, kind);
  };
  return fmt::format("  *undefined = {};\n  *rough = {};\n", both('u'), both('r'));
}

std::string finish_region(const Program& program, const std::string& clip, const std::string& numerator) {
  if (!program.has_region()) return {};
  std::string text = "  I outer = NONE, inner = ALL;\n";
  if (program.clip >= 0) {
    const std::string u = mask_or_none(program, program.clip, 'u'), r = mask_or_none(program, program.clip, 'r');
    text += fmt::format("  const IA region = {};\n  outer = GT(region.lo, (F)0) | {};\n  inner = LE(region.hi, (F)0) & ~{};\n", clip, u, r);
  }
  if (program.numerator >= 0)
    text += fmt::format("  // f is not zero where its numerator is not.\n  const IA above = {};\n  outer |= GT(above.lo, (F)0) | LT(above.hi, (F)0);\n", numerator);
  return text + "  *outside = outer;\n  *inside = inner;\n";
}

}  // namespace irt::program
