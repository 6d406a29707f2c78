// Polynomials along a ray: Bernstein coefficients straight from the formula, and their first roots, proven.
//
// A polynomial of degree d is kept as s_0 ... s_d with p(u) = sum s_i u^i (1 - u)^(d - i). Products are convolutions, and
// raising the degree multiplies by u + (1 - u): no step cancels more than the formula does. Roots are isolated by
// Descartes' rule of signs and de Casteljau's subdivision, in any of three arithmetics: intervals of doubles, fixed
// point of many bits with an error bound, exact rationals.
#pragma once

#include <gmpxx.h>

#include <functional>
#include <optional>
#include <vector>

#include "numerics/along.h"
#include "numerics/fixed.h"
#include "numerics/interval.h"

namespace irt::numerics {

enum class Kind : std::uint8_t { miss = 0, hit = 1, touch = 2, undecided = 3 };
enum class Arithmetic : std::uint8_t { none = 0, dbl = 1, fixed = 2, mpfr = 3, exact = 4 };

struct Root {
  Kind kind = Kind::undecided;
  double lo = 0, hi = 0;  // the bracket of a hit or touch, the open piece where undecided
  Arithmetic arithmetic = Arithmetic::none;
};

// The part of a ray that counts: it is entered within [enter_lo, enter_hi] and left within [leave_lo, leave_hi].
struct Clip {
  double enter_lo, enter_hi, leave_lo, leave_hi;
};

// Called now and then by what may take seconds for one ray; throws Stopped where nobody waits for it any more.
using Stop = std::function<void()>;
struct Stopped {};

// The formula as what Bernstein arithmetic needs; nothing where it is no polynomial of degree 1 to limits::kRayDegree in
// x, y, z.
class PolynomialPlan {
 public:
  static std::optional<PolynomialPlan> of(const Formula& formula);
  // The first root in the clip, wherever the arithmetic can prove it. Past an undecided piece nothing is looked at.
  Root first_root(const Ray& ray, const Clip& clip, const Stop& stop) const;

  // Bernstein coefficients of f over t in [t0, t1] of a ray.
  std::vector<Interval> coefficients(const Ray& ray, double t0, double t1) const;

  const Formula& formula() const { return *formula_; }
  int degree() const { return degree_.back(); }
  int degree(std::size_t step) const { return degree_[step]; }
  const Fixed& constant(std::size_t step) const { return in_fixed_[step]; }

 private:
  template <class T>
  std::vector<T> along(const Ray& ray, double t0, double t1, const std::vector<T>& constants, const Stop& stop) const;

  const Formula* formula_ = nullptr;
  std::vector<int> degree_;              // of each step of f
  bool rational_ = true;                 // all constants are
  std::vector<Interval> in_double_;      // constants, by step
  std::vector<Fixed> in_fixed_;
  std::vector<mpq_class> exact_;
};

// How narrow the bracket of a root at t is to be, on a range of that span: 1e-12 of |t|.
double wanted_width(double t, double span);

}  // namespace irt::numerics
