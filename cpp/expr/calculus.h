// Substitution, differentiation and rewriting. All walks are iterative and visit each shared part once.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "expr/expr.h"

namespace irt {

// The names of the symbols in e.
std::set<std::string> free_symbols(const Expr& e);

// Replaces all the pairs' left sides by their right sides, at once. Throws ExpressionError where that makes undefined what is needed.
Expr substitute(const Expr& e, const std::vector<std::pair<Expr, Expr>>& pairs);

// The derivative with respect to a symbol. Abs, Min, Max and Piecewise are differentiated branch by branch, jumps ignored.
Expr differentiate(const Expr& e, const std::string& symbol);

// Products of sums and whole powers of sums multiplied out; what would become an undefined constant stays as it is. Throws LimitError past limits::kExpandTerms.
Expr expand(const Expr& e);

// The same function, sums of monomials in x, y, z nested as in Horner's rule: fewer products, and no less exact.
Expr nested(const Expr& e);

// Smaller where that is sound: never changes the function or where it is defined, keeps factored form and even powers.
Expr simplify(const Expr& e);

// Total degree in x, y, z, found without expanding (cancellation aside, for which factors are expanded where they are
// small enough); nothing where e is no polynomial.
std::optional<long> degree(const Expr& e);

}  // namespace irt
