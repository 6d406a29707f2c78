// Halvings in registers and in memory: de Casteljau's algorithm, bit for bit, whatever the number of coefficients.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "numerics/frustum_cuts.h"

namespace irt::numerics {
namespace {

TEST(Halve, IsDeCasteljausAlgorithm) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-3, 3);
  for (std::size_t n = 2; n <= 33; ++n) {
    const std::size_t width = 2 * kLanes;
    std::vector<double> first(2 * n * width), second(first.size());
    for (double& v : first) v = any(random);
    std::vector<double> left = first, right = first;
    for (std::size_t run = 0; run < 2; ++run)
      for (std::size_t m = 0; m < width; ++m) {
        std::vector<double> c(n);
        for (std::size_t i = 0; i < n; ++i) c[i] = first[run * n * width + i * width + m];
        for (std::size_t i = 0; i < n; ++i) {
          left[run * n * width + i * width + m] = c[0];
          right[run * n * width + (n - 1 - i) * width + m] = c[n - 1 - i];
          for (std::size_t k = 0; k + 1 < n - i; ++k) c[k] = 0.5 * (c[k] + c[k + 1]);
        }
      }
    std::vector<double> unseen = first, behind(first.size());
    halve_unseen(unseen.data(), behind.data(), {n, width, width, 2, n * width});
    EXPECT_EQ(unseen, left) << n;
    EXPECT_EQ(behind, right) << n;
    const Halves halves = halve(first.data(), second.data(), {n, width, width, 2, n * width});
    EXPECT_EQ(first, left) << n;
    EXPECT_EQ(second, right) << n;
    EXPECT_EQ(halves.first.lowest, *std::min_element(left.begin(), left.end())) << n;
    EXPECT_EQ(halves.first.highest, *std::max_element(left.begin(), left.end())) << n;
    EXPECT_EQ(halves.second.lowest, *std::min_element(right.begin(), right.end())) << n;
    EXPECT_EQ(halves.second.highest, *std::max_element(right.begin(), right.end())) << n;
  }
}

TEST(Steps, GoFromLineToLine) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> any(-3, 3);
  const std::size_t n = 5, width = 2 * kLanes;
  std::vector<double> values(3 * n * width);
  for (double& v : values) v = any(random);
  double least = HUGE_VAL, most = -HUGE_VAL, slowest = HUGE_VAL;
  std::vector<int> changes(3 * width, 0);
  for (std::size_t run = 0; run < 3; ++run)
    for (std::size_t i = 1; i < n; ++i)
      for (std::size_t m = 0; m < width; ++m) {
        const double a = values[(run * n + i - 1) * width + m], b = values[(run * n + i) * width + m];
        least = std::min(least, b - a);
        most = std::max(most, b - a);
        if ((a < 0) == (b < 0)) continue;
        slowest = std::min(slowest, std::fabs(b - a));
        ++changes[run * width + m];
      }
  const Runs runs{n, width, width, 3, n * width};
  EXPECT_EQ(steps_of(values.data(), runs).lowest, least);
  EXPECT_EQ(steps_of(values.data(), runs).highest, most);
  EXPECT_EQ(slowest_change(values.data(), runs), slowest);
  const auto winds = std::count_if(changes.begin(), changes.end(), [](int times) { return times > 1; });
  EXPECT_GT(winds, 0);
  EXPECT_LT(winds, static_cast<std::ptrdiff_t>(changes.size()));
  EXPECT_EQ(winding(values.data(), runs), static_cast<std::size_t>(winds));
}

TEST(Pack, WritesLinesOneBehindTheOther) {
  for (const std::size_t n : {3, 4, 7, 11}) {
    const std::size_t m = (n + kLanes - 1) / kLanes * kLanes, lines = 5;
    std::vector<double> from(lines * m, 99), wide(lines * n + kLanes);
    std::vector<float> narrow(wide.size());
    for (std::size_t line = 0; line < lines; ++line)
      for (std::size_t i = 0; i < n; ++i) from[line * m + i] = static_cast<double>(line * n + i);
    pack(from.data(), lines, n, m, 0.5, wide.data());
    pack(from.data(), lines, n, m, 0.5, narrow.data());
    for (std::size_t i = 0; i < lines * n; ++i) {
      EXPECT_EQ(wide[i], 0.5 * static_cast<double>(i));
      EXPECT_EQ(narrow[i], 0.5F * static_cast<float>(i));
    }
  }
}

}  // namespace
}  // namespace irt::numerics
