// render_frame: a camera's rays as terms per column and per row, computed here in long double, and the passes.
#include <cmath>

#include "render/launch.h"

namespace irt::render {
namespace {

using program::Precision;
using vec = glm::vec<3, long double>;

constexpr int kTerms = 8;  // P, D, share of |D|^2, tau

// Rays of `view` relative to the plane through the middle of the bounds (kernels/ray_camera.cl).
class CameraTerms {
 public:
  CameraTerms(const View& view, const Bounds& bounds, Precision wide, int width)
      : column_stride((view.columns + width - 1) / width * width),
        row_stride(view.rows),
        columns(wide, kTerms * column_stride),
        rows(wide, kTerms * row_stride) {
    const vec origin(view.origin), right(view.right), up(view.up), forward(view.forward);
    const long double distance = glm::dot(vec(bounds.center()) - origin, forward);
    tau = static_cast<double>(distance);
    const long double half = view.perspective ? view.tan_half_fov : 0.5 * view.height;
    const long double aspect = static_cast<long double>(view.columns) / view.rows;
    const vec middle = origin + distance * forward;
    const long double spread = view.perspective ? distance : 1;
    long double widest = 0;
    for (std::size_t i = 0; i < column_stride; ++i) {
      // Lanes past the last column repeat it.
      const std::size_t column = std::min<std::size_t>(i, view.columns - 1);
      const long double sx = (2 * (column + 0.5L) / view.columns - 1) * half * aspect;
      const vec p = spread * sx * right, d = view.perspective ? sx * right : vec(0);
      for (int k = 0; k < 3; ++k) {
        columns.set(k * column_stride + i, static_cast<double>(p[k]));
        columns.set((3 + k) * column_stride + i, static_cast<double>(d[k]));
      }
      columns.set(6 * column_stride + i, view.perspective ? static_cast<double>(sx * sx) : 0);
      widest = std::max(widest, std::fabs(sx));
    }
    for (std::size_t row = 0; row < row_stride; ++row) {
      const long double sy = (1 - 2 * (row + 0.5L) / view.rows) * half;
      const vec p = middle + spread * sy * up, d = view.perspective ? forward + sy * up : forward;
      for (int k = 0; k < 3; ++k) {
        rows.set(k * row_stride + row, static_cast<double>(p[k]));
        rows.set((3 + k) * row_stride + row, static_cast<double>(d[k]));
      }
      rows.set(6 * row_stride + row, view.perspective ? static_cast<double>(1 + sy * sy) : 1);
      rows.set(7 * row_stride + row, tau);
      widest = std::max(widest, std::fabs(sy));
    }
    // The basis itself is known to about a double's precision.
    pad = static_cast<double>(4e-16L * (glm::length(origin) + std::fabs(distance) * (1 + 2 * widest) + 2 * widest));
  }

  std::size_t column_stride, row_stride;
  Reals columns, rows;
  double tau, pad;
};

kernel::Spec spec_of(const program::Program& program, const Bounds& bounds, const Options& options,
                     const device::Device& device, Precision precision, kernel::Entry entry) {
  kernel::Spec spec;
  spec.entry = entry;
  spec.precision = precision;
  spec.width = packet_width(device, precision);
  spec.split = splits(device, options, precision);
  spec.spheres = static_cast<int>(bounds.balls.size());
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
    list.emplace(2 * answer.pitch * sizeof(std::int32_t));
    for (std::size_t k = 0; k < answer.pitch; ++k) {
      const std::size_t i = (*pixels)[std::min(k, pixels->size() - 1)];
      list->as<std::int32_t>()[2 * k] = static_cast<std::int32_t>(i % pitch);
      list->as<std::int32_t>()[2 * k + 1] = static_cast<std::int32_t>(i / pitch);
    }
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
