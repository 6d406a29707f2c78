// See ray_terms.h.
#include "render/ray_terms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"

namespace irt::render {
namespace {

using program::Precision;
using vec = glm::vec<3, long double>;

constexpr std::size_t kTerms = 12;  // P, D, tau, length, near_out, near_in, far_out, far_in (kernels/ray_list.cl)

vec vector(const double* p) { return {p[0], p[1], p[2]}; }

}  // namespace

RayTerms make_terms(const Rays& rays, const std::vector<std::size_t>* which, std::size_t count, std::size_t padded,
                    const Bounds& bounds, Precision precision, bool split) {
  RayTerms out{Reals(split ? Precision::Double : precision, kTerms * padded, precision), 0, {}, {}};
  const vec center(bounds.center());
  long double farthest = 0;
  const double largest = precision == Precision::Double ? 1e150 : 1e18;
  for (std::size_t k = 0; k < padded; ++k) {
    const std::size_t j = std::min(k, count - 1), i = which ? (*which)[j] : j;
    const vec o = vector(rays.origins + 3 * i), d = vector(rays.directions + 3 * i);
    const long double size = std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    int exponent;
    std::frexp(size, &exponent);
    // |D| lies in [1, 2 sqrt 3): s counts lengths of at least one.
    const long double scale = std::ldexp(1.0L, 1 - exponent);
    const vec D = d * scale;
    const long double nearest = glm::dot(center - o, D) / glm::dot(D, D);  // in units of D
    const vec P = o + nearest * D;
    if (!(size < largest && size > 1 / largest))
      throw ArgumentError(fmt::format("ray {}: its direction is {} long; that must lie between {} and {} in this precision", i, static_cast<double>(size), 1 / largest, largest));
    if (!(std::fabs(nearest) < largest))
      throw ArgumentError(fmt::format("ray {}: its origin is {} away from the bounds; that must be less than {} in this precision", i,
                                      static_cast<double>(std::fabs(nearest) * glm::length(D)), largest));
    for (int axis = 0; axis < 3; ++axis) {
      out.terms.set(axis * padded + k, static_cast<double>(P[axis]));
      out.terms.set((3 + axis) * padded + k, static_cast<double>(D[axis]));
    }
    out.nearest.push_back(nearest);
    out.scale.push_back(scale);
    out.terms.set(6 * padded + k, static_cast<double>(nearest));
    out.terms.set(7 * padded + k, static_cast<double>(scale));
    const long double near = rays.tmin[i] / scale - nearest, far = rays.tmax[i] / scale - nearest;
    out.terms.set_below(8 * padded + k, static_cast<double>(near));
    out.terms.set_above(9 * padded + k, static_cast<double>(near));
    out.terms.set_above(10 * padded + k, static_cast<double>(far));
    out.terms.set_below(11 * padded + k, static_cast<double>(far));
    farthest = std::max(farthest, glm::length(o) + std::fabs(nearest) * 2 * std::sqrt(3.0L));
  }
  out.pad = static_cast<double>(farthest * 1e-18L);
  return out;
}

}  // namespace irt::render
