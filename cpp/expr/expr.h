// Immutable, hash-consed expression trees: the one representation of formulas in the library.
//
// Equal trees are the same object (structural == is pointer equality), sub-trees are shared, and trees are
// destroyed iteratively, so depth never overflows the stack. Handles are thread-safe to copy and drop.
#pragma once

#include <gmpxx.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace irt {

// What a node is. Subtraction, division and sqrt are Add, Mul and Pow as in SymPy:
// a - b = Add(a, Mul(-1, b)), a / b = Mul(a, Pow(b, -1)), sqrt(a) = Pow(a, 1/2).
enum class Op : std::uint8_t {
  Number,  // exact rational
  Pi,
  E,
  Symbol,
  Add,  // two or more arguments
  Mul,  // two or more arguments
  Pow,  // base, exponent
  Sin,
  Cos,
  Tan,
  Asin,
  Acos,
  Atan,
  Atan2,  // y, x
  Sinh,
  Cosh,
  Tanh,
  Exp,
  Log,
  Cbrt,  // real cube root
  Abs,
  Sign,
  Floor,
  Ceiling,
  Min,        // two or more arguments
  Max,        // two or more arguments
  Mod,        // sign of the divisor
  Piecewise,  // value, condition, value, condition, ...; the last condition may be True
  // Conditions; they stand only inside Piecewise and one another.
  Less,       // a < b  (a > b is stored as b < a)
  LessEqual,  // a <= b
  Equal,
  Unequal,
  And,
  Or,
  Not,
  True,
  False,
};

struct Node;  // expr/node.h

class Expr {
 public:
  Expr();  // the number 0
  Expr(long value);
  Expr(const Expr& other) noexcept;
  Expr(Expr&& other) noexcept;
  Expr& operator=(const Expr& other) noexcept;
  Expr& operator=(Expr&& other) noexcept;
  ~Expr();

  Op op() const noexcept;
  std::size_t arity() const noexcept;
  const Expr& arg(std::size_t i) const noexcept;
  std::span<const Expr> args() const noexcept;
  const mpq_class& number() const noexcept;   // op() == Op::Number
  const std::string& name() const noexcept;   // op() == Op::Symbol
  bool is_condition() const noexcept;         // op() >= Op::Less
  // Equal for equal trees and only for them, as long as a handle to one is alive.
  const Node* key() const noexcept { return node_; }
  std::size_t hash() const noexcept;          // structural, the same in every process

  friend bool operator==(const Expr& a, const Expr& b) noexcept { return a.node_ == b.node_; }

 private:
  friend class Store;
  explicit Expr(const Node* node) noexcept : node_(node) {}
  const Node* node_;
};

}  // namespace irt
