// The frustum form (S2 section 3): a polynomial over a part of the view, in tensor Bernstein form, cut into cells.
//
// A cell is a tile of the screen and a slab of depth. Deviations from S2: the form is composed from the formula itself by
// Bernstein arithmetic (products are convolutions), not interpolated, so that factors stay factors and nothing cancels that
// need not; every coefficient carries a bound of its error; and it is cut by de Casteljau's algorithm into cells small
// enough for single precision, and for fewer coefficients (frustum_reduce.h). Cells whose coefficients have one sign are proven free of zeros and
// dropped.
#pragma once

#include <glm/glm.hpp>

#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

#include "numerics/ray_polynomial.h"

namespace irt::numerics {

// Positions middle + X right + Y up + s forward, X = sx spread, Y = sy spread, where spread is distance + s in perspective,
// 1 otherwise. sx and sy are linear across the screen, in tiles: sx = left + tile * across, sy = top + tile * down.
struct Frustum {
  glm::dvec3 middle, right, up, forward;
  glm::dvec3 middle_rest{0};  // what rounding to `middle` left over
  glm::dvec2 astray{0};       // how far rays may lie beside where they should, across and down, in tiles
  bool perspective = true;
  double distance = 0;
  long double left = 0, across = 0, top = 0, down = 0;
  int tile_x0 = 0, tile_x1 = 0, tile_y0 = 0, tile_y1 = 0;  // tiles that count
  double near = 0, far = 0;                                // s
  glm::dvec3 lower, upper;                                 // the box outside which nothing counts
  std::vector<glm::dvec4> balls;                           // and balls: centre, radius
  std::vector<glm::dvec4> half_spaces;                     // and half-spaces: normal, offset

  // Where sx, sy and s are.
  glm::dvec3 point(double sx, double sy, double s) const {
    const double spread = perspective ? distance + s : 1;
    return middle + sx * spread * right + sy * spread * up + s * forward;
  }

  // Tiles across and down that the form is made over: powers of two, so that all cuts are halvings and exact.
  int span_x() const { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(tile_x1 - tile_x0))); }
  int span_y() const { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(tile_y1 - tile_y0))); }
  // Of those that count, row by row.
  std::size_t tile_index(int x, int y) const { return static_cast<std::size_t>(y - tile_y0) * static_cast<std::size_t>(tile_x1 - tile_x0) + static_cast<std::size_t>(x - tile_x0); }
};

// f over span_x() x span_y() tiles from (tile_x0, tile_y0) and from near to far: Bernstein coefficients [across][down][depth] as sums
// hi + lo, a bound of the error of each, and of their sizes.
struct Whole {
  std::vector<double> hi, lo;
  double error = 0, largest = 0;
};

// Throws MethodError where the coefficients leave the range of doubles.
Whole compose(const PolynomialPlan& plan, const Frustum& frustum);

// The form over each column of tiles, which every pass of a frame cuts into its own cells.
class Columns {
 public:
  Columns(Whole whole, int degree, const Frustum& frustum);
  std::size_t count() const { return forms_.size(); }
  const Whole& form(std::size_t column) const { return forms_[column]; }  // from left to right
  int degree() const { return degree_; }

 private:
  void split(int x, int span, Whole form, const Frustum& frustum);

  int degree_;
  std::vector<Whole> forms_;
};

// Cells in the order of their tiles, each tile's from front to back.
struct Cells {
  struct Cell {
    double near, far;  // s
    double error;      // bounds that of any value along a ray, rounding to the kernel's reals and contraction included; values lie within [-2, 2]
    std::int32_t down, across;  // lines of coefficients, and how many there are in each
    std::int32_t begin;         // in steps of kCellStep reals
    // Demand::exact: of the form in doubles.
    double exact_error = 0;
    std::int32_t exact_down = 0, exact_across = 0, exact_begin = 0;
  };
  std::vector<std::int32_t> begins;  // of each tile in `cells`, row by row, and the end
  std::vector<Cell> cells;
};

constexpr std::size_t kCellStep = 16;
constexpr std::size_t kBehind = 512;  // bytes of the block behind any coefficient: kernels load whole vectors

constexpr int kMostDepthCuts = 8;  // halvings of [near, far]

// What kernels take: half an ulp of their reals, the width of depth that is asked for, the degree along the depth; whether cells are reduced: then
// they have Chebyshev polynomials across and down, else Bernstein's; whether each is wanted in doubles as well, with the degree along the depth that f has, and to
// which width roots are refined by these; and the tiles that are asked for, row by row, where it is not all of them.
struct Demand {
  double unit, eps;
  int depth;
  bool reduced;
  bool exact = false;
  double exact_eps = 0;
  int exact_depth = 0;  // degree along the depth of cells in doubles; that of the polynomial where they are not reduced
  const std::vector<bool>* tiles = nullptr;
  bool few = false;  // whether few pixels are: then cells are longer

  bool single() const { return unit > 0x1p-53; }
};

// The cells of f over the frustum, [down][depth][across]. `room` is asked for a block of so many bytes for their coefficients, and at times for another, which takes
// its place while the first is still there; `exact_room` for those in doubles.
using Space = std::function<void*(std::size_t)>;
Cells cells_of(const Columns& columns, const Frustum& frustum, const Demand& demand, const Space& room, const Space& exact_room = {});

}  // namespace irt::numerics
