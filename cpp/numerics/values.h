// Rigorous values of a formula at points: what the enclosures of kernels are judged by.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "expr/expr.h"

namespace irt::numerics {

// For each point (x, y, z) the doubles around f there: equal where f is a double, adjacent where it lies between two;
// wider where 4096 bits cannot tell; nan, nan where f has no value. Ends may be infinite, points may not.
// Throws ExpressionError where f has other symbols than x, y, z.
std::vector<std::array<double, 2>> values_at(const Expr& f, std::span<const std::array<double, 3>> points);

}  // namespace irt::numerics
