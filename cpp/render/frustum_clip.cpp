// apply_clip: the clip formula over brackets, by the kernel of `enclose`.
#include "render/frustum_clip.h"

#include <cmath>

#include "render/passes.h"

namespace irt::render {
namespace {

// A box around the bracket of pixel i, as enclose_pieces takes it; rounding outward to floats is left to a pad where those will be used.
std::array<double, 9> box_of(const Answer& answer, std::size_t i, const View& view, const Options& options, bool wide) {
  const double t = answer.depth_at(i), known = answer.uncertainty_at(i);
  const double half = std::isnan(known) ? 0.5 * options.eps : known;
  const double scale = view.perspective ? view.tan_half_fov : 0.5 * view.height, aspect = static_cast<double>(view.columns) / view.rows;
  const double sx = (2 * (i % answer.pitch + 0.5 + view.right_by) / view.columns - 1) * scale * aspect,
               sy = (1 - 2 * (i / answer.pitch + 0.5 + view.down_by) / view.rows) * scale;
  const glm::dvec3 off = sx * view.right + sy * view.up;
  const glm::dvec3 origin = view.perspective ? view.origin : view.origin + off;
  const glm::dvec3 direction = view.perspective ? glm::normalize(view.forward + off) : view.forward;
  std::array<double, 9> box{};
  for (int k = 0; k < 3; ++k) {
    // Some ten roundings on the way to the coordinate, and that to the kernel's reals.
    const double pad = (4e-15 + (wide ? 0 : 1.2e-7)) * (std::fabs(view.origin[k]) + std::fabs(off[k]) + t), reach = half * std::fabs(direction[k]) + pad;
    box[3 * k] = origin[k] + t * direction[k] - reach;
    box[3 * k + 1] = origin[k] + t * direction[k] + reach;
  }
  return box;
}

}  // namespace

void apply_clip(Answer& answer, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options, device::Device& device) {
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
  for (const std::size_t i : hits) boxes.push_back(box_of(answer, i, view, options, wide));
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
  Options march = options;
  march.finder = "contract";
  march.affine = true;
  const std::size_t escalated = answer.escalated;
  const Answer part = camera_passes(program, formulas, view, bounds, march, device, &again, answer.pitch);
  scatter(answer, part, again, options);
  answer.escalated = escalated + part.escalated;
}

}  // namespace irt::render
