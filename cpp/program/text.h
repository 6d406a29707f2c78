// Pieces of text that all emitters share.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "program/emit.h"

namespace irt::program {

// A real literal that reads back as exactly v (v is representable in the precision of the kernel).
std::string literal(double v);

// The nearest real of the precision, and the two around an enclosure.
double nearest(const numerics::Bounds& b, Precision precision);
numerics::Bounds outward(const numerics::Bounds& b, Precision precision);

// Replaces $a $b $c $r $v.
std::string fill(std::string_view pattern, const std::string& a, const std::string& b, const std::string& c,
                 const std::string& r, const std::string& v = {});

// Statements that compute base ** n into `result` by squaring and multiplying; names are prefixed by `result`.
std::string power_chain(const std::string& base, long n, const std::string& result);

// "static inline F power_<n>(F a) { ... }"
std::string power_function(long n);

// For each polynomial that is used, "static inline TAYLOR taylor_<index>(F c, F r) { ... }" (kernels/polynomial.cl).
std::set<std::string> taylor_functions(const Program& program, Precision precision);

// Whether c may stand in a name.
bool in_name(char c);

// The text with another name for each: append(out, name).
template <class Append>
std::string renamed(std::string_view text, const Append& append) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at;
    while (end < text.size() && in_name(text[end])) ++end;
    if (end > at) append(out, text.substr(at, end - at));
    for (at = end; at < text.size() && !in_name(text[at]); ++at) out += text[at];
  }
  return out;
}

// "x" to "z" and "dx" to "dz".
std::string coordinate(std::int64_t index);

// The head of the function that encloses the program's result, values being `type` (IA or RA).
std::string enclosure_head(const Program& program, const char* type);

// The name of a value in generated code, "v12"; "q12" is its range where forms and ranges stand side by side.
std::string name(Value v, char prefix = 'v');
std::string mask(char kind, Value v);

// Statements that compute the value of v at a point, and with `derivative` what its partial derivatives need.
std::string point_statement(const Program& program, Value v, Precision precision, bool derivative);

// static inline F function(F x, F y, F z PARAMETERS) { ... }: the value of `result` at a point.
std::string value_function(const Program& program, Value result, const char* function, Precision precision);

// The same text for packets of doubles in kernels of floats: FW for F, FINE for R, FINE_SIN and FINE_COS (kernels/interval_trigonometric.cl).
std::string in_doubles(std::string_view text);

// The partial derivatives of v by its operands, as text; not those of Code::Select.
std::vector<std::pair<Value, std::string>> partials_of(const Program& program, Value v, Precision precision);

// The interval of v from those of its operands, for every operator that has no masks and is no condition. Notes the powers
// whose functions it calls.
std::string interval_rule(const Program& program, Value v, const std::string& a, const std::string& b, Precision precision,
                          std::set<long>& powers);

}  // namespace irt::program
