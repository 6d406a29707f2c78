// apply_clip: the clip formula over brackets, by the kernel of `enclose`.
#include "render/frustum_clip.h"

#include <cmath>

#include "render/decide.h"
#include "render/passes.h"

namespace irt::render {
namespace {

using RaysOf = std::function<std::vector<numerics::Ray>(const std::vector<std::size_t>&)>;
using Search = std::function<Answer(const std::vector<std::size_t>&)>;

// A box around the bracket of element i on its ray, as enclose_pieces takes it; rounding outward to floats is left to a pad where those will be used.
std::array<double, 9> box_of(const Answer& answer, std::size_t i, const numerics::Ray& ray, const Options& options, bool wide) {
  const double t = answer.depth_at(i), known = answer.uncertainty_at(i);
  const double half = std::isnan(known) ? 0.5 * options.eps : known;
  std::array<double, 9> box{};
  for (int k = 0; k < 3; ++k) {
    // Some roundings of the coordinate, and that to the kernel's reals.
    const double pad = (4e-15 + (wide ? 0 : 1.2e-7)) * (std::fabs(ray.origin[k]) + t * glm::length(ray.direction)), reach = half * std::fabs(ray.direction[k]) + pad;
    box[3 * k] = ray.origin[k] + t * ray.direction[k] - reach;
    box[3 * k + 1] = ray.origin[k] + t * ray.direction[k] + reach;
  }
  return box;
}

void judge(Answer& answer, const Formulas& formulas, const Options& options, device::Device& device, const RaysOf& rays_at, const Search& search) {
  widen(answer);
  std::vector<std::size_t> hits, again;
  for (std::size_t row = 0; row < answer.rows; ++row)
    for (std::size_t column = 0; column < answer.columns; ++column) {
      const std::size_t i = row * answer.pitch + column;
      const unsigned char status = answer.status->as<unsigned char>()[i];
      if (status == 1) hits.push_back(i);
      if (status > 1) again.push_back(i);
    }
  const bool wide = device.info().fp64;
  std::vector<std::array<double, 9>> boxes;
  const std::vector<numerics::Ray> rays = rays_at(hits);
  for (std::size_t k = 0; k < hits.size(); ++k) boxes.push_back(box_of(answer, hits[k], rays[k], options, wide));
  const program::Program region = program::lower(*formulas.g);
  Options by_range = options;
  by_range.affine = false;
  by_range.outward = true;
  by_range.precision = wide ? PrecisionMode::Double : PrecisionMode::Single;
  by_range.parameters.clear();
  for (const std::string& name : region.parameters) by_range.parameters.push_back(formulas.parameters.at(name));
  // Where g may be undefined its range alone says nothing.
  const bool partial = region[region.result].partial;
  const auto ranges = enclose_pieces(region, boxes, {}, by_range, device);
  for (std::size_t k = 0; k < hits.size(); ++k)
    if (partial || !(ranges[k][1] <= 0)) again.push_back(hits[k]);
  if (again.empty()) return;
  const std::size_t escalated = answer.escalated;
  const Answer part = search(again);
  scatter(answer, part, again, options);
  answer.escalated = escalated + part.escalated;
}

}  // namespace

void apply_clip(Answer& answer, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options, device::Device& device) {
  judge(answer, formulas, options, device, [&](const std::vector<std::size_t>& hits) { return rays_of(view, hits, answer.pitch); },
        [&](const std::vector<std::size_t>& again) { return camera_passes(program, formulas, view, bounds, contracting(options), device, &again, answer.pitch); });
}

void apply_clip(Answer& answer, const program::Program& program, const Formulas& formulas, const Rays& rays, const Bounds& bounds, const Options& options, device::Device& device) {
  const auto search = [&](const std::vector<std::size_t>& again) {
    std::vector<double> origins, directions, tmin, tmax;
    for (const std::size_t i : again) {
      origins.insert(origins.end(), rays.origins + 3 * i, rays.origins + 3 * i + 3);
      directions.insert(directions.end(), rays.directions + 3 * i, rays.directions + 3 * i + 3);
      tmin.push_back(rays.tmin[i]);
      tmax.push_back(rays.tmax[i]);
    }
    return trace_rays(program, formulas, {origins.data(), directions.data(), tmin.data(), tmax.data(), again.size()}, bounds, contracting(options), device);
  };
  judge(answer, formulas, options, device, [&](const std::vector<std::size_t>& hits) { return rays_of(rays, hits); }, search);
}

}  // namespace irt::render
