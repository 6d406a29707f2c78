// See frustum_reduce.h.
#include "numerics/frustum_reduce.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numerics/frustum_cuts.h"
#include "numerics/widest.h"

namespace irt::numerics {
namespace {

using Matrix = std::vector<std::vector<long double>>;

// [r][i]: how much of T_r(2u - 1) there is in the i-th Bernstein polynomial of degree n - 1.
Matrix chebyshev_of_bernstein(std::size_t n) {
  Matrix b{{1}};  // by polynomial of Bernstein's basis
  for (std::size_t d = 1; d < n; ++d) {
    Matrix next(d + 1, std::vector<long double>(d + 1, 0));
    for (std::size_t i = 0; i < d; ++i)
      for (std::size_t r = 0; r < d; ++r) {
        // x T_r = (T_(r+1) + T_|r-1|) / 2, u = (1 + x) / 2.
        const long double v = b[i][r], half = v / 2, quarter = v / 4;
        const std::size_t before = r > 0 ? r - 1 : 1;
        next[i][r] += half;
        next[i + 1][r] += half;
        for (const std::size_t to : {r + 1, before}) {
          next[i][to] -= quarter;
          next[i + 1][to] += quarter;
        }
      }
    b = std::move(next);
  }
  Matrix out(n, std::vector<long double>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t r = 0; r < n; ++r) out[r][i] = b[i][r];
  return out;
}

// Of T_r(2u - 1) in Bernstein's basis of degree n - 1 > 0.
std::vector<long double> bernstein_of_chebyshev(std::size_t r, std::size_t n) {
  // Of degree r: (-1)^(r - i) binomial(2r, 2i) / binomial(r, i).
  std::vector<long double> c(r + 1);
  long double ratio = r % 2 ? -1 : 1;
  for (std::size_t i = 0; i <= r; ++i) {
    c[i] = ratio;
    const long double k = static_cast<long double>(i), m = static_cast<long double>(r);
    ratio *= -(2 * m - 2 * k) * (2 * m - 2 * k - 1) / ((2 * k + 1) * (2 * k + 2)) * (k + 1) / (m - k);
  }
  for (std::size_t d = r + 1; d < n; ++d) {
    c.push_back(c.back());
    for (std::size_t i = d - 1; i > 0; --i) {
      const long double share = static_cast<long double>(i) / static_cast<long double>(d);
      c[i] = share * c[i - 1] + (1 - share) * c[i];
    }
  }
  return c;
}

typedef double Lanes __attribute__((vector_size(sizeof(double) * kLanes), aligned(alignof(double)), may_alias));

// A product of matrices: `rows` lines of n factors, `from_step` apart, with n lines of `width` values.
struct Product {
  std::size_t rows, n, width, from_step, with_step, to_step;
};

// kRows rows of it, kVectors vectors wide: as many sums as hide the time that each step of one takes.
template <std::size_t kRows, std::size_t kVectors>
[[gnu::always_inline]] inline void block(const double* from, const double* with, double* to, const Product& p) {
  Lanes sums[kRows][kVectors] = {};
  for (std::size_t i = 0; i < p.n; ++i)
#pragma GCC unroll 8
    for (std::size_t v = 0; v < kVectors; ++v) {
      const Lanes value = *reinterpret_cast<const Lanes*>(with + i * p.with_step + v * kLanes);
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRows; ++r) sums[r][v] += from[r * p.from_step + i] * value;
    }
  for (std::size_t r = 0; r < kRows; ++r)
    for (std::size_t v = 0; v < kVectors; ++v) *reinterpret_cast<Lanes*>(to + r * p.to_step + v * kLanes) = sums[r][v];
}

template <std::size_t kRows>
[[gnu::always_inline]] inline void rows_of(const double* from, const double* with, double* to, const Product& p) {
  std::size_t w = 0;
  for (; w + 2 * kLanes <= p.width; w += 2 * kLanes) block<kRows, 2>(from, with + w, to + w, p);
  if (w < p.width) block<kRows, 1>(from, with + w, to + w, p);
}

// width: a multiple of kLanes.
IRT_WIDEST void multiply(const double* from, const double* with, double* to, const Product& p) {
  std::size_t r = 0;
  for (; r + 4 <= p.rows; r += 4) rows_of<4>(from + r * p.from_step, with, to + r * p.to_step, p);
  switch (p.rows - r) {
    case 3: return rows_of<3>(from + r * p.from_step, with, to + r * p.to_step, p);
    case 2: return rows_of<2>(from + r * p.from_step, with, to + r * p.to_step, p);
    case 1: return rows_of<1>(from + r * p.from_step, with, to + r * p.to_step, p);
    default: return;
  }
}

// sums[i] = the sum of |values[k][i]| over n lines, a multiple of kLanes long.
IRT_WIDEST void sizes_of(const double* values, std::size_t n, std::size_t width, double* sums) {
  for (std::size_t w = 0; w < width; w += kLanes) {
    Lanes sum{};
    for (std::size_t k = 0; k < n; ++k) {
      const Lanes v = *reinterpret_cast<const Lanes*>(values + k * width + w);
      sum += v < Lanes{} ? -v : v;
    }
    *reinterpret_cast<Lanes*>(sums + w) = sum;
  }
}

// largest[i] = the largest |values[k][i]| of n lines, a multiple of kLanes long.
IRT_WIDEST void largest_of(const double* values, std::size_t n, std::size_t width, double* largest) {
  for (std::size_t w = 0; w < width; w += kLanes) {
    Lanes most{};
    for (std::size_t k = 0; k < n; ++k) {
      const Lanes v = *reinterpret_cast<const Lanes*>(values + k * width + w), size = v < Lanes{} ? -v : v;
      most = size > most ? size : most;
    }
    *reinterpret_cast<Lanes*>(largest + w) = most;
  }
}

double largest_of(const double* values, std::size_t n) {
  const Extent e = extent_of(values, n);
  return std::max(std::fabs(e.lowest), std::fabs(e.highest));
}

}  // namespace

