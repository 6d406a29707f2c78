// render_frame: the passes in single and double, and what follows them: normals from neighbours, anti-aliasing.
#include <algorithm>
#include <limits>

#include "render/camera_terms.h"
#include "render/decide.h"
#include "render/passes.h"

namespace irt::render {
namespace {

using program::Precision;

// Kernels with beams take a quarter longer to compile (0.1 s) and half as long to run: frames of more pixels have them.
constexpr std::size_t kBeamPixels = 640 * 480;

bool beams_in(const Options& options, std::size_t pixels) {
  return options.finder == "contract" && options.affine && options.beams.value_or(pixels > kBeamPixels);
}

Answer pass(const program::Program& program, const View& view, const Bounds& bounds, const Options& options, device::Device& device,
            Precision precision, const std::vector<std::size_t>* pixels, std::size_t pitch, std::optional<Answer> before = {}) {
  kernel::Spec spec = spec_of(program, bounds, options, device, precision, pixels ? kernel::Entry::PixelList : kernel::Entry::Camera);
  spec.sharpens = before.has_value();
  spec.wide_results = options.first_eps > 0 && precision == Precision::Single;
  spec.refines = spec.wide_results && options.eps < options.first_eps;  // not where brackets are all that is asked for
  spec.beams = !pixels && !before && beams_in(options, static_cast<std::size_t>(view.columns) * view.rows);
  const Precision wide = spec.split ? Precision::Double : precision;
  const kernel::Shape packet = kernel::shape_of(spec);
  // Rows are as long as those of what is narrowed down, whose packets are wider.
  const int pitch_of_rows = before ? static_cast<int>(before->pitch) : spec.width;
  const CameraTerms terms = spec.beams ? CameraTerms(view, bounds, wide, packet, kernel::Tiling(spec.width)) : CameraTerms(view, bounds, wide, pitch_of_rows, packet.height);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, -terms.tau);
  Answer answer = before   ? std::move(*before)
                  : pixels ? make_answer(pixels->size(), 1, spec.width, precision, options)
                           : make_answer(view.columns, view.rows, spec.width, spec.wide_results ? Precision::Double : precision, options);
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
  launch(program, spec, std::move(inputs), settings, {}, options, device, answer);
  return answer;
}

// Single precision proves brackets as narrow as it easily can, and double narrows them: it has to march nowhere. Contraction looks at each once, so it does that
// for what `auto` chose to find them.
Answer sharpened(const program::Program& program, const View& view, const Bounds& bounds, const Options& options, device::Device& device) {
  const Options narrowing = options.or_march ? contracting(options) : options;
  kernel::Spec spec = spec_of(program, bounds, narrowing, device, Precision::Double, kernel::Entry::Camera);
  spec.sharpens = true;
  prepare(program, spec, device);  // while the other kernel is built
  const auto part = [&](Options o, double from, double to) {
    if (options.control.progress) o.control.progress = [&options, from, to](double done) { options.control.progress(from + done * (to - from)); };
    return o;
  };
  Options bare = part(options, 0, 0.75);
  bare.eps = options.first_eps;
  bare.normal = bare.rgb = false;
  Answer answer = pass(program, view, bounds, bare, device, Precision::Single, nullptr, 0);
  const device::Outcome before = answer.outcome;
  Options rest = part(narrowing, 0.75, 1);
  // What is found is narrowed down and shaded, even if it is too late to find more.
  rest.control.deadline = std::chrono::steady_clock::time_point::max();
  add_shading(answer, rest);
  answer = pass(program, view, bounds, rest, device, Precision::Double, nullptr, 0, std::move(answer));
  if (answer.outcome == device::Outcome::done) answer.outcome = before;
  return answer;
}

// Whether brackets of floats can be narrowed down where they are found (kernels/refine.cl), most of them: not where the camera is so far away that its rounding is to be told
// apart from errors of values, as a second pass does. `far`: how far.
bool refinable(const program::Program& program, const Bounds& bounds, const Options& options, double far) {
  constexpr double kRounding = 5e-12;  // of the distance: eps are no smaller
  if (kRounding * far > options.eps) return false;
  const glm::dvec3 most = glm::max(brackets_reach(bounds), glm::dvec3(1));  // the changes of coordinates along a ray as well
  const auto derivative = program::along(program);
  return derivative && !needs_infinities(program, most, options, Precision::Single) && !needs_infinities(*derivative, most, options, Precision::Single) &&
         !program::emit_fine(program).empty();
}

// Depths as kernels/neighbours.cl wants them.
Reals bordered_depths(const Answer& answer, Precision precision) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::size_t width = answer.pitch + 2;
  Reals depths(precision, width * (answer.rows + 2));
  for (std::size_t i = 0; i < width * (answer.rows + 2); ++i) depths.set(i, kInfinity);
  for (std::size_t row = 0; row < answer.rows; ++row)
    for (std::size_t column = 0; column < answer.columns; ++column) {
      const std::size_t i = row * answer.pitch + column;
      const unsigned char status = answer.status->as<unsigned char>()[i];
      if (status == 0) continue;
      const double depth = answer.depth_at(i);
      depths.set((row + 1) * width + column + 1, status == 3 ? -kInfinity : depth);
    }
  return depths;
}

