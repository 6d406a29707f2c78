// Values at a point, and their derivative along a direction: forward through the program.
#include <fmt/format.h>

#include <vector>

#include "program/operators.h"
#include "program/text.h"

namespace irt::program {
namespace {

// The values that `result` is made of.
std::vector<char> needed(const Program& program, Value result) {
  std::vector<char> need(program.code.size(), 0);
  need[static_cast<std::size_t>(result)] = 1;
  for (Value v = result; v >= 0; --v)
    if (need[static_cast<std::size_t>(v)])
      for (const Value w : {program[v].a, program[v].b, program[v].c})
        if (w >= 0) need[static_cast<std::size_t>(w)] = 1;
  return need;
}

// The derivative of v along the direction, from those of its operands; empty where it is zero.
std::string slope_of(const Program& program, Value v, Precision precision, const std::vector<char>& varies) {
  const Instruction& in = program[v];
  const auto moves = [&](Value w) { return w >= 0 && varies[static_cast<std::size_t>(w)]; };
  if (in.code == Code::Coordinate) return fmt::format("d{}", "xyz"[in.index]);
  // Chosen, not multiplied by one and zero: what is not chosen may have a pole here.
  const auto choice = [&](const std::string& which, Value p, Value q) {
    const auto part = [&](Value w) { return moves(w) ? name(w, 's') : std::string("(F)0"); };
    return moves(p) || moves(q) ? fmt::format("SELECT({}, {}, {})", which, part(p), part(q)) : "";
  };
  if (in.code == Code::Select) return choice(name(in.a), in.b, in.c);
  if (in.code == Code::Min) return choice(fmt::format("LE({}, {})", name(in.a), name(in.b)), in.a, in.b);
  if (in.code == Code::Max) return choice(fmt::format("GE({}, {})", name(in.a), name(in.b)), in.a, in.b);
  std::string sum;
  for (const auto& [operand, factor] : partials_of(program, v, precision)) {
    if (!moves(operand)) continue;
    const std::string s = name(operand, 's'), term = factor == "(F)1" ? s : factor == "-(F)1" ? "-" + s : fmt::format("({}) * {}", factor, s);
    sum += (sum.empty() ? "" : " + ") + term;
  }
  return sum;
}

}  // namespace

std::string value_function(const Program& program, Value result, const char* function, Precision precision) {
  std::string text = fmt::format("static inline F {}(F x, F y, F z PARAMETERS) {{\n", function);
  const auto need = needed(program, result);
  for (Value v = 0; v <= result; ++v)
    if (need[static_cast<std::size_t>(v)]) text += point_statement(program, v, precision, false);
  return text + fmt::format("  return {};\n}}\n", name(result));
}

std::string point_statement(const Program& program, Value v, Precision precision, bool derivative) {
  const Instruction& in = program[v];
  const std::string r = name(v), a = name(in.a), b = name(in.b), c = name(in.c);
  std::string value;
  switch (in.code) {
    case Code::Power:
      if (!derivative) return power_chain(a, in.index, r);
      return power_chain(a, in.index - 1, fmt::format("{}_below", r)) + fmt::format("  const F {0} = {0}_below * {1};\n", r, a);
    case Code::Polynomial: {
      // Horner's rule, for the value and the slope together.
      const auto& k = program.polynomials[static_cast<std::size_t>(in.index)];
      std::string text = fmt::format("  F {0}_p = (F){1};\n", r, literal(nearest(k.back(), precision)));
      if (derivative) text += fmt::format("  F {0}_d = (F)0;\n", r);
      for (std::size_t i = k.size() - 1; i-- > 0;) {
        if (derivative) text += fmt::format("  {0}_d = fma({0}_d, {1}, {0}_p);\n", r, a);
        text += fmt::format("  {0}_p = fma({0}_p, {1}, (F){2});\n", r, a, literal(nearest(k[i], precision)));
      }
      return text + fmt::format("  const F {0} = {0}_p;\n", r);
    }
    case Code::Constant: value = "(F)" + literal(nearest(in.value, precision)); break;
    case Code::Coordinate: value = std::string(1, "xyz"[in.index]); break;
    case Code::Parameter: value = fmt::format("(F)p[{}]", 2 * in.index); break;
    default: value = fill(describe(in.code).point, a, b, c, r, literal(nearest(in.value, precision)));
  }
  return fmt::format("  const {} {} = {};\n", is_condition(in.code) ? "I" : "F", r, value);
}

std::vector<std::pair<Value, std::string>> partials_of(const Program& program, Value v, Precision precision) {
  const Instruction& in = program[v];
  const std::string r = name(v);
  if (in.code == Code::Power) return {{in.a, fmt::format("R({}.0) * {}_below", in.index, r)}};
  if (in.code == Code::Polynomial) return {{in.a, fmt::format("{}_d", r)}};
  std::vector<std::pair<Value, std::string>> parts;
  std::string_view rest = describe(in.code).partials;
  for (const Value operand : {in.a, in.b}) {
    if (rest.empty()) break;
    const std::size_t end = rest.find(';');
    parts.emplace_back(operand, fill(rest.substr(0, end), name(in.a), name(in.b), "", r, literal(nearest(in.value, precision))));
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return parts;
}

Emitted emit_value(const Program& program, Precision precision) {
  std::string text = "// Value at a point.\n" + value_function(program, program.result, "irt_value", precision);
  if (program.clip >= 0) text += "// Where zeros count: not above zero.\n" + value_function(program, program.clip, "irt_region", precision);
  return {text, {}};
}

Emitted emit_slope(const Program& program, Precision precision) {
  std::string text =
      "// Value at a point, and derivative along a direction.\n"
      "static inline F irt_slope(F x, F y, F z, F dx, F dy, F dz PARAMETERS, F* slope) {\n";
  const auto need = needed(program, program.result);
  std::vector<char> varies(program.code.size(), 0);
  for (Value v = 0; v <= program.result; ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (!need[i]) continue;
    text += point_statement(program, v, precision, true);
    if (is_condition(program[v].code)) continue;
    const std::string slope = slope_of(program, v, precision, varies);
    varies[i] = !slope.empty();
    if (varies[i]) text += fmt::format("  const F {} = {};\n", name(v, 's'), slope);
  }
  const bool moves = varies[static_cast<std::size_t>(program.result)];
  return {text + fmt::format("  *slope = {};\n  return {};\n}}\n", moves ? name(program.result, 's') : "(F)0", name(program.result)), {}};
}

}  // namespace irt::program
