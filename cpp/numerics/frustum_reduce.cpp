// See frustum_reduce.h.
#include "numerics/frustum_reduce.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "caps.h"
#include "numerics/frustum_cuts.h"
#include "numerics/widest.h"

// Vectors are handed between functions that are always inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

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

[[gnu::always_inline]] inline Lanes& lanes(double* at) { return *reinterpret_cast<Lanes*>(at); }
[[gnu::always_inline]] inline const Lanes& lanes(const double* at) { return *reinterpret_cast<const Lanes*>(at); }
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
[[gnu::always_inline]] inline Lanes sizes(Lanes v) { return larger(v, -v); }

// What polynomials are made of: rows of factors, one for each sum of opposite coefficients and the middle one, or for each difference.
struct Folded {
  const double *even, *odd;
  std::size_t evens, odds;  // rows
};

// kN coefficients `stride` apart, or n where kN is zero. Both bases are symmetric: even polynomials are made of sums of opposite coefficients, odd
// ones of differences, in half the products.
template <std::size_t kN>
class Fold {
 public:
  [[gnu::always_inline]] Fold(const double* from, std::size_t stride, std::size_t n) : n_(kN ? kN : n) {
#pragma GCC unroll 16
    for (std::size_t i = 0; i < n_ / 2; ++i) {
      const Lanes a = lanes(from + i * stride), b = lanes(from + (n_ - 1 - i) * stride);
      sums_[i] = a + b;
      differences_[i] = a - b;
    }
    if (n_ % 2) sums_[n_ / 2] = lanes(from + n_ / 2 * stride);
  }
  [[gnu::always_inline]] Lanes even(const double* factors) const { return of(factors, sums_, (n_ + 1) / 2); }
  [[gnu::always_inline]] Lanes odd(const double* factors) const { return of(factors, differences_, n_ / 2); }
  std::size_t sums() const { return (n_ + 1) / 2; }
  std::size_t differences() const { return n_ / 2; }

 private:
  [[gnu::always_inline]] static Lanes of(const double* factors, const Lanes* terms, std::size_t n) {
    Lanes sum = factors[0] * terms[0];
#pragma GCC unroll 16
    for (std::size_t i = 1; i < n; ++i) sum += factors[i] * terms[i];
    return sum;
  }

  static constexpr std::size_t kMost = kN ? kN : limits::kFrustumDegree + 1;
  std::size_t n_;
  Lanes sums_[(kMost + 1) / 2] = {}, differences_[kMost / 2] = {};
};

// polynomials[r] = that of degree r, of n lines of `width` values, a multiple of kLanes.
template <std::size_t kN>
[[gnu::always_inline]] inline void polynomials_of(const double* lines, std::size_t n, std::size_t width, const Folded& m, double* polynomials) {
  for (std::size_t w = 0; w < width; w += kLanes) {
    const Fold<kN> fold(lines + w, width, n);
    for (std::size_t r = 0; r < fold.sums(); ++r) lanes(polynomials + 2 * r * width + w) = fold.even(m.even + r * fold.sums());
    for (std::size_t r = 0; r < fold.differences(); ++r) lanes(polynomials + (2 * r + 1) * width + w) = fold.odd(m.odd + r * fold.differences());
  }
}

