// Which part of a box holds all zeros of a formula, found on the host before any ray is traced.
#pragma once

#include <glm/glm.hpp>

#include <map>
#include <string>

#include "expr/expr.h"

namespace irt::numerics {

struct Box {
  glm::dvec3 lower, upper;
};

// The box, less what can be cut off from each side because f is proven free of zeros there, in doubles and with a few hundred values; formulas of more than 250
// parts are not looked at. A little room is left round the zeros, and at least a sixteenth of each side. `parameters` has a value for each symbol besides x, y, z.
// Throws as Formula does.
Box around_zeros(const Expr& f, const std::map<std::string, double>& parameters, const Box& box);

}  // namespace irt::numerics
