// enclose_pieces: bounds of f, or of its derivative, over boxes and pieces of rays, from the very functions that the tracer runs.
#include <cmath>

#include "error.h"
#include "render/launch.h"

namespace irt::render {

using program::Precision;

std::vector<std::array<double, 2>> enclose_pieces(const program::Program& program, std::span<const std::array<double, 9>> pieces,
                                                  std::span<const std::array<double, 9>> directions, const Options& options,
                                                  device::Device& device) {
  std::vector<std::array<double, 2>> result(pieces.size());
  if (pieces.empty()) return result;
  const Precision precision = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  kernel::Spec spec;
  spec.entry = kernel::Entry::Enclose;
  spec.affine = options.affine;
  spec.outward = options.outward;
  spec.precision = precision;
  spec.width = packet_width(device, precision);
  glm::dvec3 largest(0);
  for (const auto& all : {pieces, directions})
    for (const auto& piece : all)
      for (int axis = 0; axis < 3; ++axis) {
        const double* c = &piece[3 * axis];
        const double m = options.affine ? std::fabs(c[0]) + std::fabs(c[1]) + c[2] : std::max(std::fabs(c[0]), std::fabs(c[1]));
        largest[axis] = std::max(largest[axis], m);
      }
  spec.infinite = needs_infinities(program, largest, options, precision);
  spec.along = !directions.empty();
  if (spec.along) {
    const auto derivative = program::along(program);
    if (!derivative) throw MethodError("no rule gives the derivative of a power so near to 1");
    spec.infinite = spec.infinite || needs_infinities(*derivative, largest, options, precision);
  }
  spec.slack = options.bare && options.outward && !spec.infinite && !spec.along;
  const std::size_t stride = (pieces.size() + spec.width - 1) / spec.width * spec.width;
  Reals coordinates(precision, (spec.along ? 18 : 9) * stride), lower(precision, stride), upper(precision, stride);
  for (std::size_t i = 0; i < stride; ++i)
    for (std::size_t k = 0; k < 9; ++k) {
      const std::size_t from = std::min(i, pieces.size() - 1);
      coordinates.set(k * stride + i, pieces[from][k]);
      if (spec.along) coordinates.set((9 + k) * stride + i, directions[from][k]);
    }
  const auto kernel = device.kernel(kernel::assemble(program, spec), kernel::entry_name(spec.entry));
  const auto in = coordinates.buffer(device), lo = lower.buffer(device, device::Access::write),
             hi = upper.buffer(device, device::Access::write);
  std::vector<device::Arg> args{in.get(), static_cast<std::int32_t>(stride), lo.get(), hi.get()};
  const Reals parameters = parameter_ends(program, options, precision);
  const auto p = parameters.buffer(device);
  if (program.inputs()) args.emplace_back(p.get());
  device.run(*kernel, args, stride / spec.width, 1, options.control, nullptr);
  device.read({lo.get(), hi.get()});
  for (std::size_t i = 0; i < pieces.size(); ++i) result[i] = {lower.get(i), upper.get(i)};
  return result;
}

}  // namespace irt::render
