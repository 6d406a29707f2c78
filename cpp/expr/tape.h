// Evaluation on the host: a tape of operations over blocks of doubles.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "expr/expr.h"

namespace irt {

class Tape {
 public:
  explicit Tape(const Expr& e);

  // The symbols whose values `run` takes, sorted.
  const std::vector<std::string>& symbols() const { return symbols_; }

  // result[i] = e at (inputs[0][i], inputs[1][i], ...), in the order of symbols(); nan where e is undefined.
  void run(std::span<const double* const> inputs, double* result, std::size_t count) const;

 private:
  struct Step {
    Op op;
    std::vector<std::size_t> args;
    double value = 0;      // Number, Pi, E
    long exponent = 0;     // Pow by a small integer
    std::size_t input = 0; // Symbol
  };
  std::vector<Step> steps_;
  std::vector<std::string> symbols_;

  void block(const Step& step, std::vector<double>& values, std::size_t at, std::span<const double* const> inputs, std::size_t first,
             std::size_t n) const;
};

}  // namespace irt