Reduction::Reduction(int degree, int depth)
    : n_(static_cast<std::size_t>(degree) + 1), depth_(static_cast<std::size_t>(depth) + 1), lines_((n_ + kLanes - 1) / kLanes * kLanes), down_(n_ * n_),
      across_(n_ * lines_, 0) {
  const Matrix m = chebyshev_of_bernstein(n_);
  double all = 0, along = 1;
  for (std::size_t r = 0; r < n_; ++r)
    for (std::size_t i = 0; i < n_; ++i) {
      down_[r * n_ + i] = across_[i * lines_ + r] = static_cast<double>(m[r][i]);
      all += std::fabs(down_[r * n_ + i]);
    }
  if (depth_ < n_) {
    Matrix kept(depth_, std::vector<long double>(n_, 0));
    for (std::size_t r = 0; r < depth_; ++r) {
      const auto c = bernstein_of_chebyshev(r, depth_);
      for (std::size_t k = 0; k < depth_; ++k)
        for (std::size_t i = 0; i < n_; ++i) kept[k][i] += c[k] * m[r][i];
    }
    for (const auto& row : kept) {
      double sum = 0;
      for (const long double v : row) {
        along_.push_back(static_cast<double>(v));
        sum += std::fabs(along_.back());
      }
      along = std::max(along, sum);
    }
    for (std::size_t r = depth_; r < n_; ++r)
      for (const long double v : m[r]) along_.push_back(static_cast<double>(v));
  }
  rounding_ = 0x1p-53 * static_cast<double>(n_ + 4) * along * (1 + all + all * all);
}

