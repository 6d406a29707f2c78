// Cells of the frustum form in fewer coefficients (ours, not S2's): over a small tile and a short slab a polynomial of high degree hardly differs
// from one of low degree.
//
// A column of tiles goes over to Chebyshev polynomials across, the pencil of rays through a tile down as well, once for all its slabs; each cell loses the last of them,
// and along its depth becomes a Bernstein form of lower degree, by way of Chebyshev polynomials too. What is lost is bounded and counts as error: then f = q + r,
// |r| <= error, and where all that is known of q would hold for q + error and q - error as well, f has the sign of q, and its first zero lies in the bracket of q's.
#pragma once

#include <cstddef>
#include <vector>

#include "numerics/frustum_cuts.h"

namespace irt::numerics {

// Polynomials across that one down stands with: where they begin in a line, how many there are, and with zeros to whole vectors.
struct PencilRow {
  std::size_t begin, count, padded;
};

// A pencil: [depth] lines of width() values, Bernstein's basis along the depth. A line has for each polynomial down those across that the degree leaves: of
// a polynomial of degree n all products T_j T_i have i + j <= n. Behind them stands how far f may be from its net: [depth] lines of net_width() values, Bernstein's
// basis all ways, of the first few polynomials.
class Reduction {
 public:
  // Polynomials of `degree` >= 2, to `depth` <= degree along the depth.
  Reduction(int degree, int depth);
  std::size_t width() const { return width_ + kLanes; }
  std::size_t net_width() const { return side_ * net_lines_; }
  double beside(const double* line) const { return line[width_] * (1 + 1e-12); }

  // A strip is a column of tiles, or a part of it, with polynomials across: [down][depth][across], `plane` values down, Bernstein's basis that way and along
  // the depth. It is made of a form whose coefficients lie so far apart from line to line, down and then along the depth, and from one to the next in a line, none larger
  // than `largest`. Returns a bound of what that loses.
  struct Steps {
    std::size_t line, term;
  };
  struct Strip {
    double widest, steepest;  // the largest sum of sizes in a line; of what it changes by to the next one down, which halving the strip halves
  };
  std::size_t plane() const { return n_ * lines_; }
  double strip_of(const double* form, const Steps& steps, double largest, Strip& strip, double* values, Room& scratch) const;

  // The pencil of a strip as high as a tile, and its net, which will be halved up to so many times. `longest` becomes the largest sum of sizes in a line. Returns a bound
  // of what that loses.
  double pencil_of(const double* values, const Strip& strip, int cuts, double* pencil, double* net, double& longest, Room& scratch) const;

  struct Reduced {
    std::size_t down, across;  // polynomials that are left
    double error;              // what is lost, rounding included
    double weight;             // bounds sum |c| over a plane of equal depth
    const double* values;      // a pencil of depth + 1 lines
    Room scratch;
  };

  // Loses up to `tolerance` in each direction; false, and nothing done, where it would be more along the depth, unless it `must`.
  bool run(const double* pencil, double tolerance, bool must, Reduced& out) const;

  // [down][depth][across], times `scale`; writes up to kLanes values beyond the last.
  void pack(const Reduced& reduced, double scale, float* to) const;
  void pack(const Reduced& reduced, double scale, double* to) const;

 private:
  std::size_t n_, depth_, lines_, width_ = 0;  // coefficients in a line; lines_: n_ rounded up to whole vectors
  std::size_t side_, net_lines_;               // of a net
  std::vector<PencilRow> rows_;                // by polynomial down
  // Of sums and of differences of opposite lines, row by row.
  struct Halves {
    std::vector<double> even, odd;
  };
  Halves along_, down_;         // depth: what is kept, then what is lost; polynomials
  std::vector<double> across_;  // [step][polynomial]
  std::vector<double> net_;     // [polynomial][coefficient]
  double all_ = 0;              // sum of the sizes of the factors of steps in all polynomials
  double along_rounding_, net_rounding_, net_cut_rounding_;  // of sums along the depth, of a net's and of one halving of it, in parts of the largest line of a pencil
};

// Values and slopes of the first n Chebyshev polynomials T_k(2u - 1), and of Bernstein's of degree n - 1.
void chebyshev_at(double u, std::size_t n, double* values, double* slopes);
void bernstein_at(double u, std::size_t n, double* values, double* slopes);

}  // namespace irt::numerics
