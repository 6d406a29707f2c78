// Text of expressions: str parses back to the same tree; latex is for people.
#pragma once

#include <string>

#include "expr/expr.h"

namespace irt {

std::string to_string(const Expr& e);  // throws LimitError for trees that no one could read
std::string to_latex(const Expr& e);

}  // namespace irt