bool Reduction::run(const double* form, std::size_t padded, double largest, double tolerance, bool must, Reduced& out) const {
  const std::size_t n = n_, m = padded;
  const auto room = [](std::vector<double>& v, std::size_t size) {
    if (v.size() < size) v.resize(size);
    return v.data();
  };
  double* const first = room(out.scratch, (2 * n + 1) * n * m);
  double *const second = first + n * n * m, *const line = second + n * n * m;
  out.error = rounding_ * largest;
  const double* planes = form;
  if (depth_ < n) {
    // Along the depth, plane by plane. f is a mean of its lines, so what the worst of them loses bounds what f does.
    const std::size_t lost = n - depth_;
    for (std::size_t j = 0; j < n; ++j) multiply(along_.data() + depth_ * n, form + j * n * m, second + j * lost * m, {lost, n, m, n, m, m});
    largest_of(second, n, lost * m, line);
    double error = 0;
    for (std::size_t r = 0; r < lost; ++r) error += *std::max_element(line + r * m, line + (r + 1) * m);
    if (error > tolerance && !must) return false;
    out.error += error;
    for (std::size_t j = 0; j < n; ++j) multiply(along_.data(), form + j * n * m, first + j * depth_ * m, {depth_, n, m, n, m, m});
    planes = first;
  }
  const std::size_t width = depth_ * m;
  multiply(down_.data(), planes, second, {n, n, width, n, width, width});
  out.down = n;
  for (double lost = 0; out.down > 1; --out.down) {
    const double more = largest_of(second + (out.down - 1) * width, width);
    if (lost + more > tolerance) break;
    lost += more;
    out.error += more;
  }
  // Across: lines by the transposed matrix.
  const std::size_t lines = out.down * depth_, plane = depth_ * lines_;
  double* const values = room(out.values, n * n * lines_ + kLanes);
  multiply(second, across_.data(), values, {lines, n, lines_, m, lines_, lines_});
  // |T| <= 1: what is lost is at most the sum over `down` of the largest along the depth.
  double *const sizes = first, *const here = sizes + lines_;
  std::fill_n(sizes, lines_, 0.0);
  for (std::size_t j = 0; j < out.down; ++j) {
    largest_of(values + j * plane, depth_, lines_, here);
    for (std::size_t r = 0; r < n; ++r) sizes[r] += here[r];
  }
  out.across = n;
  for (double lost = 0; out.across > 1; --out.across) {
    const double more = sizes[out.across - 1];
    if (lost + more > tolerance) break;
    lost += more;
    out.error += more;
  }
  out.weight = 0;
  sizes_of(values, out.down, plane, first);
  for (std::size_t k = 0; k < depth_; ++k) {
    double sum = 0;
    for (std::size_t r = 0; r < out.across; ++r) sum += first[k * lines_ + r];
    out.weight = std::max(out.weight, sum);
  }
  out.weight *= 1 + 1e-12;
  return true;
}

void chebyshev_at(double u, std::size_t n, double* values, double* slopes) {
  const double x = 2 * u - 1;
  double t = 1, t_before = x, second = 0, second_before = -1;  // T_k and U_(k-1)
  for (std::size_t k = 0; k < n; ++k) {
    values[k] = t;
    slopes[k] = 2 * static_cast<double>(k) * second;
    t_before = std::exchange(t, 2 * x * t - t_before);
    second_before = std::exchange(second, 2 * x * second - second_before);
  }
}

void bernstein_at(double u, std::size_t n, double* values, double* slopes) {
  std::fill_n(values, n, 0.0);
  values[0] = 1;
  for (std::size_t d = 1; d < n; ++d) {
    if (d == n - 1)
      for (std::size_t i = 0; i < n; ++i) slopes[i] = static_cast<double>(d) * ((i > 0 ? values[i - 1] : 0) - (i < d ? values[i] : 0));
    for (std::size_t i = d; i > 0; --i) values[i] = (1 - u) * values[i] + u * values[i - 1];
    values[0] *= 1 - u;
  }
}

}  // namespace irt::numerics
