// Formulas as one fraction, so that a pole can be told from a root: f has its zeros among those of the numerator.
#pragma once

#include <optional>

#include "expr/expr.h"

namespace irt {

struct Fraction {
  Expr numerator, denominator;
};

// e as numerator / denominator, where divisors that may vanish with x, y, z are brought together; tan counts as sin / cos. Wherever
// e is defined the denominator is not zero and the quotient is e. Nothing where there is no such divisor in reach of +, * and whole
// powers, or where the numerator would be much larger than e.
std::optional<Fraction> fraction(const Expr& e);

}  // namespace irt
