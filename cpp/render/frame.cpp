// render_frame: a camera's rays as terms per column and per row, computed here in long double, and the passes.
#include "render/camera_terms.h"
#include "render/launch.h"

namespace irt::render {
namespace {

using program::Precision;

kernel::Spec spec_of(const program::Program& program, const Bounds& bounds, const Options& options,
                     const device::Device& device, Precision precision, kernel::Entry entry) {
  kernel::Spec spec;
  spec.entry = entry;
  spec.precision = precision;
  spec.width = packet_width(device, precision);
  spec.split = splits(device, options, precision);
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  // Brackets may reach a little out of the bounds.
  spec.infinite = needs_infinities(program, 2.0 * glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper)), options, precision);
  return with_options(spec, options);
}

Answer pass(const program::Program& program, const View& view, const Bounds& bounds, const Options& options,
            device::Device& device, Precision precision, const std::vector<std::size_t>* pixels, std::size_t pitch) {
  const kernel::Spec spec = spec_of(program, bounds, options, device, precision,
                                    pixels ? kernel::Entry::PixelList : kernel::Entry::Camera);
  const CameraTerms terms(view, bounds, spec.split ? Precision::Double : precision, spec.width);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, -terms.tau);
  Answer answer = pixels ? make_answer(pixels->size(), 1, spec.width, precision, options)
                         : make_answer(view.columns, view.rows, spec.width, precision, options);
  const auto columns = terms.columns.buffer(device), rows = terms.rows.buffer(device);
  std::vector<device::Arg> inputs{columns.get(), rows.get(), static_cast<std::int32_t>(terms.column_stride),
                                  static_cast<std::int32_t>(terms.row_stride)};
  std::optional<Memory> list;
  std::unique_ptr<device::Buffer> list_buffer;
  if (pixels) {
    list = pixel_list(*pixels, answer.pitch, pitch);
    list_buffer = device.buffer(list->data(), list->bytes(), device::Access::read);
    inputs.emplace_back(list_buffer.get());
  }
  launch(program, spec, std::move(inputs), settings, options, device, answer);
  return answer;
}

}  // namespace

Answer render_frame(const program::Program& program, const View& view, const Bounds& bounds, const Options& options,
                    device::Device& device) {
  const Precision first = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  // With parameters the second pass may be needed at any move of a slider, which should compile nothing.
  const bool second = options.precision == PrecisionMode::Auto && device.info().fp64;
  if (second && program.inputs())
    prepare(program, spec_of(program, bounds, options, device, Precision::Double, kernel::Entry::PixelList), device);
  Answer answer = pass(program, view, bounds, options, device, first, nullptr, 0);
  if (!second || answer.outcome != device::Outcome::done) return answer;
  const auto open = undecided(answer, options);
  if (!open.empty())
    scatter(answer, pass(program, view, bounds, options, device, Precision::Double, &open, answer.pitch), open);
  return answer;
}

std::string frame_source(const program::Program& program, const Bounds& bounds, const Options& options,
                         const device::Device& device) {
  const Precision precision = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  return kernel::assemble(program, spec_of(program, bounds, options, device, precision, kernel::Entry::Camera));
}

}  // namespace irt::render
