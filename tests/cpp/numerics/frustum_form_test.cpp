// Cells of the frustum form: what they say of f has its sign, and no first zero of a ray lies outside them.
#include "numerics/frustum_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "expr/calculus.h"
#include "expr/parse.h"
#include "expr/tape.h"
#include "tensor.h"

namespace irt::numerics {
namespace {

// Three by three tiles, of which four by four are made.
Frustum frustum_of(bool perspective) {
  Frustum f;
  f.middle = {0.1, -0.05, 0};
  f.forward = glm::normalize(glm::dvec3(-0.3, 0.2, -1));
  f.right = glm::normalize(glm::cross(f.forward, glm::dvec3(0, 1, 0)));
  f.up = glm::cross(f.right, f.forward);
  f.perspective = perspective;
  f.distance = 4;
  const double half = perspective ? 0.35 : 1.3;
  f.left = -half;
  f.across = 2 * half / 3;
  f.top = half;
  f.down = -2 * half / 3;
  f.tile_x1 = f.tile_y1 = 3;
  f.near = -1.5;
  f.far = 1.5;
  f.lower = glm::dvec3(-20);
  f.upper = glm::dvec3(20);
  return f;
}

struct Case {
  const char* formula;
  bool perspective;
  double unit;
  int depth;  // 0: the degree
  bool reduced, exact;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.formula << (c.perspective ? ", perspective" : "") << (c.unit > 0x1p-53 ? ", floats" : ", doubles") << (c.reduced ? ", reduced" : "") << (c.exact ? ", exact" : "");
}

class CellsOf : public testing::TestWithParam<Case> {};

TEST_P(CellsOf, HaveTheSignsOfTheFormulaAndItsFirstZeros) {
  const Case& c = GetParam();
  const Expr e = parse(c.formula);
  const Formula formula(nested(e), {}, false);
  const auto plan = PolynomialPlan::of(formula);
  ASSERT_TRUE(plan);
  const Frustum frustum = frustum_of(c.perspective);
  const Columns columns(compose(*plan, frustum), plan->degree(), frustum);
  Demand demand{c.unit, 1e-3, c.depth ? c.depth : plan->degree(), c.reduced};
  demand.exact = c.exact;
  demand.exact_eps = 1e-9;
  demand.exact_depth = plan->degree() - (c.depth ? 1 : 0);
  // Each block as large as was asked for, so that what is written or read beyond is noticed.
  std::vector<std::vector<std::byte>> form, exact;
  const auto room = [](std::vector<std::vector<std::byte>>& blocks) { return [&blocks](std::size_t bytes) { return static_cast<void*>(blocks.emplace_back(bytes).data()); }; };
  const Cells cells = cells_of(columns, frustum, demand, room(form), room(exact));
  const std::size_t depth = static_cast<std::size_t>(demand.depth) + 1, exact_depth = static_cast<std::size_t>(demand.exact_depth) + 1;
  const Basis basis = c.reduced ? chebyshev_at : bernstein_at;
  const Tape tape(e);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  int inside = 0, zeros = 0;
  for (int ray = 0; ray < 300; ++ray) {
    const int tile_x = ray % 3, tile_y = ray / 3 % 3;
    const double u = unit(random), v = unit(random);
    const auto sx = static_cast<double>(frustum.left + (tile_x + u) * frustum.across), sy = static_cast<double>(frustum.top + (tile_y + v) * frustum.down);
    const std::size_t tile = frustum.tile_index(tile_x, tile_y);
    double before = 0;
    bool before_inside = false;
    for (int k = 0; k <= 400; ++k) {
      const double s = frustum.near + (frustum.far - frustum.near) * k / 400;
      const glm::dvec3 p = frustum.point(sx, sy, s);
      const std::vector<const double*> inputs = {&p.x, &p.y, &p.z};
      double truth = 0;
      tape.run(inputs, &truth, 1);
      bool here = false;
      for (std::int32_t m = cells.begins[tile]; m < cells.begins[tile + 1]; ++m) {
        const Cells::Cell& cell = cells.cells[m];
        if (s < cell.near || s > cell.far) continue;
        here = true;
        ++inside;
        const double at[] = {v, (s - cell.near) / (cell.far - cell.near), u};
        const std::size_t step = kCellStep;
        const double told = demand.single()
                                ? value(reinterpret_cast<const float*>(form.back().data()) + cell.begin * step, cell.down, depth, cell.across, cell.across, basis, at)
                                : value(reinterpret_cast<const double*>(form.back().data()) + cell.begin * step, cell.down, depth, cell.across, cell.across, basis, at);
        EXPECT_LE(std::fabs(told), 2.1);
        const bool known = std::fabs(truth) > 1e-10;  // beyond the rounding of the tape
        EXPECT_TRUE(!known || std::fabs(told) <= cell.error || (told > 0) == (truth > 0)) << c.formula << " " << s;
        if (!c.exact) continue;
        const double more = value(reinterpret_cast<const double*>(exact.back().data()) + cell.exact_begin * step, cell.exact_down, exact_depth, cell.exact_across, cell.exact_across, basis, at);
        EXPECT_LE(std::fabs(told - more), cell.error + cell.exact_error);
        EXPECT_TRUE(!known || std::fabs(more) <= cell.exact_error || (more > 0) == (truth > 0)) << c.formula << " " << s;
      }
      if (k > 0 && (before > 0) != (truth > 0)) {
        // The first zero of the ray lies here, in a cell. What comes behind it nobody sees.
        EXPECT_TRUE(here || before_inside) << c.formula << " " << s;
        ++zeros;
        break;
      }
      before = truth;
      before_inside = here;
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(zeros, 30);
}

constexpr const char* kQuartic = "x^4 + y^4 + z^4 - 2*x^2 + x*y*z - 0.1";
// With a gap, and with zeros close together.
constexpr const char* kOctic = "(x^2 + y^2 + z^2 - 0.9)*(x^2 + y^2 + z^2 - 0.4)*(x^4 + y^4 + z^4 - 0.3*x*y + 0.2)";
// Chebyshev's, so that much happens in a tile, and values far from zeros are large.
constexpr const char* kDegreeTen = "512*x^10 - 1280*x^8 + 1120*x^6 - 400*x^4 + 50*x^2 - 1 + 512*y^10 - 1280*y^8 + 1120*y^6 - 400*y^4 + 50*y^2 - 1 + z^3 - z/2";
// Small wherever it is zero, so that double is not enough for some tiles.
constexpr const char* kDecocube =
    "((x^2 + y^2 - 0.64)^2 + (z^2 - 1)^2)*((y^2 + z^2 - 0.64)^2 + (x^2 - 1)^2)*((z^2 + x^2 - 0.64)^2 + (y^2 - 1)^2) - 0.02";
constexpr double kFloat = 0x1p-24, kDouble = 0x1p-53;

INSTANTIATE_TEST_SUITE_P(Forms, CellsOf,
                         testing::Values(Case{kQuartic, true, kFloat, 0, false, false}, Case{kQuartic, false, kFloat, 0, false, true}, Case{kQuartic, true, kDouble, 0, false, false},
                                         Case{kOctic, true, kFloat, 0, true, false}, Case{kOctic, false, kFloat, 0, true, true}, Case{kOctic, true, kDouble, 0, false, false},
                                         Case{kDegreeTen, true, kFloat, 7, true, false}, Case{kDegreeTen, false, kFloat, 7, true, true}, Case{kDegreeTen, true, kFloat, 10, true, true}, Case{kDecocube, true, kFloat, 7, true, false}, Case{kDecocube, false, kFloat, 7, true, true}));

}  // namespace
}  // namespace irt::numerics
