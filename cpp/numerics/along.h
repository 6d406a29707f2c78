// f and its derivative along a ray, enclosed over pieces of it: in doubles, or with MPFR at any precision.
#pragma once

#include <glm/glm.hpp>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "expr/expr.h"
#include "numerics/interval.h"
#include "numerics/mpfr_interval.h"

namespace irt::numerics {

// f and its gradient as one list of steps, arguments before their users; f's come first.
class Formula {
 public:
  struct Step {
    Expr e;
    std::vector<std::uint32_t> args;
    long exponent = 0;    // of an integer power
    int axis = -1;        // 0, 1, 2 for x, y, z
    bool constant = true; // free of x, y, z
    Interval value;       // of a constant
  };

  // `parameters` has a value for each symbol besides x, y, z. Without its gradient f has values only. Throws ExpressionError,
  // ArgumentError, LimitError.
  Formula(const Expr& f, const std::map<std::string, double>& parameters, bool gradient = true);

  const std::vector<Step>& steps() const { return steps_; }
  std::uint32_t f() const { return f_; }
  const std::array<std::uint32_t, 3>& gradient() const { return gradient_; }
  double parameter(const std::string& name) const { return parameters_.at(name); }
  MpfrInterval constant(const Step& step, std::span<const MpfrInterval* const> args, mpfr_prec_t precision) const;

 private:
  std::vector<Step> steps_;
  std::uint32_t f_ = 0;
  std::array<std::uint32_t, 3> gradient_{};
  std::map<std::string, double> parameters_;
};

// The steps of a formula over intervals of the coordinates.
class Enclosures {
 public:
  explicit Enclosures(const Formula& formula);

  // The first `count` steps; at(axis): an interval of the coordinate.
  template <class At>
  void run(std::size_t count, const At& at) {
    for (std::size_t i = 0; i < count; ++i) {
      const Formula::Step& step = formula_.steps()[i];
      if (step.constant) continue;
      if (step.axis >= 0) {
        values_[i] = at(step.axis);
        continue;
      }
      args_.clear();
      for (const std::uint32_t k : step.args) args_.push_back(&values_[k]);
      values_[i] = apply(step.e.op(), step.exponent, args_);
    }
  }

  const Interval& operator[](std::size_t step) const { return values_[step]; }
  const Interval& f() const { return values_[formula_.f()]; }

 private:
  const Formula& formula_;
  std::vector<Interval> values_;
  std::vector<const Interval*> args_;
};

struct Ray {
  glm::dvec3 origin, direction;
};

// What is known of f on a piece of the ray.
struct Look {
  int sign = 0;         // of all values there, where they have one
  bool empty = false;   // f is defined nowhere
  bool doubtful = false; // not proven defined and continuous
  bool nonpositive = false;  // no value is above zero, by the range alone
  int slope = 0;        // sign of the derivative along the ray, where it has one
};

class Along {
 public:
  virtual ~Along() = default;
  virtual Look look(double a, double b) = 0;
  virtual int sign(double t) = 0;  // of f at t; 0 where it is not proven defined, or not proven other than zero
};

// How far along a ray single precision blurs zeros of f, an estimate: 2^29 times what double precision does, the width of f there over
// its slope. The median over the zeros on some lines through the box; nan where none of them meets one.
double single_blur(const Expr& f, const glm::dvec3& lower, const glm::dvec3& upper, const std::map<std::string, double>& parameters);

// One for each thread; `ray` may change between calls.
std::unique_ptr<Along> along_in_double(const Formula& formula, const Ray& ray);
std::unique_ptr<Along> along_in_mpfr(const Formula& formula, const Ray& ray, mpfr_prec_t precision);

}  // namespace irt::numerics
