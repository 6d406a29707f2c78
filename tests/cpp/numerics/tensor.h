// Values of tensors of coefficients, for the tests of the frustum form.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "numerics/frustum_reduce.h"

namespace irt::numerics {

using Basis = void (*)(double, std::size_t, double*, double*);

// The sum of [down][depth][across], lines across `padded` apart, times the three bases' values.
template <typename Real, typename Line>
auto sum_of(const Real* c, const Line& down, const Line& depth, const Line& across, std::size_t padded) {
  typename Line::value_type sum = 0;
  for (std::size_t j = 0; j < down.size(); ++j)
    for (std::size_t k = 0; k < depth.size(); ++k)
      for (std::size_t i = 0; i < across.size(); ++i) sum += down[j] * depth[k] * across[i] * c[(j * depth.size() + k) * padded + i];
  return sum;
}

// The value at three places from 0 to 1, by Bernstein's basis along the depth.
template <typename Real>
double value(const Real* c, std::size_t down, std::size_t depth, std::size_t across, std::size_t padded, Basis basis, const double* at) {
  std::vector<double> v(down), s(depth), u(across), slopes(std::max({down, depth, across}));
  basis(at[0], down, v.data(), slopes.data());
  bernstein_at(at[1], depth, s.data(), slopes.data());
  basis(at[2], across, u.data(), slopes.data());
  return sum_of(c, v, s, u, padded);
}

}  // namespace irt::numerics
