// See frustum_cuts.h.
#include "numerics/frustum_cuts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "numerics/widest.h"

namespace irt::numerics {
namespace {

typedef double Lanes __attribute__((vector_size(sizeof(double) * kLanes), aligned(alignof(double)), may_alias));

// All rounds on n runs of kVectors vectors each, `stride` doubles apart.
template <std::size_t kVectors>
[[gnu::always_inline]] inline void rounds(double* a, double* b, std::size_t n, std::size_t stride, std::size_t vectors) {
  const std::size_t count = kVectors ? kVectors : vectors;
  const Lanes half = Lanes{} + 0.5;
  for (std::size_t round = 1; round <= n; ++round) {
    const Lanes* last = reinterpret_cast<const Lanes*>(a + (n - 1) * stride);
    Lanes* kept = reinterpret_cast<Lanes*>(b + (n - round) * stride);
    for (std::size_t m = 0; m < count; ++m) kept[m] = last[m];
    for (std::size_t i = n - 1; i >= round; --i) {
      Lanes* to = reinterpret_cast<Lanes*>(a + i * stride);
      const Lanes* from = reinterpret_cast<const Lanes*>(a + (i - 1) * stride);
      for (std::size_t m = 0; m < count; ++m) to[m] = half * (from[m] + to[m]);
    }
  }
}

// 2^-k.
constexpr std::size_t kMostRuns = 33;
constexpr std::array<double, kMostRuns + 1> kHalves = [] {
  std::array<double, kMostRuns + 1> a{1};
  for (std::size_t k = 1; k < a.size(); ++k) a[k] = 0.5 * a[k - 1];
  return a;
}();

// All rounds on one run of vectors that stays in registers: sums instead of means, halved at the end, which rounds alike.
template <std::size_t kCount>
[[gnu::always_inline]] inline void rounds(double* a, double* b, std::size_t stride) {
  Lanes v[kCount];
#pragma GCC unroll 16
  for (std::size_t i = 0; i < kCount; ++i) v[i] = *reinterpret_cast<const Lanes*>(a + i * stride);
#pragma GCC unroll 16
  for (std::size_t round = 0; round < kCount; ++round) {
    *reinterpret_cast<Lanes*>(b + (kCount - 1 - round) * stride) = v[kCount - 1] * kHalves[round];
#pragma GCC unroll 16
    for (std::size_t i = kCount - 1; i > round; --i) v[i] += v[i - 1];
  }
#pragma GCC unroll 16
  for (std::size_t i = 1; i < kCount; ++i) *reinterpret_cast<Lanes*>(a + i * stride) = v[i] * kHalves[i];
}

template <std::size_t kCount>
[[gnu::always_inline]] inline void all_rounds(double* first, double* second, const Runs& runs) {
  for (std::size_t r = 0; r < runs.count; ++r)
    for (std::size_t m = 0; m < runs.width; m += kLanes) rounds<kCount>(first + r * runs.step + m, second + r * runs.step + m, runs.stride);
}

}  // namespace

IRT_WIDEST void halve(double* first, double* second, const Runs& runs) {
  switch (runs.n) {
    case 2: return all_rounds<2>(first, second, runs);
    case 3: return all_rounds<3>(first, second, runs);
    case 4: return all_rounds<4>(first, second, runs);
    case 5: return all_rounds<5>(first, second, runs);
    case 6: return all_rounds<6>(first, second, runs);
    case 7: return all_rounds<7>(first, second, runs);
    case 8: return all_rounds<8>(first, second, runs);
    case 9: return all_rounds<9>(first, second, runs);
    case 10: return all_rounds<10>(first, second, runs);
    case 11: return all_rounds<11>(first, second, runs);
    case 12: return all_rounds<12>(first, second, runs);
    case 13: return all_rounds<13>(first, second, runs);
    case 14: return all_rounds<14>(first, second, runs);
    case 15: return all_rounds<15>(first, second, runs);
    default: break;
  }
  const std::size_t vectors = runs.width / kLanes;
  for (std::size_t r = 0; r < runs.count; ++r) {
    double *a = first + r * runs.step, *b = second + r * runs.step;
    switch (vectors) {
      case 1: rounds<1>(a, b, runs.n, runs.stride, 1); break;
      case 2: rounds<2>(a, b, runs.n, runs.stride, 2); break;
      case 3: rounds<3>(a, b, runs.n, runs.stride, 3); break;
      case 4: rounds<4>(a, b, runs.n, runs.stride, 4); break;
      case 5: rounds<5>(a, b, runs.n, runs.stride, 5); break;
      default: rounds<0>(a, b, runs.n, runs.stride, vectors);
    }
  }
}

IRT_WIDEST void halve(double* first_hi, double* first_lo, double* second_hi, double* second_lo, const Runs& runs) {
  const std::size_t n = runs.n, width = runs.width, stride = runs.stride;
  for (std::size_t r = 0; r < runs.count; ++r) {
    double *__restrict a = first_hi + r * runs.step, *__restrict b = second_hi + r * runs.step;
    double *__restrict al = first_lo + r * runs.step, *__restrict bl = second_lo + r * runs.step;
    for (std::size_t round = 1; round <= n; ++round) {
      std::memcpy(b + (n - round) * stride, a + (n - 1) * stride, width * sizeof(double));
      std::memcpy(bl + (n - round) * stride, al + (n - 1) * stride, width * sizeof(double));
      for (std::size_t i = n - 1; i >= round; --i) {
        double *__restrict hi = a + i * stride, *__restrict lo = al + i * stride;
        const double *__restrict from_hi = hi - stride, *__restrict from_lo = lo - stride;
        for (std::size_t m = 0; m < width; ++m) {
          // The exact sum of the high parts; those of the low ones are rounded once.
          const double x = from_hi[m], y = hi[m], s = x + y, t = s - x, e = ((x - (s - t)) + (y - t)) + (from_lo[m] + lo[m]), u = s + e;
          hi[m] = 0.5 * u;
          lo[m] = 0.5 * (e - (u - s));
        }
      }
    }
  }
}

IRT_WIDEST Extent extent_of(const double* values, std::size_t n) {
  constexpr std::size_t kChains = 4;  // comparisons take several cycles, and may overlap
  Lanes low[kChains], high[kChains];
  for (std::size_t c = 0; c < kChains; ++c) low[c] = high[c] = *reinterpret_cast<const Lanes*>(values);
  std::size_t i = 0;
  const auto look = [&](std::size_t c, std::size_t at) {
    const Lanes v = *reinterpret_cast<const Lanes*>(values + at);
    low[c] = v < low[c] ? v : low[c];
    high[c] = v > high[c] ? v : high[c];
  };
  for (; i + kChains * kLanes <= n; i += kChains * kLanes)
    for (std::size_t c = 0; c < kChains; ++c) look(c, i + c * kLanes);
  for (; i < n; i += kLanes) look(0, i);
  Extent e{low[0][0], high[0][0]};
  for (std::size_t c = 0; c < kChains; ++c)
    for (std::size_t k = 0; k < kLanes; ++k) e = {std::min(e.lowest, low[c][k]), std::max(e.highest, high[c][k])};
  return e;
}

IRT_WIDEST Steps steps_of(const double* values, std::size_t n, std::size_t stride) {
  const Lanes none = {}, endless = none + HUGE_VAL;
  Lanes least = endless, most = -endless, slowest = endless;
  for (std::size_t i = 0; i + stride < n; i += kLanes) {
    const Lanes a = *reinterpret_cast<const Lanes*>(values + i), b = *reinterpret_cast<const Lanes*>(values + i + stride), step = b - a;
    least = step < least ? step : least;
    most = step > most ? step : most;
    const Lanes size = step < none ? -step : step, changed = ((a < none) != (b < none)) ? size : endless;
    slowest = changed < slowest ? changed : slowest;
  }
  Steps s{least[0], most[0], slowest[0]};
  for (std::size_t k = 1; k < kLanes; ++k) s = {std::min(s.least, least[k]), std::max(s.most, most[k]), std::min(s.slowest, slowest[k])};
  return s;
}

// Whole vectors: what a line writes beyond its end the next one overwrites.
IRT_WIDEST void pack(const double* from, std::size_t lines, std::size_t n, std::size_t m, double scale, float* to) {
  typedef float Floats __attribute__((vector_size(sizeof(float) * kLanes), aligned(alignof(float)), may_alias));
  for (std::size_t line = 0; line < lines; ++line, from += m, to += n)
    for (std::size_t i = 0; i < n; i += kLanes)
      *reinterpret_cast<Floats*>(to + i) = __builtin_convertvector(*reinterpret_cast<const Lanes*>(from + i) * scale, Floats);
}

IRT_WIDEST void pack(const double* from, std::size_t lines, std::size_t n, std::size_t m, double scale, double* to) {
  for (std::size_t line = 0; line < lines; ++line, from += m, to += n)
    for (std::size_t i = 0; i < n; i += kLanes) *reinterpret_cast<Lanes*>(to + i) = *reinterpret_cast<const Lanes*>(from + i) * scale;
}

}  // namespace irt::numerics