// Planes of n lines become planes of `kept` lines; largest[r]: the largest size of what lies beyond in each polynomial, even ones first.
template <std::size_t kN>
[[gnu::always_inline]] inline void shorten(const double* planes, std::size_t n, std::size_t kept, std::size_t width, const Folded& m, double* to, double* largest) {
  std::fill_n(largest, (n - kept) * width, 0.0);
  for (std::size_t j = 0; j < n; ++j, planes += n * width, to += kept * width)
    for (std::size_t w = 0; w < width; w += kLanes) {
      const Fold<kN> fold(planes + w, width, n);
      const double *even = m.even, *odd = m.odd;
      for (std::size_t r = 0; r < kept / 2; ++r, even += fold.sums(), odd += fold.differences()) {
        const Lanes a = fold.even(even), b = fold.odd(odd);
        lanes(to + r * width + w) = a + b;
        lanes(to + (kept - 1 - r) * width + w) = a - b;
      }
      if (kept % 2) {
        lanes(to + kept / 2 * width + w) = fold.even(even);
        even += fold.sums();
      }
      double* beyond = largest + w;
      for (std::size_t r = (kept + 1) / 2; r < m.evens; ++r, even += fold.sums(), beyond += width) lanes(beyond) = larger(sizes(fold.even(even)), lanes(beyond));
      for (std::size_t r = kept / 2; r < m.odds; ++r, odd += fold.differences(), beyond += width) lanes(beyond) = larger(sizes(fold.odd(odd)), lanes(beyond));
    }
}

IRT_WIDEST void polynomials_of(const double* lines, std::size_t n, std::size_t width, const Folded& m, double* polynomials) {
  switch (n) {
    case 8: return polynomials_of<8>(lines, n, width, m, polynomials);
    case 9: return polynomials_of<9>(lines, n, width, m, polynomials);
    case 10: return polynomials_of<10>(lines, n, width, m, polynomials);
    case 11: return polynomials_of<11>(lines, n, width, m, polynomials);
    case 12: return polynomials_of<12>(lines, n, width, m, polynomials);
    case 13: return polynomials_of<13>(lines, n, width, m, polynomials);
    default: return polynomials_of<0>(lines, n, width, m, polynomials);
  }
}

IRT_WIDEST void shorten(const double* planes, std::size_t n, std::size_t kept, std::size_t width, const Folded& m, double* to, double* largest) {
  switch (n) {
    case 10: return shorten<10>(planes, n, kept, width, m, to, largest);
    case 11: return shorten<11>(planes, n, kept, width, m, to, largest);
    case 12: return shorten<12>(planes, n, kept, width, m, to, largest);
    case 13: return shorten<13>(planes, n, kept, width, m, to, largest);
    default: return shorten<0>(planes, n, kept, width, m, to, largest);
  }
}

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
      const Lanes value = lanes(with + i * p.with_step + v * kLanes);
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRows; ++r) sums[r][v] += from[r * p.from_step + i] * value;
    }
  for (std::size_t r = 0; r < kRows; ++r)
    for (std::size_t v = 0; v < kVectors; ++v) lanes(to + r * p.to_step + v * kLanes) = sums[r][v];
}

template <std::size_t kRows>
[[gnu::always_inline]] inline void rows_of(const double* from, const double* with, double* to, const Product& p) {
  std::size_t w = 0;
  for (; w + 3 * kLanes <= p.width; w += 3 * kLanes) block<kRows, 3>(from, with + w, to + w, p);
  for (; w < p.width; w += kLanes) block<kRows, 1>(from, with + w, to + w, p);
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
    for (std::size_t k = 0; k < n; ++k) sum += sizes(lanes(values + k * width + w));
    lanes(sums + w) = sum;
  }
}

// largest[i] = the largest |values[k][i]| of n lines, a multiple of kLanes long.
IRT_WIDEST void largest_of(const double* values, std::size_t n, std::size_t width, double* largest) {
  for (std::size_t w = 0; w < width; w += kLanes) {
    Lanes most{};
    for (std::size_t k = 0; k < n; ++k) most = larger(sizes(lanes(values + k * width + w)), most);
    lanes(largest + w) = most;
  }
}

Folded folded(const auto& halves, std::size_t sums, std::size_t differences) {
  return {halves.even.data(), halves.odd.data(), halves.even.size() / sums, differences ? halves.odd.size() / differences : 0};
}

double largest_of(const double* values, std::size_t n) {
  const Extent e = extent_of(values, n);
  return std::max(std::fabs(e.lowest), std::fabs(e.highest));
}

}  // namespace

