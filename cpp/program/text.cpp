// Literals, templates and power chains for the emitters.
#include "program/text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace irt::program {

std::string literal(double v) {
  if (std::isinf(v)) return v > 0 ? "((real)INFINITY)" : "(-(real)INFINITY)";
  char text[64];
  if (v == std::floor(v) && std::fabs(v) < 1e6) {
    std::snprintf(text, sizeof text, "%.1f", v);
  } else {
    std::snprintf(text, sizeof text, "%a", v);
  }
  return text[0] == '-' ? fmt::format("(-R({}))", text + 1) : fmt::format("R({})", text);
}

double nearest(const numerics::Bounds& b, Precision precision) {
  const double middle = std::isinf(b.lo) ? b.lo : b.lo + 0.5 * (b.hi - b.lo);
  return precision == Precision::Single ? static_cast<double>(static_cast<float>(middle)) : middle;
}

numerics::Bounds outward(const numerics::Bounds& b, Precision precision) {
  if (precision == Precision::Double) return b;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float lo = static_cast<float>(b.lo), hi = static_cast<float>(b.hi);
  if (static_cast<double>(lo) > b.lo) lo = std::nextafterf(lo, -kInfinity);
  if (static_cast<double>(hi) < b.hi) hi = std::nextafterf(hi, kInfinity);
  // Values below the least normal real may be flushed by the device; zero and the least normal one enclose them.
  constexpr float kTiny = std::numeric_limits<float>::min();
  if (lo != 0 && std::fabs(lo) < kTiny) lo = lo > 0 ? 0.0f : -kTiny;
  if (hi != 0 && std::fabs(hi) < kTiny) hi = hi > 0 ? kTiny : 0.0f;
  return {lo, hi};
}

std::string fill(std::string_view pattern, const std::string& a, const std::string& b, const std::string& c,
                 const std::string& r, const std::string& v) {
  std::string out;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '$') {
      out += pattern[i];
      continue;
    }
    switch (pattern[++i]) {
      case 'a': out += a; break;
      case 'b': out += b; break;
      case 'c': out += c; break;
      case 'r': out += r; break;
      case 'v': out += v; break;
    }
  }
  return out;
}

std::string power_chain(const std::string& base, long n, const std::string& result) {
  std::string text, square = base, product;
  int count = 0;
  for (long rest = n;; ) {
    if (rest & 1) {
      if (product.empty()) {
        product = square;
      } else {
        const std::string next = fmt::format("{}_{}", result, count++);
        text += fmt::format("  const F {} = {} * {};\n", next, product, square);
        product = next;
      }
    }
    if ((rest >>= 1) == 0) break;
    const std::string next = fmt::format("{}_{}", result, count++);
    text += fmt::format("  const F {} = {} * {};\n", next, square, square);
    square = next;
  }
  return text + fmt::format("  const F {} = {};\n", result, product);
}

std::string power_function(long n) {
  return fmt::format("static inline F power_{0}(F a) {{\n{1}  return r;\n}}\n", n, power_chain("a", n, "r"));
}

bool in_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

std::string in_doubles(std::string_view text) {
  return renamed(text, [](std::string& out, std::string_view name) {
    out += name == "F" ? "FW" : name == "R" ? "FINE" : name == "sin" ? "FINE_SIN" : name == "cos" ? "FINE_COS" : name;
  });
}

std::set<std::string> taylor_functions(const Program& program, Precision precision) {
  std::set<std::string> functions;
  for (const Instruction& in : program.code) {
    if (in.code != Code::Polynomial) continue;
    std::string coefficients;
    const auto& polynomial = program.polynomials[static_cast<std::size_t>(in.index)];
    for (const auto& c : polynomial) coefficients += (coefficients.empty() ? "(F)" : ", (F)") + literal(nearest(c, precision));
    functions.insert(fmt::format("static inline TAYLOR taylor_{}(F c, F r) {{\n  F t[] = {{{}}};\n  return taylor_form(t, {}, c, r);\n}}\n", in.index,
                                 coefficients, polynomial.size() - 1));
  }
  return functions;
}

std::string coordinate(std::int64_t index) { return (index < 3 ? "" : "d") + std::string(1, "xyz"[index % 3]); }

std::string enclosure_head(const Program& program, const char* type) {
  const bool range = std::string_view(type) == "IA";
  if (program.derivative)
    return fmt::format("// The derivative of f along a piece of ray.\n"
                       "static inline IA irt_along({0} x, {0} y, {0} z, {0} dx, {0} dy, {0} dz PARAMETERS, I* undefined, I* rough) {{\n", type);
  return fmt::format("// {2}\nstatic inline {1} irt_{3}({0} x, {0} y, {0} z PARAMETERS, I* undefined, I* rough REGION_PARAMETERS) {{\n", type,
                     range ? "IA" : "FORM", range ? "Interval enclosure over a box." : "Affine enclosure over a piece of ray.", range ? "interval" : "affine");
}

std::string name(Value v, char prefix) { return fmt::format("{}{}", prefix, v); }
std::string mask(char kind, Value v) { return fmt::format("{}{}", kind, v); }

}  // namespace irt::program
