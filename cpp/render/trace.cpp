// trace_rays: any batch of rays, each moved in long double to its point nearest the middle of the bounds.
#include <fmt/format.h>

#include <cmath>

#include "error.h"
#include "render/launch.h"

namespace irt::render {
namespace {

using program::Precision;
using vec = glm::vec<3, long double>;

constexpr std::size_t kTerms = 12;  // P, D, tau, length, near_out, near_in, far_out, far_in (kernels/ray_list.cl)
// One launch of many rows keeps launches short enough to be interrupted.
constexpr std::size_t kRow = 4096;

vec vector(const double* p) { return {p[0], p[1], p[2]}; }

struct RayTerms {
  Reals terms;
  double pad = 0;
};

RayTerms make_terms(const Rays& rays, const std::vector<std::size_t>* which, std::size_t count, std::size_t padded,
                    const Bounds& bounds, Precision precision, bool split) {
  RayTerms out{Reals(split ? Precision::Double : precision, kTerms * padded, precision)};
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
    if (!(size < largest && size > 1 / largest) || !(std::fabs(nearest) < largest))
      throw ArgumentError(fmt::format("ray {}: its direction is {} long and its origin {} lengths away; both must lie within {} and {} "
                                      "in this precision", i, static_cast<double>(size), static_cast<double>(std::fabs(nearest)), 1 / largest, largest));
    for (int axis = 0; axis < 3; ++axis) {
      out.terms.set(axis * padded + k, static_cast<double>(P[axis]));
      out.terms.set((3 + axis) * padded + k, static_cast<double>(D[axis]));
    }
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

kernel::Spec spec_of(const program::Program& program, const Bounds& bounds, const Options& options, const device::Device& device,
                     Precision precision) {
  kernel::Spec spec;
  spec.entry = kernel::Entry::RayList;
  spec.precision = precision;
  spec.width = packet_width(device, precision);
  spec.split = splits(device, options, precision);
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  spec.infinite = needs_infinities(program, 2.0 * glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper)), options, precision);
  return with_options(spec, options);
}

Answer pass(const program::Program& program, const Rays& rays, const std::vector<std::size_t>* which, const Bounds& bounds,
            const Options& options, device::Device& device, Precision precision) {
  const kernel::Spec spec = spec_of(program, bounds, options, device, precision);
  const std::size_t count = which ? which->size() : rays.count;
  Answer answer = make_answer(count, 1, spec.width, precision, options);
  const RayTerms terms = make_terms(rays, which, count, answer.pitch, bounds, precision, spec.split);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, 0);
  const auto buffer = terms.terms.buffer(device);
  launch(program, spec, {buffer.get(), static_cast<std::int32_t>(answer.pitch)}, settings, {}, options, device, answer);
  return answer;
}

}  // namespace

Answer trace_rays(const program::Program& program, const Rays& rays, const Bounds& bounds, const Options& options,
                  device::Device& device) {
  const Precision first = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  if (rays.count == 0) return make_answer(0, 1, packet_width(device, first), first, options);
  const bool second = options.precision == PrecisionMode::Auto && device.info().fp64;
  if (second && program.inputs()) prepare(program, spec_of(program, bounds, options, device, Precision::Double), device);
  Answer answer = pass(program, rays, nullptr, bounds, options, device, first);
  if (!second || answer.outcome != device::Outcome::done) return answer;
  const auto open = undecided(answer, options);
  if (!open.empty()) scatter(answer, pass(program, rays, &open, bounds, options, device, Precision::Double), open);
  return answer;
}

}  // namespace irt::render
