// What cutting a frustum form does to arrays of coefficients, in the widest vectors that the processor has; results do not depend on them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace irt::numerics {

// n lines of `width` values, `stride` apart, `count` times, `step` apart. width: a multiple of kLanes, but for sums of two doubles.
struct Runs {
  std::size_t n, width, stride, count, step;
};
struct Extent {
  double lowest, highest;
  double size() const { return std::max(std::fabs(lowest), std::fabs(highest)); }  // the largest
};
struct Halves {
  Extent first, second;
};
// de Casteljau's algorithm at the middle: `first` becomes the coefficients of the first half, `second` those of the second.
Halves halve(double* first, double* second, const Runs& runs);
// Without looking at what they become.
void halve_unseen(double* first, double* second, const Runs& runs);
// The same for sums hi + lo (kDoubleDoubleUnit).
void halve(double* first_hi, double* first_lo, double* second_hi, double* second_lo, const Runs& runs);

Extent extent_of(const double* values, std::size_t n);  // n: kLanes at least

// The least and the largest step from line to line.
Extent steps_of(const double* values, const Runs& runs);
// The smallest size of one where signs change.
double slowest_change(const double* values, const Runs& runs);
// How many of the lines' values change their sign more than once.
std::size_t winding(const double* values, const Runs& runs);

constexpr std::size_t kLanes = 4;
// Rounded up to whole vectors.
constexpr std::size_t in_lanes(std::size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

// Room for doubles that begins where a line of the cache does: vectors that lie across two of them take longer.
class Room {
 public:
  // For n of them; pointers that were handed out before hold where it need not grow.
  double* of(std::size_t n) {
    if (lines_.size() * kLine < n) lines_.resize((n + kLine - 1) / kLine);
    return reinterpret_cast<double*>(lines_.data());
  }

 private:
  static constexpr std::size_t kLine = 8;
  struct alignas(kLine * sizeof(double)) Line {
    double values[kLine];
  };
  std::vector<Line> lines_;
};

// `lines` lines of n values, m apart, times `scale`, one behind the other; writes up to kLanes values beyond the last.
void pack(const double* from, std::size_t lines, std::size_t n, std::size_t m, double scale, float* to);
void pack(const double* from, std::size_t lines, std::size_t n, std::size_t m, double scale, double* to);

}  // namespace irt::numerics
