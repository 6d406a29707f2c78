// Cells in fewer coefficients: what is lost is bounded, whatever is kept.
#include "numerics/frustum_reduce.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "numerics/frustum_cuts.h"
#include "tensor.h"

namespace irt::numerics {
namespace {

using Random = std::mt19937;

double between(Random& random) { return std::uniform_real_distribution<double>(-1, 1)(random); }

// Bernstein coefficients of degree n - 1 of a polynomial of degree `degree`.
std::vector<double> line_of(std::size_t degree, std::size_t n, Random& random) {
  std::vector<double> c(degree + 1);
  for (double& v : c) v = between(random);
  while (c.size() < n) {
    const std::size_t d = c.size();
    c.push_back(c.back());
    for (std::size_t i = d - 1; i > 0; --i) c[i] += static_cast<double>(i) / static_cast<double>(d) * (c[i - 1] - c[i]);
  }
  return c;
}

// [down][depth][across], lines m apart: of total degree n - 1, as polynomials over a view are, and with noise that is of none; at most 2.
std::vector<double> some_form(std::size_t n, std::size_t m, double noise, Random& random) {
  std::vector<double> form(n * n * m, 0);
  for (std::size_t down = 0; down < n; ++down)
    for (std::size_t across = 0; down + across < n; ++across) {
      const auto v = line_of(down, n, random), s = line_of(n - 1, n, random), u = line_of(across, n, random);
      const double size = std::pow(0.3, static_cast<double>(down + across));
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t k = 0; k < n; ++k)
          for (std::size_t i = 0; i < n; ++i) form[(j * n + k) * m + i] += 0.4 * size * v[j] * s[k] * u[i] + noise / static_cast<double>(n * n) * between(random);
    }
  return form;
}

double largest_of(const std::vector<double>& values) {
  double largest = 0;
  for (const double v : values) largest = std::max(largest, std::fabs(v));
  return largest;
}

// The pencil of a form, its net, and what making them may have lost.
struct Pencil {
  std::vector<double> values, net;
  double error = 0;

