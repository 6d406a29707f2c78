// Canonical construction: what Python's operators and the parser call.
//
// As in SymPy, arguments of sums and products are sorted, like terms and equal factors collected, rational numbers folded; unlike it, nothing
// changes where the function is defined (x/x and sqrt(x)**2 stay), and factored forms, even powers and irrational numbers are kept.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "expr/expr.h"

namespace irt {

Expr number(const mpq_class& value);        // throws LimitError past limits::kNumberBits
Expr from_double(double value);             // exactly; throws ExpressionError unless finite
Expr symbol(const std::string& name);       // throws ExpressionError unless an identifier
bool is_identifier(const std::string& name);

Expr add(std::span<const Expr> terms);
Expr mul(std::span<const Expr> factors);
Expr pow(const Expr& base, const Expr& exponent);

inline Expr add(const Expr& a, const Expr& b) { const Expr t[] = {a, b}; return add(t); }
inline Expr mul(const Expr& a, const Expr& b) { const Expr t[] = {a, b}; return mul(t); }
inline Expr neg(const Expr& a) { return mul(Expr(-1L), a); }
inline Expr sub(const Expr& a, const Expr& b) { return add(a, neg(b)); }
inline Expr div(const Expr& a, const Expr& b) { return mul(a, pow(b, Expr(-1L))); }
Expr sqrt(const Expr& a);

// Any operator from its arguments, in canonical form: functions, Min, Max, Mod, Piecewise (value, condition, ...),
// conditions, Add, Mul and Pow. Throws ExpressionError for a wrong number or kind of arguments.
Expr call(Op op, std::span<const Expr> args);

// The number in front of a product and the rest of it: 3 x y is 3 and x y; x is 1 and x.
std::pair<mpq_class, Expr> split_coefficient(const Expr& e);

// The order of arguments; the same in every process.
int compare(const Expr& a, const Expr& b);

// Names of functions as parse and str write them; nothing for operators that have none.
struct FunctionName {
  const char* name;
  Op op;
  int arity;  // -1: one or more
};
std::span<const FunctionName> functions();
const char* function_name(Op op);

// Visits every distinct sub-tree once, arguments before their users; never recursive.
std::vector<Expr> postorder(const Expr& root);

// The whole number at or above zero that it is, where it is one that a long holds.
std::optional<long> natural(const Expr& e);

// The number of distinct sub-trees. Throws LimitError past limits::kNodes.
std::size_t count_nodes(const Expr& root);

}  // namespace irt