void shade_by_neighbours(Answer& answer, const program::Program& program, const View& view, const Bounds& bounds,
                         const Options& options, device::Device& device) {
  widen(answer);
  const Precision precision = answer.wide ? Precision::Double : Precision::Single;
  const kernel::Spec spec = spec_of(program, bounds, options, device, precision, kernel::Entry::Neighbours);
  // Rows are as long as the answer's, whose packets may be wider.
  const CameraTerms terms(view, bounds, spec.split ? Precision::Double : precision, static_cast<int>(answer.pitch));
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, -terms.tau), depths = bordered_depths(answer, precision);
  Reals steps(precision, terms.steps.size());
  for (std::size_t k = 0; k < terms.steps.size(); ++k) steps.set(k, terms.steps[k]);
  const auto columns = terms.columns.buffer(device), rows = terms.rows.buffer(device), around = depths.buffer(device), gains = steps.buffer(device);
  const std::size_t n = answer.pitch * answer.rows;
  if (options.normal) answer.normal.emplace(3 * n * sizeof(float));
  if (options.rgb) answer.rgba.emplace(n * 4);
  // What is found is shaded, even if it is too late to find more.
  Options whatever = options;
  whatever.control.deadline = std::chrono::steady_clock::time_point::max();
  whatever.control.progress = nullptr;
  const device::Outcome before = answer.outcome;
  launch(program, spec, {columns.get(), rows.get(), static_cast<std::int32_t>(terms.column_stride), static_cast<std::int32_t>(terms.row_stride)},
         settings, {around.get(), gains.get()}, whatever, device, answer);
  if (answer.outcome == device::Outcome::done) answer.outcome = before;
}

}  // namespace

Answer camera_passes(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& given,
                     const Options& options, device::Device& device, const std::vector<std::size_t>* pixels, std::size_t pitch) {
  const Bounds bounds = narrowed(given, formulas, options);
  // Lists begin in double where frames begin with brackets.
  const bool sharpens = options.first_eps > 0 && !pixels;
  const Precision first = options.precision == PrecisionMode::Double || options.first_eps > 0 ? Precision::Double : Precision::Single;
  const bool second = options.precision == PrecisionMode::Auto && device.info().fp64 && (sharpens || first == Precision::Single);
  const bool refines = sharpens && refinable(program, bounds, options, glm::distance(view.origin, 0.5 * (bounds.lower + bounds.upper)));
  Answer answer = sharpens && !refines ? sharpened(program, view, bounds, options, device)
                                       : pass(program, view, bounds, options, device, refines ? Precision::Single : first, pixels, pitch);
  if (!second || answer.outcome != device::Outcome::done) return answer;
  const auto named = [&](std::vector<std::size_t> which) {
    if (pixels)
      for (std::size_t& i : which) i = (*pixels)[i];
    return which;
  };
  const std::size_t rows = pixels ? pitch : answer.pitch;
  const Second again{
      [&](const std::vector<std::size_t>& open) {
        return decide(answer, open, rays_of(view, named(open), rows), formulas, query_of(formulas, bounds, options, true), options);
      },
      [&](const std::vector<std::size_t>& open) {
        const auto which = named(open);
        return pass(program, view, bounds, options, device, Precision::Double, &which, rows);
      },
      [&] { return prepare(program, spec_of(program, bounds, options, device, Precision::Double, kernel::Entry::PixelList), device); }};
  decide_open(answer, program, again, options);
  return answer;
}

Answer shaded(const Finder& find, const program::Program& program, const View& view, const Bounds& bounds, const Options& options,
              device::Device& device) {
  if (!options.neighbours || !(options.normal || options.rgb)) return find(view, options);
  if (options.precision == PrecisionMode::Auto && device.info().fp64 && program.inputs())
    for (const Precision p : {Precision::Single, Precision::Double})
      prepare(program, spec_of(program, bounds, options, device, p, kernel::Entry::Neighbours), device);
  Options bare = options;
  bare.normal = bare.rgb = false;
  Answer answer = find(view, bare);
  if (answer.outcome != device::Outcome::cancelled) shade_by_neighbours(answer, program, view, bounds, options, device);
  return answer;
}

Answer picture(const Finder& find, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
               device::Device& device) {
  Answer answer = shaded(find, program, view, bounds, options, device);
  if (options.samples > 1 && options.rgb && answer.outcome == device::Outcome::done)
    antialias(answer, find, program, formulas, view, bounds, options, device);
  return answer;
}

Answer render_frame(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
                    device::Device& device) {
  const Finder find = [&](const View& v, const Options& o) { return camera_passes(program, formulas, v, bounds, o, device); };
  return picture(find, program, formulas, view, bounds, options, device);
}

std::string frame_source(const program::Program& program, const Bounds& bounds, const Options& options,
                         const device::Device& device) {
  const Precision precision = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  kernel::Spec spec = spec_of(program, bounds, options, device, precision, kernel::Entry::Camera);
  spec.beams = beams_in(options, 640 * 480);
  spec.wide_results = spec.refines = options.first_eps > 0 && refinable(program, bounds, options, 0);
  return kernel::assemble(program, spec);
}

}  // namespace irt::render
