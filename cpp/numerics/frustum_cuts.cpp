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

// The extent of all values that it looks at.
class Range {
 public:
  [[gnu::always_inline]] void look(const Lanes& v) {
    low_ = v < low_ ? v : low_;
    high_ = v > high_ ? v : high_;
  }
  [[gnu::always_inline]] void look(const Range& other) {
    low_ = other.low_ < low_ ? other.low_ : low_;
    high_ = other.high_ > high_ ? other.high_ : high_;
  }
  [[gnu::always_inline]] Extent extent() const {
    Extent e{low_[0], high_[0]};
    for (std::size_t k = 1; k < kLanes; ++k) e = {std::min(e.lowest, low_[k]), std::max(e.highest, high_[k])};
    return e;
  }

 private:
  Lanes low_ = Lanes{} + HUGE_VAL, high_ = Lanes{} - HUGE_VAL;
};

// Where nobody asks for it.
struct NoRange {
  [[gnu::always_inline]] void look(const Lanes&) {}
};

// All rounds on n runs of kVectors vectors each, `stride` doubles apart.
template <std::size_t kVectors, typename AnyRange>
[[gnu::always_inline]] inline void rounds(double* a, double* b, std::size_t n, std::size_t stride, std::size_t vectors, AnyRange& first, AnyRange& second) {
  const std::size_t count = kVectors ? kVectors : vectors;
  const Lanes half = Lanes{} + 0.5;
  for (std::size_t round = 1; round <= n; ++round) {
    const Lanes* last = reinterpret_cast<const Lanes*>(a + (n - 1) * stride);
    Lanes* kept = reinterpret_cast<Lanes*>(b + (n - round) * stride);
    for (std::size_t m = 0; m < count; ++m) second.look(kept[m] = last[m]);
    for (std::size_t i = n - 1; i >= round; --i) {
      Lanes* to = reinterpret_cast<Lanes*>(a + i * stride);
      const Lanes* from = reinterpret_cast<const Lanes*>(a + (i - 1) * stride);
      for (std::size_t m = 0; m < count; ++m) to[m] = half * (from[m] + to[m]);
    }
    const Lanes* done = reinterpret_cast<const Lanes*>(a + (round - 1) * stride);
    for (std::size_t m = 0; m < count; ++m) first.look(done[m]);
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
template <std::size_t kCount, typename AnyRange>
[[gnu::always_inline]] inline void rounds(double* a, double* b, std::size_t stride, AnyRange& first, AnyRange& second) {
  Lanes v[kCount];
#pragma GCC unroll 16
  for (std::size_t i = 0; i < kCount; ++i) v[i] = *reinterpret_cast<const Lanes*>(a + i * stride);
#pragma GCC unroll 16
  for (std::size_t round = 0; round < kCount; ++round) {
    second.look(*reinterpret_cast<Lanes*>(b + (kCount - 1 - round) * stride) = v[kCount - 1] * kHalves[round]);
#pragma GCC unroll 16
    for (std::size_t i = kCount - 1; i > round; --i) v[i] += v[i - 1];
  }
  first.look(v[0]);
#pragma GCC unroll 16
  for (std::size_t i = 1; i < kCount; ++i) first.look(*reinterpret_cast<Lanes*>(a + i * stride) = v[i] * kHalves[i]);
}

template <std::size_t kCount, typename AnyRange>
[[gnu::always_inline]] inline void all_rounds(double* first, double* second, const Runs& runs, AnyRange& of_first, AnyRange& of_second) {
  for (std::size_t r = 0; r < runs.count; ++r)
    for (std::size_t m = 0; m < runs.width; m += kLanes) rounds<kCount>(first + r * runs.step + m, second + r * runs.step + m, runs.stride, of_first, of_second);
}

template <typename AnyRange>
[[gnu::always_inline]] inline void halve(double* first, double* second, const Runs& runs, AnyRange& of_first, AnyRange& of_second) {
  const std::size_t vectors = runs.width / kLanes;
  switch (runs.n) {
    case 2: return all_rounds<2>(first, second, runs, of_first, of_second);
    case 3: return all_rounds<3>(first, second, runs, of_first, of_second);
    case 4: return all_rounds<4>(first, second, runs, of_first, of_second);
    case 5: return all_rounds<5>(first, second, runs, of_first, of_second);
    case 6: return all_rounds<6>(first, second, runs, of_first, of_second);
    case 7: return all_rounds<7>(first, second, runs, of_first, of_second);
    case 8: return all_rounds<8>(first, second, runs, of_first, of_second);
    case 9: return all_rounds<9>(first, second, runs, of_first, of_second);
    case 10: return all_rounds<10>(first, second, runs, of_first, of_second);
    case 11: return all_rounds<11>(first, second, runs, of_first, of_second);
    case 12: return all_rounds<12>(first, second, runs, of_first, of_second);
    case 13: return all_rounds<13>(first, second, runs, of_first, of_second);
    case 14: return all_rounds<14>(first, second, runs, of_first, of_second);
    case 15: return all_rounds<15>(first, second, runs, of_first, of_second);
    default:
      for (std::size_t r = 0; r < runs.count; ++r) {
        double *a = first + r * runs.step, *b = second + r * runs.step;
        switch (vectors) {
          case 4: rounds<4>(a, b, runs.n, runs.stride, 4, of_first, of_second); break;
          case 5: rounds<5>(a, b, runs.n, runs.stride, 5, of_first, of_second); break;
          default: rounds<0>(a, b, runs.n, runs.stride, vectors, of_first, of_second);
        }
      }
  }
}

}  // namespace

IRT_WIDEST Halves halve(double* first, double* second, const Runs& runs) {
  Range of_first, of_second;
  halve(first, second, runs, of_first, of_second);
  return {of_first.extent(), of_second.extent()};
}

IRT_WIDEST void halve_unseen(double* first, double* second, const Runs& runs) {
  NoRange none;
  halve(first, second, runs, none, none);
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
  Range chains[kChains];
  const auto look = [&](std::size_t c, std::size_t at) { chains[c].look(*reinterpret_cast<const Lanes*>(values + at)); };
  std::size_t i = 0;
  for (; i + kChains * kLanes <= n; i += kChains * kLanes)
    for (std::size_t c = 0; c < kChains; ++c) look(c, i + c * kLanes);
  for (; i + kLanes <= n; i += kLanes) look(0, i);
  if (i < n) look(0, n - kLanes);
  for (std::size_t c = 1; c < kChains; ++c) chains[0].look(chains[c]);
  return chains[0].extent();
}

IRT_WIDEST Extent steps_of(const double* values, const Runs& runs) {
  Range steps;
  for (std::size_t r = 0; r < runs.count; ++r)
    for (std::size_t m = 0; m < runs.width; m += kLanes) {
      const double* at = values + r * runs.step + m;
      for (std::size_t i = 1; i < runs.n; ++i, at += runs.stride) steps.look(*reinterpret_cast<const Lanes*>(at + runs.stride) - *reinterpret_cast<const Lanes*>(at));
    }
  return steps.extent();
}

IRT_WIDEST double slowest_change(const double* values, const Runs& runs) {
  const Lanes none = {}, endless = none + HUGE_VAL;
  Lanes slowest = endless;
  for (std::size_t r = 0; r < runs.count; ++r)
    for (std::size_t m = 0; m < runs.width; m += kLanes) {
      const double* at = values + r * runs.step + m;
      Lanes a = *reinterpret_cast<const Lanes*>(at);
      for (std::size_t i = 1; i < runs.n; ++i) {
        const Lanes b = *reinterpret_cast<const Lanes*>(at += runs.stride), step = b - a, back = -step, size = step > back ? step : back;
        const Lanes changed = ((a < none) != (b < none)) ? size : endless;
        slowest = changed < slowest ? changed : slowest;
        a = b;
      }
    }
  double least = slowest[0];
  for (std::size_t k = 1; k < kLanes; ++k) least = std::min(least, slowest[k]);
  return least;
}

IRT_WIDEST std::size_t winding(const double* values, const Runs& runs) {
  const Lanes none = {}, one = none + 1;
  Lanes winding = none;
  for (std::size_t r = 0; r < runs.count; ++r)
    for (std::size_t m = 0; m < runs.width; m += kLanes) {
      const double* at = values + r * runs.step + m;
      Lanes a = *reinterpret_cast<const Lanes*>(at), changes = none;
      for (std::size_t i = 1; i < runs.n; ++i) {
        const Lanes b = *reinterpret_cast<const Lanes*>(at += runs.stride);
        changes += ((a < none) != (b < none)) ? one : none;
        a = b;
      }
      winding += changes > one ? one : none;
    }
  double sum = 0;
  for (std::size_t k = 0; k < kLanes; ++k) sum += winding[k];
  return static_cast<std::size_t>(sum);
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
