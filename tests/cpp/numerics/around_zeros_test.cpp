// Boxes around zeros: nothing that is cut off has one, and what can be cut off is.
#include "numerics/around_zeros.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "expr/parse.h"
#include "numerics/values.h"

namespace irt::numerics {
namespace {

Box around(const char* formula, const Box& box, const std::map<std::string, double>& parameters = {}) {
  return around_zeros(parse(formula), parameters, box);
}

const Box kCube{glm::dvec3(-2), glm::dvec3(2)};

struct Case {
  const char* formula;
  Box box, most;  // what may be left
};

class AroundZeros : public testing::TestWithParam<Case> {};

TEST_P(AroundZeros, CutsOffWhatIsFreeOfZeros) {
  const auto& [formula, box, most] = GetParam();
  const Box left = around(formula, box);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LE(box.lower[k], left.lower[k]);
    EXPECT_LE(most.lower[k], left.lower[k]);
    EXPECT_LT(left.lower[k], left.upper[k]);
    EXPECT_LE(left.upper[k], most.upper[k]);
    EXPECT_LE(left.upper[k], box.upper[k]);
  }
}

// Of what is cut off on one side f has the sign that it has on that face, wherever it has a value.
TEST_P(AroundZeros, KeepsAllZeros) {
  const auto& [formula, box, most] = GetParam();
  const Box left = around(formula, box);
  std::mt19937_64 random(1);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool above : {false, true}) {
      Box slab = box;
      (above ? slab.lower : slab.upper)[axis] = (above ? left.upper : left.lower)[axis];
      if (slab.lower[axis] >= slab.upper[axis]) continue;
      std::vector<std::array<double, 3>> points;
      for (int n = 0; n < 200; ++n) {
        std::array<double, 3> p;
        for (int k = 0; k < 3; ++k) {
          const double share = n % 4 == k ? 0.5 * static_cast<double>(random() % 3) : std::uniform_real_distribution<double>(0, 1)(random);
          p[k] = slab.lower[k] + share * (slab.upper[k] - slab.lower[k]);
        }
        points.push_back(p);
      }
      int sign = 0;
      for (const auto& [lo, hi] : values_at(parse(formula), points)) {
        if (std::isnan(lo)) continue;
        const int here = lo > 0 ? 1 : hi < 0 ? -1 : 0;
        ASSERT_NE(here, 0) << formula << " " << axis << above;
        ASSERT_GE(here * sign, 0) << formula << " " << axis << above;
        sign = here;
      }
    }
}

Box cube(double half) { return {glm::dvec3(-half), glm::dvec3(half)}; }

INSTANTIATE_TEST_SUITE_P(
    Formulas, AroundZeros,
    testing::Values(Case{"x^2 + y^2 + z^2 - 1", kCube, cube(1.003)}, Case{"x^200 + y^200 + z^200 - 1", kCube, cube(1.003)},
                    Case{"exp(-4*(x^2 + y^2 + z^2)) - 1/2", kCube, cube(0.43)},
                    Case{"max(abs(x), max(abs(y), abs(z))) - 1", kCube, cube(1.003)},
                    // A face of the box, an edge, and no zero at all.
                    Case{"x - 2", kCube, {{1.74, -2, -2}, {2, 2, 2}}}, Case{"(x - 1/3)^2 + (y + 1/3)^2", kCube, {{0.3, -0.4, -2}, {0.5, -0.15, 2}}},
                    Case{"x^2 + y^2 + z^2 + 1", kCube, kCube},
                    // Nowhere defined on one side.
                    Case{"sqrt(x - 1) - y", kCube, {{0.99, -0.01, -2}, {2, 1.01, 2}}}, Case{"log(z) + x + 1", kCube, {{-2, -2, 0}, {2, 2, 2}}},
                    // Poles and jumps.
                    Case{"1/x - y", kCube, kCube}, Case{"floor(x) + 1/2 + y/8", kCube, {{-2, -2, -2}, {2, 2, 2}}},
                    // Far from the origin, and where doubles are few.
                    Case{"x - 1000000000", {{999999999, -1, -1}, {1000000001, 1, 1}}, {{999999999.9, -1, -1}, {1000000000.1, 1, 1}}},
                    Case{"x - 1/3", {{1e9, 0, 0}, {1000000000.000001, 1, 1}}, {{1e9, 0, 0}, {1000000000.000001, 1, 1}}},
                    Case{"x^2 - y", {{-1e-300, -1e-300, -1}, {1e-300, 1e-300, 1}}, {{-1e-300, -1e-300, -1}, {1e-300, 1e-300, 1}}},
                    Case{"x*y*z - 1", cube(1e300), cube(1e300)}),
    [](const auto& info) { return "f" + std::to_string(info.index); });

TEST(AroundZerosOfParameters, TakesTheirValues) {
  const Box left = around("x^2 + y^2 + z^2 - r", kCube, {{"r", 0.25}});
  EXPECT_LT(left.upper.x, 0.503);
  EXPECT_GT(left.upper.x, 0.5);
}

}  // namespace
}  // namespace irt::numerics
