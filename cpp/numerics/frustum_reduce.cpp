// See frustum_reduce.h.
#include "numerics/frustum_reduce.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "caps.h"
#include "numerics/frustum_cuts.h"
#include "numerics/widest.h"

// Vectors are handed between functions that are always inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace irt::numerics {
namespace {

// Vectors in a line of a pencil.
constexpr std::size_t kMostPlaces = (limits::kFrustumDegree + 1) * ((limits::kFrustumDegree + kLanes) / kLanes);

// Coefficients of a net each way.
constexpr std::size_t kNetSide = 4;

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

// [r][i]: the same of the step from the i-th coefficient to the next, but for the mean of the first and the last one, which T_0 has besides: constants have no other
// polynomial in them.
Matrix by_steps(const Matrix& m) {
  const std::size_t n = m.size();
  Matrix out(n, std::vector<long double>(n - 1));
  for (std::size_t r = 0; r < n; ++r) {
    long double before = r == 0 ? -0.5L : 0;
    for (std::size_t i = 0; i + 1 < n; ++i) out[r][i] = -(before += m[r][i]);
  }
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
[[gnu::always_inline]] inline double sum_of(Lanes v) {
  double sum = v[0];
  for (std::size_t k = 1; k < kLanes; ++k) sum += v[k];
  return sum;
}

// What polynomials are made of: rows of factors, one for each sum of opposite coefficients and the middle one, or for each difference.
struct Folded {
  const double *even, *odd;
  std::size_t evens, odds;  // rows
};

// kN coefficients `stride` vectors apart, or n where kN is zero. Both bases are symmetric: what is made of them is made of sums of opposite coefficients or of
// differences, in half the products.
template <std::size_t kN>
class Fold {
 public:
  [[gnu::always_inline]] Fold(const Lanes* from, std::size_t stride, std::size_t n) : n_(kN ? kN : n) {
#pragma GCC unroll 16
    for (std::size_t i = 0; i < n_ / 2; ++i) {
      const Lanes a = from[i * stride], b = from[(n_ - 1 - i) * stride];
      sums_[i] = a + b;
      differences_[i] = a - b;
    }
    if (n_ % 2) sums_[n_ / 2] = from[n_ / 2 * stride];
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

// polynomials[r] = that of degree r, of n lines of `width` values, a multiple of kLanes. They are made of steps from line to line, over a tile much smaller
// than lines, so that little is lost by rounding: T_0 of the mean of the ends and steps. kSteps: n - 1 of them, or any number where it is zero.
template <std::size_t kSteps>
[[gnu::always_inline]] inline void polynomials_of(const double* lines, std::size_t n, std::size_t width, const Folded& m, double* polynomials) {
  const std::size_t count = kSteps ? kSteps : n - 1;
  Lanes steps[kSteps ? kSteps : limits::kFrustumDegree];
  for (std::size_t w = 0; w < width; w += kLanes) {
    const Lanes first = lanes(lines + w);
    Lanes last = first;
#pragma GCC unroll 16
    for (std::size_t i = 0; i < count; ++i) {
      const Lanes next = lanes(lines + (i + 1) * width + w);
      steps[i] = next - last;
      last = next;
    }
    const Fold<kSteps> fold(steps, 1, count);
    for (std::size_t r = 0; r < m.evens; ++r) lanes(polynomials + (2 * r + 1) * width + w) = fold.even(m.even + r * fold.sums());
    for (std::size_t r = 0; r < m.odds; ++r) lanes(polynomials + 2 * r * width + w) = fold.odd(m.odd + r * fold.differences());
    lanes(polynomials + w) += 0.5 * (first + last);
  }
}

// n lines of vectors, which lie at the places given and `stride` apart from line to line, become `kept` lines; returns the sum of the sizes of all that lies beyond.
template <std::size_t kN>
[[gnu::always_inline]] inline double shorten(const double* lines, std::size_t n, std::size_t kept, std::size_t stride, std::span<const std::size_t> places, const Folded& m, double* to) {
  Lanes lost{};
  for (const std::size_t w : places) {
    const Fold<kN> fold(&numerics::lanes(lines + w), stride / kLanes, n);
    const double *even = m.even, *odd = m.odd;
    for (std::size_t r = 0; r < kept / 2; ++r, even += fold.sums(), odd += fold.differences()) {
      const Lanes a = fold.even(even), b = fold.odd(odd);
      lanes(to + r * stride + w) = a + b;
      lanes(to + (kept - 1 - r) * stride + w) = a - b;
    }
    if (kept % 2) {
      lanes(to + kept / 2 * stride + w) = fold.even(even);
      even += fold.sums();
    }
    for (std::size_t r = (kept + 1) / 2; r < m.evens; ++r, even += fold.sums()) lost += sizes(fold.even(even));
    for (std::size_t r = kept / 2; r < m.odds; ++r, odd += fold.differences()) lost += sizes(fold.odd(odd));
  }
  return sum_of(lost);
}

IRT_WIDEST void polynomials_of(const double* lines, std::size_t n, std::size_t width, const Folded& m, double* polynomials) {
  switch (n) {
    case 8: return polynomials_of<7>(lines, n, width, m, polynomials);
    case 9: return polynomials_of<8>(lines, n, width, m, polynomials);
    case 10: return polynomials_of<9>(lines, n, width, m, polynomials);
    case 11: return polynomials_of<10>(lines, n, width, m, polynomials);
    case 12: return polynomials_of<11>(lines, n, width, m, polynomials);
    case 13: return polynomials_of<12>(lines, n, width, m, polynomials);
    default: return polynomials_of<0>(lines, n, width, m, polynomials);
  }
}

IRT_WIDEST double shorten(const double* lines, std::size_t n, std::size_t kept, std::size_t stride, std::span<const std::size_t> places, const Folded& m, double* to) {
  switch (n) {
    case 10: return shorten<10>(lines, n, kept, stride, places, m, to);
    case 11: return shorten<11>(lines, n, kept, stride, places, m, to);
    case 12: return shorten<12>(lines, n, kept, stride, places, m, to);
    case 13: return shorten<13>(lines, n, kept, stride, places, m, to);
    default: return shorten<0>(lines, n, kept, stride, places, m, to);
  }
}

// A product of matrices: `rows` lines of n factors, `from_step` apart and `term_step` in a line, with n lines of `width` values.
struct Product {
  std::size_t rows, n, width, from_step, term_step, with_step, to_step;
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
      for (std::size_t r = 0; r < kRows; ++r) sums[r][v] += from[r * p.from_step + i * p.term_step] * value;
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

// The sum of the sizes of `width` values, a multiple of kLanes.
[[gnu::always_inline]] inline double size_of(const double* line, std::size_t width) {
  Lanes sums[2] = {};
  std::size_t w = 0;
  for (; w + 2 * kLanes <= width; w += 2 * kLanes)
    for (std::size_t k = 0; k < 2; ++k) sums[k] += sizes(lanes(line + w + k * kLanes));
  if (w < width) sums[0] += sizes(lanes(line + w));
  return sum_of(sums[0] + sums[1]);
}

IRT_WIDEST double largest_size_of(const double* values, std::size_t n, std::size_t width) {
  double most = 0;
  for (std::size_t k = 0; k < n; ++k) most = std::max(most, size_of(values + k * width, width));
  return most;
}

// Of vectors at the places given.
IRT_WIDEST double largest_size_of(const double* values, std::size_t n, std::size_t stride, std::span<const std::size_t> places) {
  double most = 0;
  for (std::size_t k = 0; k < n; ++k, values += stride) {
    Lanes sum{};
    for (const std::size_t w : places) sum += sizes(lanes(values + w));
    most = std::max(most, sum_of(sum));
  }
  return most;
}

// The largest sum of sizes of what lines change by to the one a plane further down: n planes of lines of `width` values.
IRT_WIDEST double largest_step_of(const double* values, std::size_t n, std::size_t plane, std::size_t width) {
  double most = 0;
  for (const double* end = values + (n - 1) * plane; values < end; values += width) {
    Lanes sum{};
    for (std::size_t w = 0; w < width; w += kLanes) sum += sizes(lanes(values + plane + w) - lanes(values + w));
    most = std::max(most, sum_of(sum));
  }
  return most;
}

// The net of a line of a pencil: what the first `side` polynomials make, in lines of `lines` coefficients. `beside` becomes the sum of the sizes of the others;
// returns that of all.
IRT_WIDEST double net_of(const double* line, const PencilRow* rows, std::size_t n, std::size_t side, std::size_t lines, const double* factors, double* net, double& beside) {
  double all = 0, inside = 0;
  for (std::size_t j = 0; j < n; ++j) {
    all += size_of(line + rows[j].begin, rows[j].padded);
    if (j < side)
      for (std::size_t i = 0; i < std::min(side, rows[j].count); ++i) inside += std::fabs(line[rows[j].begin + i]);
  }
  beside = std::max(0.0, all - inside) + 0x1p-53 * static_cast<double>(2 * n * n) * all;
  double across[kNetSide][kNetSide + kLanes];
  for (std::size_t j = 0; j < side; ++j)
    for (std::size_t w = 0; w < lines; w += kLanes) {
      Lanes sum{};
      for (std::size_t i = 0; i < std::min(side, rows[j].count); ++i) sum += line[rows[j].begin + i] * lanes(factors + i * lines + w);
      lanes(across[j] + w) = sum;
    }
  for (std::size_t r = 0; r < side; ++r)
    for (std::size_t w = 0; w < lines; w += kLanes) {
      Lanes sum{};
      for (std::size_t j = 0; j < side; ++j) sum += factors[j * lines + r] * lanes(across[j] + w);
      lanes(net + r * lines + w) = sum;
    }
  return all;
}

template <typename Real>
[[gnu::always_inline]] inline void pack_rows(const double* values, std::size_t depth, std::size_t width, const PencilRow* rows, std::size_t down, std::size_t across, double scale,
                                             Real* to) {
  typedef Real Reals __attribute__((vector_size(sizeof(Real) * kLanes), aligned(alignof(Real)), may_alias));
  for (std::size_t j = 0; j < down; ++j)
    for (std::size_t k = 0; k < depth; ++k, to += across) {
      const double* from = values + k * width + rows[j].begin;
      for (std::size_t i = 0; i < across; i += kLanes)
        *reinterpret_cast<Reals*>(to + i) = i < rows[j].padded ? __builtin_convertvector(lanes(from + i) * scale, Reals) : Reals{};
    }
}

IRT_WIDEST void pack_in_floats(const double* values, std::size_t depth, std::size_t width, const PencilRow* rows, std::size_t down, std::size_t across, double scale, float* to) {
  pack_rows(values, depth, width, rows, down, across, scale, to);
}

IRT_WIDEST void pack_in_doubles(const double* values, std::size_t depth, std::size_t width, const PencilRow* rows, std::size_t down, std::size_t across, double scale, double* to) {
  pack_rows(values, depth, width, rows, down, across, scale, to);
}

}  // namespace

Reduction::Reduction(int degree, int depth)
    : n_(static_cast<std::size_t>(degree) + 1), depth_(static_cast<std::size_t>(depth) + 1), lines_(in_lanes(n_)),
      side_(std::min(n_, kNetSide)), net_lines_(in_lanes(side_)), across_(n_ * lines_, 0), net_(side_ * net_lines_) {
  for (std::size_t j = 0; j < n_; ++j) {
    const std::size_t count = n_ - j, padded = in_lanes(count);
    rows_.push_back({width_, count, padded});
    width_ += padded;
  }
  const Matrix m = chebyshev_of_bernstein(n_), steps = by_steps(m);
  double along = 0;  // the largest row of what shortens lines
  for (std::size_t r = 0; r < n_; ++r)
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      across_[i * lines_ + r] = static_cast<double>(steps[r][i]);
      all_ += std::fabs(across_[i * lines_ + r]);
    }
  // Of folded lines.
  const auto add = [](Halves& to, bool even, std::size_t n, const auto& at) {
    if (even) {
      for (std::size_t i = 0; i < (n + 1) / 2; ++i) to.even.push_back(static_cast<double>(at(i)));
    } else {
      for (std::size_t i = 0; i < n / 2; ++i) to.odd.push_back(static_cast<double>(at(i)));
    }
  };
  for (std::size_t r = 0; r < n_; ++r) add(down_, r % 2 == 1, n_ - 1, [&](std::size_t i) { return steps[r][i]; });
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
    for (std::size_t k = 0; k < (depth_ + 1) / 2; ++k) add(along_, true, n_, [&](std::size_t i) { return 0.5L * (kept[k][i] + kept[depth_ - 1 - k][i]); });
    for (std::size_t k = 0; k < depth_ / 2; ++k) add(along_, false, n_, [&](std::size_t i) { return 0.5L * (kept[k][i] - kept[depth_ - 1 - k][i]); });
    for (std::size_t r = depth_; r < n_; ++r) add(along_, r % 2 == 0, n_, [&](std::size_t i) { return m[r][i]; });
  }
  // Each of n terms at most is rounded; so are sums of lines before and after.
  along_rounding_ = 0x1p-53 * static_cast<double>(n_ + 10) * along;
  double largest = 1;
  for (std::size_t r = 0; r < side_; ++r) {
    const auto c = bernstein_of_chebyshev(r, side_);
    for (std::size_t i = 0; i < net_lines_; ++i) largest = std::max(largest, std::fabs(net_[r * net_lines_ + i] = static_cast<double>(c[std::min(i, side_ - 1)])));
  }
  net_rounding_ = 0x1p-53 * static_cast<double>(2 * side_ + 4) * largest * largest;
  net_cut_rounding_ = 0x1p-53 * static_cast<double>(n_ + 1) * largest * largest;
}

double Reduction::strip_of(const double* form, const Steps& steps, double largest, Strip& strip, double* values, Room& scratch) const {
  const std::size_t planes = n_ * n_, count = n_ - 1;
  double* const from = scratch.of(count * planes);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < planes; ++k) from[i * planes + k] = form[k * steps.line + (i + 1) * steps.term] - form[k * steps.line + i * steps.term];
  const double step = extent_of(from, count * planes).size();
  multiply(from, across_.data(), values, {planes, count, lines_, 1, planes, lines_, lines_});
  for (std::size_t k = 0; k < planes; ++k) values[k * lines_] += 0.5 * (form[k * steps.line] + form[k * steps.line + count * steps.term]);
  strip.widest = largest_size_of(values, planes, lines_) * (1 + 1e-12);
  strip.steepest = largest_step_of(values, n_, plane(), lines_) * (1 + 1e-12);
  // A step, each of its terms with its factor, and sums are rounded.
  return 0x1p-53 * (2 * largest + all_ * static_cast<double>(n_ + 2) * step);
}

double Reduction::pencil_of(const double* strip, const Strip& of, int cuts, double* pencil, double* net, double& longest, Room& scratch) const {
  const std::size_t n = n_, plane = this->plane();
  double* const values = scratch.of(n * plane + lines_);
  double* const sizes = values + n * plane;
  polynomials_of(strip, n, plane, folded(down_, n / 2, (n - 1) / 2), values);
  double lost = 0;  // of what the degree says is zero, nothing but rounding
  for (std::size_t j = 0; j < n; ++j) {
    const PencilRow& row = rows_[j];
    const double* const from = values + j * plane;
    largest_of(from, n, lines_, sizes);
    for (std::size_t i = row.count; i < n; ++i) lost += sizes[i];
    for (std::size_t k = 0; k < n; ++k) {
      double* const to = pencil + k * width() + row.begin;
      std::copy_n(from + k * lines_, row.padded, to);
      for (std::size_t i = row.count; i < row.padded; ++i) to[i] = 0;
    }
  }
  longest = 0;
  for (std::size_t k = 0; k < n; ++k) {
    double* const line = pencil + k * width();
    const double all = net_of(line, rows_.data(), n, side_, net_lines_, net_.data(), net + k * net_width(), line[width_]);
    longest = std::max(longest, all);
    line[width_] += (net_rounding_ + cuts * net_cut_rounding_) * all;
    for (std::size_t i = 1; i < kLanes; ++i) line[width_ + i] = 0;
  }
  // Steps, sums of two, half as many terms with their factors, and their sums are rounded.
  return lost + 0x1p-53 * (2 * of.widest + all_ * static_cast<double>(n / 2 + 4) * of.steepest);
}

bool Reduction::run(const double* pencil, double tolerance, bool must, Reduced& out) const {
  double* const sizes = out.scratch.of((depth_ + 1) * width());
  out.error = 0;
  // |T| <= 1, and along the depth f is a mean of lines: what is lost is at most the sum of the largest sizes.
  largest_of(pencil, n_, width(), sizes);
  const auto drop = [&](std::size_t& left, const auto& size) {
    for (double lost = 0; left > 1; --left) {
      const double more = size(left - 1);
      if (lost + more > tolerance) break;
      lost += more;
      out.error += more;
    }
  };
  out.down = out.across = n_;
  drop(out.down, [&](std::size_t j) {
    double sum = 0;
    for (std::size_t i = 0; i < rows_[j].count; ++i) sum += sizes[rows_[j].begin + i];
    return sum;
  });
  drop(out.across, [&](std::size_t i) {
    double sum = 0;
    for (std::size_t j = 0; j < std::min(out.down, n_ - i); ++j) sum += sizes[rows_[j].begin + i];
    return sum;
  });
  std::size_t places[kMostPlaces], count = 0;  // of vectors with what is left
  for (std::size_t j = 0; j < out.down; ++j)
    for (std::size_t i = 0; i < std::min(rows_[j].padded, out.across); i += kLanes) places[count++] = rows_[j].begin + i;
  const std::span<const std::size_t> kept(places, count);
  out.values = pencil;
  if (depth_ < n_) {
    double* const shorter = sizes + width();
    const double lost = shorten(pencil, n_, depth_, width(), kept, folded(along_, (n_ + 1) / 2, n_ / 2), shorter);
    if (lost > tolerance && !must) return false;
    out.error += lost + along_rounding_ * std::accumulate(sizes, sizes + width_, 0.0);
    out.values = shorter;
  }
  out.weight = largest_size_of(out.values, depth_, width(), kept) * (1 + 1e-12);
  return true;
}

void Reduction::pack(const Reduced& reduced, double scale, float* to) const { pack_in_floats(reduced.values, depth_, width(), rows_.data(), reduced.down, reduced.across, scale, to); }
void Reduction::pack(const Reduced& reduced, double scale, double* to) const { pack_in_doubles(reduced.values, depth_, width(), rows_.data(), reduced.down, reduced.across, scale, to); }

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
