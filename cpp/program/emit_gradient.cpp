// The value and the gradient at a point: forward through the program, then back with the chain rule.
#include <fmt/format.h>

#include <sstream>
#include <vector>

#include "program/operators.h"
#include "program/text.h"

namespace irt::program {
namespace {

bool is_condition(Code code) { return code >= Code::Less && code <= Code::True; }

std::vector<std::string> split(const char* partials) {
  std::vector<std::string> parts;
  std::stringstream stream(partials);
  for (std::string part; std::getline(stream, part, ';');) parts.push_back(part);
  return parts;
}

}  // namespace

Emitted emit_gradient(const Program& program, Precision precision) {
  std::string text =
      "// Value and gradient at a point, by reverse accumulation.\n"
      "static inline F irt_gradient(F x, F y, F z PARAMETERS, F* gx, F* gy, F* gz) {\n";
  const auto n = static_cast<Value>(program.code.size());
  std::vector<char> varies(program.code.size(), 0);  // depends on x, y, z
  for (Value v = 0; v < n; ++v) {
    const Instruction& in = program[v];
    const auto i = static_cast<std::size_t>(v);
    varies[i] = in.code == Code::Coordinate;
    for (Value w : {in.a, in.b, in.c})
      if (w >= 0) varies[i] = varies[i] || varies[static_cast<std::size_t>(w)];
    const std::string r = name(v), a = name(in.a), b = name(in.b), c = name(in.c);
    if (in.code == Code::Power) {
      text += power_chain(a, in.index - 1, fmt::format("{}_below", r));
      text += fmt::format("  const F {0} = {0}_below * {1};\n", r, a);
      continue;
    }
    if (in.code == Code::Polynomial) {
      // Horner's rule, for the value and the slope together.
      const auto& c = program.polynomials[static_cast<std::size_t>(in.index)];
      text += fmt::format("  F {0}_p = (F){1}, {0}_d = (F)0;\n", r, literal(nearest(c.back(), precision)));
      for (std::size_t k = c.size() - 1; k-- > 0;)
        text += fmt::format("  {0}_d = fma({0}_d, {1}, {0}_p), {0}_p = fma({0}_p, {1}, (F){2});\n", r, a, literal(nearest(c[k], precision)));
      text += fmt::format("  const F {0} = {0}_p;\n", r);
      continue;
    }
    std::string value;
    switch (in.code) {
      case Code::Constant: value = "(F)" + literal(nearest(in.value, precision)); break;
      case Code::Coordinate: value = std::string(1, "xyz"[in.index]); break;
      case Code::Parameter: value = fmt::format("(F)p[{}]", 2 * in.index); break;
      default: value = fill(describe(in.code).point, a, b, c, r, literal(nearest(in.value, precision)));
    }
    text += fmt::format("  const {} {} = {};\n", is_condition(in.code) ? "I" : "F", r, value);
  }
  // The adjoint of v, d result / d v, as text; sums of one term need no variable of their own.
  std::vector<std::vector<std::string>> terms(program.code.size());
  std::string g[3] = {"(F)0", "(F)0", "(F)0"};
  const auto add = [&](Value to, const std::string& term) {
    if (varies[static_cast<std::size_t>(to)]) terms[static_cast<std::size_t>(to)].push_back(term);
  };
  terms[static_cast<std::size_t>(program.result)] = {"(F)1"};
  for (Value v = n; v-- > 0;) {
    const auto i = static_cast<std::size_t>(v);
    const Instruction& in = program[v];
    if (!varies[i] || terms[i].empty() || is_condition(in.code)) continue;
    const std::string d = fmt::format("d{}", v), r = name(v), a = name(in.a), b = name(in.b);
    std::string sum = terms[i][0];
    for (std::size_t k = 1; k < terms[i].size(); ++k) sum += " + " + terms[i][k];
    text += fmt::format("  const F {} = {};\n", d, sum);
    if (in.code == Code::Coordinate) {
      g[in.index] = d;
    } else if (in.code == Code::Power) {
      add(in.a, fmt::format("{} * (R({}.0) * {}_below)", d, in.index, r));
    } else if (in.code == Code::Polynomial) {
      add(in.a, fmt::format("{} * {}_d", d, r));
    } else if (in.code == Code::Select) {
      add(in.b, fmt::format("SELECT({}, {}, (F)0)", a, d));
      add(in.c, fmt::format("SELECT({}, (F)0, {})", a, d));
    } else {
      const Operator& op = describe(in.code);
      const auto partials = split(op.partials);
      const Value operands[] = {in.a, in.b};
      for (std::size_t k = 0; k < partials.size(); ++k) {
        const std::string p = fill(partials[k], a, b, "", r, literal(nearest(in.value, precision)));
        const std::string term = p == "(F)1" ? d : p == "-(F)1" ? "-" + d : fmt::format("{} * ({})", d, p);
        add(operands[k], term);
      }
    }
  }
  text += fmt::format("  *gx = {};\n  *gy = {};\n  *gz = {};\n  return {};\n}}\n", g[0], g[1], g[2], name(program.result));
  return {text, {}};
}

}  // namespace irt::program
