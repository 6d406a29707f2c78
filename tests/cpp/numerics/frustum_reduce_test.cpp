// Cells in fewer coefficients: what is lost is bounded, whatever is kept.
#include "numerics/frustum_reduce.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "numerics/frustum_cuts.h"

namespace irt::numerics {
namespace {

using Basis = void (*)(double, std::size_t, double*, double*);

// A tensor [down][depth][across], lines across `padded` apart.
double value(const std::vector<double>& c, std::size_t down, std::size_t depth, std::size_t across, std::size_t padded, Basis basis, const double* at) {
  std::vector<double> v(down), s(depth), u(across), slopes(std::max({down, depth, across}));
  basis(at[0], down, v.data(), slopes.data());
  bernstein_at(at[1], depth, s.data(), slopes.data());
  basis(at[2], across, u.data(), slopes.data());
  double sum = 0;
  for (std::size_t j = 0; j < down; ++j)
    for (std::size_t k = 0; k < depth; ++k)
      for (std::size_t i = 0; i < across; ++i) sum += v[j] * s[k] * u[i] * c[(j * depth + k) * padded + i];
  return sum;
}

TEST(Reduction, LosesNoMoreThanItSays) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> between(-1, 1);
  for (const int degree : {2, 5, 10, 16})
    for (const double roughness : {0.02, 0.4, 1.0}) {
      const std::size_t n = static_cast<std::size_t>(degree) + 1, m = (n + kLanes - 1) / kLanes * kLanes;
      std::vector<double> form(n * n * m, 0);
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t k = 0; k < n; ++k)
          for (std::size_t i = 0; i < m; ++i)
            form[(j * n + k) * m + i] = i < n ? (1 - roughness) * std::sin(0.1 * static_cast<double>(j + 2 * k) - 0.2 * static_cast<double>(i)) + roughness * between(random)
                                              : form[(j * n + k) * m + n - 1];
      for (const int depth : {1, degree / 2 + 1, degree})
        for (const double tolerance : {0.0, 1e-6, 1e-2}) {
          const Reduction reduction(degree, depth);
          Reduction::Reduced out;
          const bool done = reduction.run(form.data(), m, 2, tolerance, false, out);
          if (!done) {
            EXPECT_LT(depth, degree);
            ASSERT_TRUE(reduction.run(form.data(), m, 2, tolerance, true, out));
            EXPECT_GT(out.error, tolerance);
          }
          if (tolerance == 0) {
            EXPECT_EQ(out.down, n);
          }
          EXPECT_LE(out.down, n);
          EXPECT_LE(out.across, n);
          for (int trial = 0; trial < 20; ++trial) {
            const double at[] = {0.5 + 0.5 * between(random), 0.5 + 0.5 * between(random), 0.5 + 0.5 * between(random)};
            const double f = value(form, n, n, n, m, bernstein_at, at);
            const double q = value(out.values, out.down, static_cast<std::size_t>(depth) + 1, out.across, reduction.padded(), chebyshev_at, at);
            EXPECT_LE(std::fabs(f - q), out.error + 1e-13) << degree << " to " << depth;
            EXPECT_LE(std::fabs(q), out.weight * (1 + 1e-13));
          }
        }
    }
}

TEST(Reduction, DropsWhatASmoothFormDoesNotNeed) {
  // u across only, of degree 1 written in degree 9.
  const std::size_t n = 10, m = 12;
  std::vector<double> form(n * n * m);
  for (std::size_t line = 0; line < n * n; ++line)
    for (std::size_t i = 0; i < m; ++i) form[line * m + i] = static_cast<double>(std::min<std::size_t>(i, n - 1)) / 9;
  Reduction::Reduced out;
  ASSERT_TRUE(Reduction(9, 3).run(form.data(), m, 1, 1e-12, false, out));
  EXPECT_EQ(out.down, 1u);
  EXPECT_EQ(out.across, 2u);
  EXPECT_NEAR(out.values[0], 0.5, 1e-14);
  EXPECT_NEAR(out.values[1], 0.5, 1e-14);
}

TEST(Basis, SlopesAreThoseOfValues) {
  for (const Basis basis : {static_cast<Basis>(chebyshev_at), static_cast<Basis>(bernstein_at)})
    for (const std::size_t n : {2u, 7u}) {
      std::vector<double> a(n), b(n), slopes(n), unused(n);
      basis(0.3, n, a.data(), slopes.data());
      basis(0.3 + 1e-6, n, b.data(), unused.data());
      for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR((b[k] - a[k]) * 1e6, slopes[k], 1e-3);
    }
}

}  // namespace
}  // namespace irt::numerics
