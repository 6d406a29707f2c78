// Rigorous bounds of expressions without symbols (sqrt(5), 1 + pi/3, ...): how irrational constants reach kernels.
#pragma once

#include "expr/expr.h"

namespace irt::numerics {

struct Bounds {
  double lo, hi;  // lo <= value <= hi
};

// The tightest pair of doubles around the value of `e`: lo == hi where it is a double, adjacent doubles otherwise.
// Throws ExpressionError where `e` has symbols, or no value (log(-1), 1/0).
Bounds enclose_constant(const Expr& e);

}  // namespace irt::numerics