  Pencil(const Reduction& reduction, const std::vector<double>& form, std::size_t n, std::size_t m) : values(n * reduction.width()), net(n * reduction.net_width()) {
    std::vector<double> strip(n * reduction.plane());
    Room scratch;
    Reduction::Strip of;
    double longest;
    error = reduction.strip_of(form.data(), {m, 1}, largest_of(form), of, strip.data(), scratch);
    error += reduction.pencil_of(strip.data(), of, 0, values.data(), net.data(), longest, scratch);
  }
};

std::vector<double> packed(const Reduction& reduction, const Reduction::Reduced& out, std::size_t lines, double scale = 1) {
  std::vector<double> values(out.down * lines * out.across + kLanes);
  reduction.pack(out, scale, values.data());
  return values;
}

TEST(Reduction, LosesNoMoreThanItSays) {
  Random random(5);
  for (const int degree : {2, 5, 10, 16})
    for (const double noise : {0.0, 0.1}) {
      const std::size_t n = static_cast<std::size_t>(degree) + 1, m = (n + kLanes - 1) / kLanes * kLanes;
      const std::vector<double> form = some_form(n, m, noise, random);
      for (const int depth : {1, degree / 2 + 1, degree})
        for (const double tolerance : {0.0, 1e-6, 1e-2}) {
          const Reduction reduction(degree, depth);
          const Pencil pencil(reduction, form, n, m);
          const double error = pencil.error;
          if (noise == 0) {
            EXPECT_LT(error, 1e-11) << degree;
          }
          const auto [low, high] = std::minmax_element(pencil.net.begin(), pencil.net.end());
          double beside = 0;
          for (std::size_t k = 0; k < n; ++k) beside = std::max(beside, reduction.beside(pencil.values.data() + k * reduction.width()));
          Reduction::Reduced out;
          const bool done = reduction.run(pencil.values.data(), tolerance, false, out);
          if (!done) {
            EXPECT_LT(depth, degree);
            ASSERT_TRUE(reduction.run(pencil.values.data(), tolerance, true, out));
            EXPECT_GT(out.error, tolerance);
          }
          EXPECT_LE(out.down, n);
          EXPECT_LE(out.across, n);
          const std::size_t lines = static_cast<std::size_t>(depth) + 1;
          const std::vector<double> cell = packed(reduction, out, lines);
          for (int trial = 0; trial < 20; ++trial) {
            const double at[] = {0.5 + 0.5 * between(random), 0.5 + 0.5 * between(random), 0.5 + 0.5 * between(random)};
            const double f = value(form.data(), n, n, n, m, bernstein_at, at);
            const double q = value(cell.data(), out.down, lines, out.across, out.across, chebyshev_at, at);
            EXPECT_LE(std::fabs(f - q), error + out.error + 1e-13) << degree << " to " << depth;
            EXPECT_LE(std::fabs(q), out.weight * (1 + 1e-13));
            EXPECT_GE(f, *low - beside - error - 1e-13);
            EXPECT_LE(f, *high + beside + error + 1e-13);
          }
        }
    }
}

__extension__ typedef __float128 Quad;

// Chebyshev's polynomials at u, or Bernstein's, to more digits than doubles have.
std::vector<Quad> exact_basis(bool chebyshev, Quad u, std::size_t n) {
  std::vector<Quad> v(n, 0);
  v[0] = 1;
  if (chebyshev) {
    if (n > 1) v[1] = 2 * u - 1;
    for (std::size_t k = 2; k < n; ++k) v[k] = 2 * (2 * u - 1) * v[k - 1] - v[k - 2];
  } else {
    for (std::size_t d = 1; d < n; ++d)
      for (std::size_t i = d + 1; i-- > 0;) v[i] = (1 - u) * v[i] + (i > 0 ? u * v[i - 1] : Quad(0));
  }
  return v;
}

Quad exact_value(const double* c, std::size_t down, std::size_t depth, std::size_t across, std::size_t padded, bool chebyshev, const double* at) {
  const auto v = exact_basis(chebyshev, at[0], down), s = exact_basis(false, at[1], depth), u = exact_basis(chebyshev, at[2], across);
  return sum_of(c, v, s, u, padded);
}

TEST(Reduction, RoundsNoMoreThanItSays) {
  Random random(7);
  double worst = 0;
  for (const int degree : {7, 10, 13, 20})
    for (int form_of = 0; form_of < 4; ++form_of) {
      const std::size_t n = static_cast<std::size_t>(degree) + 1, m = (n + kLanes - 1) / kLanes * kLanes;
      std::vector<double> form = some_form(n, m, 0, random);
      // Of one sign, nearly constant: sums are as large as they can be, and steps small.
      if (form_of % 2)
        for (double& v : form) v = 1.5 + 0.3 * v;
      const Reduction reduction(degree, degree);
      const Pencil pencil(reduction, form, n, m);
      const double error = pencil.error;
      Reduction::Reduced out;
      ASSERT_TRUE(reduction.run(pencil.values.data(), 0, true, out));
      const std::vector<double> cell = packed(reduction, out, n);
      for (int trial = 0; trial < 30; ++trial) {
        const double at[] = {0.5 + 0.5 * between(random), 0.5 + 0.5 * between(random), 0.5 + 0.5 * between(random)};
        const auto off = static_cast<double>(exact_value(form.data(), n, n, n, m, false, at) - exact_value(cell.data(), out.down, n, out.across, out.across, true, at));
        EXPECT_LE(std::fabs(off), error + out.error) << degree;
        worst = std::max(worst, std::fabs(off) / (error + out.error));
      }
    }
  EXPECT_GT(worst, 0.1);  // or the bound is of something else
}

TEST(Reduction, PacksFloatsAsDoubles) {
  Random random(6);
  const std::size_t n = 8;
  const std::vector<double> form = some_form(n, n, 0, random);
  const Reduction reduction(7, 7);
  const Pencil pencil(reduction, form, n, n);
  Reduction::Reduced out;
  ASSERT_TRUE(reduction.run(pencil.values.data(), 1e-3, false, out));
  const std::vector<double> wide = packed(reduction, out, n, 0.5);
  std::vector<float> narrow(wide.size());
  reduction.pack(out, 0.5, narrow.data());
  for (std::size_t i = 0; i < out.down * n * out.across; ++i) EXPECT_EQ(narrow[i], static_cast<float>(wide[i]));
}

TEST(Reduction, DropsWhatASmoothFormDoesNotNeed) {
  // u across only, of degree 1 written in degree 9.
  const std::size_t n = 10, m = 12;
  std::vector<double> form(n * n * m);
  for (std::size_t line = 0; line < n * n; ++line)
    for (std::size_t i = 0; i < m; ++i) form[line * m + i] = static_cast<double>(std::min<std::size_t>(i, n - 1)) / 9;
  const Reduction reduction(9, 3);
  const Pencil pencil(reduction, form, n, m);
  Reduction::Reduced out;
  ASSERT_TRUE(reduction.run(pencil.values.data(), 1e-12, false, out));
  EXPECT_EQ(out.down, 1u);
  EXPECT_EQ(out.across, 2u);
  EXPECT_NEAR(out.values[0], 0.5, 1e-14);
  EXPECT_NEAR(out.values[1], 0.5, 1e-14);
  // The net of what is straight is no wider.
  const auto [low, high] = std::minmax_element(pencil.net.begin(), pencil.net.end());
  EXPECT_NEAR(*low, 0, 1e-13);
  EXPECT_NEAR(*high, 1, 1e-13);
  EXPECT_LT(reduction.beside(pencil.values.data()), 1e-12);
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