Reduction::Reduction(int degree, int depth)
    : n_(static_cast<std::size_t>(degree) + 1), depth_(static_cast<std::size_t>(depth) + 1), lines_((n_ + kLanes - 1) / kLanes * kLanes), across_(n_ * lines_, 0) {
  const Matrix m = chebyshev_of_bernstein(n_);
  double all = 0, along = 1;
  for (std::size_t r = 0; r < n_; ++r)
    for (std::size_t i = 0; i < n_; ++i) {
      across_[i * lines_ + r] = static_cast<double>(m[r][i]);
      all += std::fabs(across_[i * lines_ + r]);
    }
  // Of folded lines.
  const auto add = [&](Halves& to, std::size_t r, const auto& at) {
    if (r % 2 == 0) {
      for (std::size_t i = 0; i < (n_ + 1) / 2; ++i) to.even.push_back(static_cast<double>(at(i)));
    } else {
      for (std::size_t i = 0; i < n_ / 2; ++i) to.odd.push_back(static_cast<double>(at(i)));
    }
  };
  for (std::size_t r = 0; r < n_; ++r) add(down_, r, [&](std::size_t i) { return m[r][i]; });
  if (depth_ < n_) {
    Matrix kept(depth_, std::vector<long double>(n_, 0));
    for (std::size_t r = 0; r < depth_; ++r) {
      const auto c = bernstein_of_chebyshev(r, depth_);
      for (std::size_t k = 0; k < depth_; ++k)
        for (std::size_t i = 0; i < n_; ++i) kept[k][i] += c[k] * m[r][i];
    }
    for (const auto& row : kept) {
      double sum = 0;
      for (const long double v : row) sum += static_cast<double>(std::fabs(v));
      along = std::max(along, sum);
    }
    // Means and half the differences of opposite lines, then what is lost.
    for (std::size_t k = 0; k < (depth_ + 1) / 2; ++k) add(along_, 0, [&](std::size_t i) { return 0.5L * (kept[k][i] + kept[depth_ - 1 - k][i]); });
    for (std::size_t k = 0; k < depth_ / 2; ++k) add(along_, 1, [&](std::size_t i) { return 0.5L * (kept[k][i] - kept[depth_ - 1 - k][i]); });
    for (std::size_t r = depth_; r < n_; ++r) add(along_, r, [&](std::size_t i) { return m[r][i]; });
  }
  // Each of n terms at most is rounded; so are sums of lines before and after.
  rounding_ = 0x1p-53 * static_cast<double>(n_ + 10) * along * (1 + all + all * all);
}

bool Reduction::run(const double* form, std::size_t padded, double largest, double tolerance, bool must, Reduced& out) const {
  const std::size_t n = n_, m = padded;
  double* const first = out.scratch.of(2 * n * n * m);
  double* const second = first + n * n * m;
  out.error = rounding_ * largest;
  const double* planes = form;
  if (depth_ < n) {
    // Along the depth, plane by plane. f is a mean of its lines, so what the worst of them loses bounds what f does.
    double* const lost = second;
    shorten(form, n, depth_, m, folded(along_, (n + 1) / 2, n / 2), first, lost);
    double error = 0;
    for (std::size_t r = 0; r < n - depth_; ++r) error += *std::max_element(lost + r * m, lost + (r + 1) * m);
    if (error > tolerance && !must) return false;
    out.error += error;
    planes = first;
  }
  const std::size_t width = depth_ * m;
  polynomials_of(planes, n, width, folded(down_, (n + 1) / 2, n / 2), second);
  out.down = n;
  for (double lost = 0; out.down > 1; --out.down) {
    const double more = largest_of(second + (out.down - 1) * width, width);
    if (lost + more > tolerance) break;
    lost += more;
    out.error += more;
  }
  // Across: lines by the transposed matrix.
  const std::size_t lines = out.down * depth_, plane = depth_ * lines_;
  if (out.values.size() < n * n * lines_ + kLanes) out.values.resize(n * n * lines_ + kLanes);
  double* const values = out.values.data();
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
