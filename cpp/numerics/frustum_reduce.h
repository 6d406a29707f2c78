// Cells of the frustum form in fewer coefficients (ours, not S2's): over a small tile and a short slab a polynomial of high degree hardly differs
// from one of low degree.
//
// Across and down a cell goes over to Chebyshev polynomials and loses the last of them; along its depth it becomes a Bernstein form of lower degree, by
// way of Chebyshev polynomials too. What is lost is bounded and counts as error: then f = q + r, |r| <= error, and where all that is known of q
// would hold for q + error and q - error as well, f has the sign of q, and its first zero lies in the bracket of q's.
#pragma once

#include <cstddef>
#include <vector>

#include "numerics/frustum_cuts.h"

namespace irt::numerics {

class Reduction {
 public:
  // From `degree` along each axis to `depth` <= degree along the depth.
  Reduction(int degree, int depth);

  struct Reduced {
    std::size_t down, across;  // polynomials that are left
    double error;              // what is lost, rounding included
    double weight;             // bounds sum |c| over a plane of equal depth
    std::vector<double> values;  // [down][depth][across], lines padded() apart
    Room scratch;
  };

  // `form`: [down][depth][across], lines across `padded` apart, none larger than `largest`. Loses up to `tolerance` in each direction;
  // false, and nothing done, where it would be more along the depth, unless it `must`.
  bool run(const double* form, std::size_t padded, double largest, double tolerance, bool must, Reduced& out) const;
  std::size_t padded() const { return lines_; }

 private:
  std::size_t n_, depth_, lines_;             // coefficients in a line; lines_: n_ rounded up to whole vectors
  // Of sums and of differences of opposite lines, row by row.
  struct Halves {
    std::vector<double> even, odd;
  };
  Halves along_, down_;         // depth: what is kept, then what is lost; polynomials
  std::vector<double> across_;  // [coefficient][polynomial]
  double rounding_;             // of all sums, in parts of the largest coefficient
};

// Values and slopes of the first n Chebyshev polynomials T_k(2u - 1), and of Bernstein's of degree n - 1.
void chebyshev_at(double u, std::size_t n, double* values, double* slopes);
void bernstein_at(double u, std::size_t n, double* values, double* slopes);

}  // namespace irt::numerics
