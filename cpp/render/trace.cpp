// trace_rays: any batch of rays, and a second pass in double for what single precision leaves open.
#include "render/decide.h"
#include "render/ray_terms.h"

namespace irt::render {
namespace {

using program::Precision;

Answer pass(const program::Program& program, const Rays& rays, const std::vector<std::size_t>* which, const Bounds& bounds,
            const Options& options, device::Device& device, Precision precision) {
  const kernel::Spec spec = spec_of(program, bounds, options, device, precision, kernel::Entry::RayList);
  const std::size_t count = which ? which->size() : rays.count;
  Answer answer = make_answer(count, 1, spec.width, precision, options);
  const RayTerms terms = make_terms(rays, which, count, answer.pitch, bounds, precision, spec.split);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, 0);
  const auto buffer = terms.terms.buffer(device);
  launch(program, spec, {buffer.get(), static_cast<std::int32_t>(answer.pitch)}, settings, {}, options, device, answer);
  return answer;
}

}  // namespace

Answer trace_rays(const program::Program& program, const Formulas& formulas, const Rays& rays, const Bounds& given, const Options& options,
                  device::Device& device) {
  const Precision first = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  if (rays.count == 0) return make_answer(0, 1, packet_width(device, first), first, options);
  const Bounds bounds = narrowed(given, formulas, options);
  const bool second = options.precision == PrecisionMode::Auto && device.info().fp64;
  Answer answer = pass(program, rays, nullptr, bounds, options, device, first);
  if (!second || answer.outcome != device::Outcome::done) return answer;
  const Second again{
      [&](const std::vector<std::size_t>& open) { return decide_rays(answer, open, rays, formulas, query_of(formulas, bounds, options, true), options); },
      [&](const std::vector<std::size_t>& open) { return pass(program, rays, &open, bounds, options, device, Precision::Double); },
      [&] { return prepare(program, spec_of(program, bounds, options, device, Precision::Double, kernel::Entry::RayList), device); }};
  decide_open(answer, program, again, options);
  return answer;
}

}  // namespace irt::render
