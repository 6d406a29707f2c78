// Formulas from text. The grammar (^ and ** right-associative and closer than unary minus; juxtaposition multiplies as
// strongly as *; one = makes lhs - rhs):
//
//   formula    = condition ["=" sum]
//   condition  = sum [("<" | "<=" | ">" | ">=" | "==" | "!=") sum]
//   sum        = product {("+" | "-") product}
//   product    = unary {("*" | "/" | "") unary}
//   unary      = {"+" | "-"} power
//   power      = atom {"²" | "³"} [("^" | "**") unary]
//   atom       = number | name | name "(" arguments ")" | "(" condition ")" | "√" atom
#pragma once

#include <string>

#include "expr/expr.h"

namespace irt {

// Throws ExpressionError with the column (counted in characters from 1), LimitError past limits::kParseDepth.
Expr parse(const std::string& text);

}  // namespace irt
