// Nodes of expression trees, and the store that keeps each tree once.
#pragma once

#include <atomic>
#include <memory>

#include "expr/expr.h"

namespace irt {

struct Node {
  std::atomic<std::int64_t> references{0};
  Op op;
  bool total;            // defined for all values of its symbols
  bool constant;         // no symbols
  std::int64_t weight;   // how high a power it is, roughly: orders the terms of sums
  std::size_t hash;      // structural
  std::vector<Expr> args;
  std::unique_ptr<mpq_class> number;
  std::string name;
};

// Hash-consing: one node for equal trees, as long as any handle to it is alive.
class Store {
 public:
  static Expr number(const mpq_class& value);
  static Expr symbol(const std::string& name);
  static Expr make(Op op, std::vector<Expr> args);

  static void retain(const Node* node) noexcept;
  static void release(const Node* node) noexcept;

 private:
  static Expr intern(std::unique_ptr<Node> node);
};

}  // namespace irt
