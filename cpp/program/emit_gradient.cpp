// The value and the gradient at a point: forward through the program, then back with the chain rule.
#include <fmt/format.h>

#include <vector>

#include "program/operators.h"
#include "program/text.h"

namespace irt::program {
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
    text += point_statement(program, v, precision, true);
  }
  // The adjoint of v, d result / d v, as text; sums of one term need no variable of their own.
  std::vector<std::vector<std::string>> terms(program.code.size());
  std::vector<char> chosen(program.code.size(), 0);  // stands below a choice
  std::string g[3] = {"(F)0", "(F)0", "(F)0"};
  const auto add = [&](Value to, const std::string& term, bool below) {
    const auto i = static_cast<std::size_t>(to);
    if (!varies[i]) return;
    terms[i].push_back(term);
    chosen[i] = chosen[i] || below;
  };
  terms[static_cast<std::size_t>(program.result)] = {"(F)1"};
  for (Value v = n; v-- > 0;) {
    const auto i = static_cast<std::size_t>(v);
    const Instruction& in = program[v];
    if (!varies[i] || terms[i].empty() || is_condition(in.code)) continue;
    const std::string d = fmt::format("d{}", v);
    std::string sum = terms[i][0];
    for (std::size_t k = 1; k < terms[i].size(); ++k) sum += " + " + terms[i][k];
    text += fmt::format("  const F {} = {};\n", d, sum);
    if (in.code == Code::Coordinate) {
      g[in.index] = d;
    } else if (in.code == Code::Select) {
      add(in.b, fmt::format("SELECT({}, {}, (F)0)", name(in.a), d), true);
      add(in.c, fmt::format("SELECT({}, (F)0, {})", name(in.a), d), true);
    } else {
      const bool below = chosen[i] || in.code == Code::Min || in.code == Code::Max;
      for (const auto& [operand, p] : partials_of(program, v, precision)) {
        // What was not chosen has the adjoint 0, and may have a pole here: 0 times its partial derivative would be nan.
        const std::string product = fmt::format("{} * ({})", d, p);
        add(operand, p == "(F)1" ? d : p == "-(F)1" ? "-" + d : chosen[i] ? fmt::format("SELECT(EQ({}, (F)0), (F)0, {})", d, product) : product, below);
      }
    }
  }
  text += fmt::format("  *gx = {};\n  *gy = {};\n  *gz = {};\n  return {};\n}}\n", g[0], g[1], g[2], name(program.result));
  return {text, {}};
}

}  // namespace irt::program
