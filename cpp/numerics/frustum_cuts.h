// What cutting a frustum form does to arrays of coefficients, in the widest vectors that the processor has; results do not depend on them.
#pragma once

#include <cstddef>

namespace irt::numerics {

// de Casteljau's algorithm at the middle, on n runs of `width` values, `stride` apart, `count` times, `step` apart: `first` becomes the
// coefficients of the first half, `second` those of the second.
struct Runs {
  std::size_t n, width, stride, count, step;
};
void halve(double* first, double* second, const Runs& runs);  // width: a multiple of kLanes
// The same for sums hi + lo (kDoubleDoubleUnit).
void halve(double* first_hi, double* first_lo, double* second_hi, double* second_lo, const Runs& runs);

struct Extent {
  double lowest, highest;
};
Extent extent_of(const double* values, std::size_t n);  // n: a multiple of kLanes

// Steps between neighbours `stride` apart, of n values in all: the least, the largest, and the smallest size where signs change.
struct Steps {
  double least, most, slowest;
};
Steps steps_of(const double* values, std::size_t n, std::size_t stride);

constexpr std::size_t kLanes = 4;

// `lines` lines of n values, m apart, times `scale`, one behind the other; writes up to kLanes values beyond the last.
void pack(const double* from, std::size_t lines, std::size_t n, std::size_t m, double scale, float* to);
void pack(const double* from, std::size_t lines, std::size_t n, std::size_t m, double scale, double* to);

}  // namespace irt::numerics
