// render_frustum: polynomials by their frustum form (S2). Cells are made on the host in double, their coefficients are arguments of a
// kernel that depends on the degree only; what single precision leaves open goes the reference's way.
#include <fmt/format.h>

#include <chrono>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "numerics/frustum_form.h"
#include "render/camera_terms.h"
#include "render/decide.h"
#include "render/frustum_clip.h"
#include "render/passes.h"
#include "render/ray_terms.h"

namespace irt::render {
namespace {

using program::Precision;

// So few open pixels go the reference's way at once.
constexpr std::size_t kFewPixels = 64;
constexpr std::size_t kView = 16;  // reals before the basis (kernels/frustum_cells.cl)

struct Screen {
  int tile;  // pixels along its side
  numerics::Frustum frustum;
};

// Pixels along the side of a tile: a multiple of the widest packet. Cells of large degrees are costly, small pictures have few pixels.
int tile_of(const View& view, int degree) {
  const int size = std::max(view.columns, view.rows);
  return size <= 256 ? 16 : degree > 10 && size > 512 ? 64 : 32;
}

// A number at or above v with ten bits.
double coarse(double v) {
  int exponent;
  std::frexp(v, &exponent);
  const double unit = std::ldexp(1.0, exponent - 10);
  return std::ceil(v / unit) * unit;
}

Screen screen_of(const View& view, const Bounds& bounds, int degree) {
  Screen screen{tile_of(view, degree), {}};
  numerics::Frustum& f = screen.frustum;
  f.right = view.right;
  f.up = view.up;
  f.forward = view.forward;
  f.perspective = view.perspective;
  f.distance = glm::dot(bounds.center() - view.origin, view.forward);
  f.middle = view.origin + f.distance * view.forward;
  f.lower = bounds.lower;
  f.upper = bounds.upper;
  for (const Ball& ball : bounds.balls) f.balls.emplace_back(ball.center, ball.radius);
  const long double half = view.perspective ? view.tan_half_fov : 0.5 * view.height, aspect = static_cast<long double>(view.columns) / view.rows;
  f.left = -half * aspect * (1 - 2 * static_cast<long double>(view.right_by) / view.columns);
  f.across = 2 * half * aspect * screen.tile / view.columns;
  f.top = half * (1 - 2 * static_cast<long double>(view.down_by) / view.rows);
  f.down = -2 * half * screen.tile / view.rows;
  // Depth of the bounds, and the tiles that they may touch.
  double near = HUGE_VAL, far = -HUGE_VAL;
  double lowest[2] = {HUGE_VAL, HUGE_VAL}, highest[2] = {-HUGE_VAL, -HUGE_VAL};
  for (int k = 0; k < 8; ++k) {
    const glm::dvec3 corner(k & 1 ? bounds.upper.x : bounds.lower.x, k & 2 ? bounds.upper.y : bounds.lower.y, k & 4 ? bounds.upper.z : bounds.lower.z);
    const glm::dvec3 p = corner - f.middle;
    const double s = glm::dot(p, f.forward), spread = f.perspective ? f.distance + s : 1;
    near = std::min(near, s);
    far = std::max(far, s);
    const double at[2] = {glm::dot(p, f.right), glm::dot(p, f.up)};
    for (int a = 0; a < 2; ++a) {
      const bool in_front = spread > 1e-9 * (std::fabs(f.distance) + std::fabs(s));
      lowest[a] = std::min(lowest[a], in_front ? at[a] / spread : -HUGE_VAL);
      highest[a] = std::max(highest[a], in_front ? at[a] / spread : HUGE_VAL);
    }
  }
  near = std::max(near, -f.distance);
  const double size = glm::length(bounds.upper - bounds.lower);
  const double unit = coarse((std::max(far, near) - near + 1e-6 * size) / ((1 << numerics::kMostDepthCuts) - 2));
  f.near = std::floor(near / unit) * unit;
  f.far = f.near + (1 << numerics::kMostDepthCuts) * unit;
  const auto tiles = [](double from, double to, long double start, long double step, int pixels, int tile) {
    double a = static_cast<double>((from - start) / step), b = static_cast<double>((to - start) / step);
    if (a > b) std::swap(a, b);
    const double last = (pixels + tile - 1) / tile;
    return std::pair<int, int>(static_cast<int>(std::clamp(std::floor(a - 1e-6), 0.0, last)), static_cast<int>(std::clamp(std::ceil(b + 1e-6), 0.0, last)));
  };
  std::tie(f.tile_x0, f.tile_x1) = tiles(lowest[0], highest[0], f.left, f.across, view.columns, screen.tile);
  std::tie(f.tile_y0, f.tile_y1) = tiles(lowest[1], highest[1], f.top, f.down, view.rows, screen.tile);
  return screen;
}

// Rounding of a cell's coefficients, of both bases and of both contractions (kernels/frustum_cells.cl), half an ulp each, in parts of the
// largest coefficient.
double rounding_of(int degree, Precision precision) { return (degree + 4) * (precision == Precision::Double ? 0x1p-52 : 0x1p-23); }

// Cells as buffers: slabs and forms. Lines across are padded to packets.
struct Forms {
  Memory tiles;
  Reals slabs, form;
};

Forms forms_of(const numerics::Cells& cells, const kernel::Spec& spec) {
  const std::size_t n = static_cast<std::size_t>(cells.degree) + 1, line = (n + spec.width - 1) / spec.width * spec.width;
  Forms out{Memory(cells.begins.size() * sizeof(std::int32_t)), Reals(spec.precision, 4 * cells.cells.size()),
            Reals(spec.precision, n * n * line * cells.cells.size())};
  std::copy(cells.begins.begin(), cells.begins.end(), out.tiles.as<std::int32_t>());
  const double rounding = 2 * rounding_of(cells.degree, spec.precision);
  std::size_t at = 0;
  for (std::size_t m = 0; m < cells.cells.size(); ++m) {
    const auto& cell = cells.cells[m];
    out.slabs.set(4 * m, cell.near);
    out.slabs.set(4 * m + 1, cell.far - cell.near);
    out.slabs.set_above(4 * m + 2, cell.error + rounding);
    const double* c = &cells.coefficients[cell.first];
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t j = 0; j < n; ++j, at += line)
        for (std::size_t i = 0; i < line; ++i) out.form.set(at + i, i < n ? c[(i * n + j) * n + k] : 0);
  }
  return out;
}

// B_i and its derivative at the centres of a tile's pixels.
Reals basis_of(const Screen& screen, int degree, Precision precision) {
  const std::size_t n = static_cast<std::size_t>(degree) + 1, tile = screen.tile;
  Reals basis(precision, kView + 2 * n * tile);
  const numerics::Frustum& f = screen.frustum;
  for (int k = 0; k < 3; ++k) {
    basis.set(k, f.right[k]);
    basis.set(3 + k, f.up[k]);
    basis.set(6 + k, f.forward[k]);
  }
  basis.set(9, static_cast<double>(f.across));
  basis.set(10, static_cast<double>(f.down));
  basis.set(11, f.perspective ? 1 : 0);
  basis.set(12, f.distance);
  std::vector<double> lower(n), upper(n);
  for (std::size_t pixel = 0; pixel < tile; ++pixel) {
    const double u = (static_cast<double>(pixel) + 0.5) / static_cast<double>(tile);
    std::vector<double> b{1}, previous;
    for (int d = 1; d <= degree; ++d) {
      previous = b;
      b.assign(static_cast<std::size_t>(d) + 1, 0);
      for (std::size_t i = 0; i < previous.size(); ++i) {
        b[i] += (1 - u) * previous[i];
        b[i + 1] += u * previous[i];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      basis.set(kView + i * tile + pixel, b[i]);
      const double left = i > 0 ? previous[i - 1] : 0, right = i < previous.size() ? previous[i] : 0;
      basis.set(kView + (n + i) * tile + pixel, degree * (left - right));
    }
  }
  return basis;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

kernel::Spec spec_of(const Options& options, const device::Device& device, Precision precision, int degree, int tile) {
  kernel::Spec spec;
  spec.precision = precision;
  spec.width = packet_width(device, precision);
  spec.split = splits(device, options, precision);
  spec.infinite = false;
  spec = with_options(spec, options);
  spec.finder = options.finder;
  spec.degree = degree;
  spec.tile = tile;
  return spec;
}

// The formula as a polynomial of a degree that forms are made of.
numerics::PolynomialPlan plan_of(const numerics::Formula& formula) {
  auto plan = numerics::PolynomialPlan::of(formula);
  if (!plan || plan->degree() > limits::kFrustumDegree)
    throw MethodError(fmt::format("the frustum form is for polynomials in x, y, z of degree 1 to {}, and this formula is {}; \"contract\", \"raa\" and "
                                  "\"ia\" draw every formula", limits::kFrustumDegree, plan ? fmt::format("of degree {}", plan->degree()) : "none"));
  return std::move(*plan);
}

// One frame by the kernel of `precision`.
Answer pass(const numerics::Cells& cells, const Screen& screen, const View& view, const Bounds& bounds, const Options& options,
            device::Device& device, Precision precision) {
  const auto start = std::chrono::steady_clock::now();
  kernel::Spec spec = spec_of(options, device, precision, cells.degree, screen.tile);
  spec.entry = kernel::Entry::Camera;
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  const CameraTerms terms(view, bounds, spec.split ? Precision::Double : precision, spec.width);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, -terms.tau);
  Answer answer = make_answer(view.columns, view.rows, spec.width, precision, options);
  const Forms forms = forms_of(cells, spec);
  const Reals basis = basis_of(screen, cells.degree, precision);
  answer.prepare_seconds = seconds_since(start);
  const auto columns = terms.columns.buffer(device), rows = terms.rows.buffer(device),
             tiles = device.buffer(forms.tiles.data(), forms.tiles.bytes(), device::Access::read), slabs = forms.slabs.buffer(device),
             form = forms.form.buffer(device), values = basis.buffer(device);
  const numerics::Frustum& f = screen.frustum;
  launch(kernel::assemble_frustum(spec), spec,
         {columns.get(), rows.get(), static_cast<std::int32_t>(terms.column_stride), static_cast<std::int32_t>(terms.row_stride)}, settings,
         {tiles.get(), slabs.get(), form.get(), values.get(), f.tile_x0, f.tile_y0, f.tile_x1 - f.tile_x0, f.tile_y1 - f.tile_y0}, options, device, answer);
  return answer;
}

// The tiles of `screen` that have a pixel among `open`; the others' cells are left out.
numerics::Cells only(const numerics::Cells& cells, const Screen& screen, const std::vector<std::size_t>& open, std::size_t pitch) {
  const numerics::Frustum& f = screen.frustum;
  const int columns = f.tile_x1 - f.tile_x0;
  std::vector<bool> wanted(cells.begins.size(), false);
  for (const std::size_t i : open) {
    const int x = static_cast<int>(i % pitch) / screen.tile - f.tile_x0, y = static_cast<int>(i / pitch) / screen.tile - f.tile_y0;
    wanted[static_cast<std::size_t>(y) * columns + x] = true;
  }
  numerics::Cells out;
  out.degree = cells.degree;
  out.coefficients = cells.coefficients;
  for (std::size_t tile = 0; tile + 1 < cells.begins.size(); ++tile) {
    out.begins.push_back(static_cast<std::int32_t>(out.cells.size()));
    if (wanted[tile]) out.cells.insert(out.cells.end(), cells.cells.begin() + cells.begins[tile], cells.cells.begin() + cells.begins[tile + 1]);
  }
  out.begins.push_back(static_cast<std::int32_t>(out.cells.size()));
  return out;
}

// The pixels `which` of a frame, as a list.
Answer picked(const Answer& frame, const std::vector<std::size_t>& which, const Options& options) {
  Answer part = make_answer(which.size(), 1, 1, Precision::Double, options);
  const std::size_t n = frame.pitch * frame.rows, m = part.pitch * part.rows;
  for (std::size_t k = 0; k < which.size(); ++k) {
    const std::size_t i = which[k];
    part.depth->as<double>()[k] = frame.depth->as<double>()[i];
    part.uncertainty->as<double>()[k] = frame.uncertainty->as<double>()[i];
    part.status->as<unsigned char>()[k] = frame.status->as<unsigned char>()[i];
    for (std::size_t axis = 0; part.normal && axis < 3; ++axis) part.normal->as<float>()[axis * m + k] = frame.normal->as<float>()[axis * n + i];
    if (part.rgba) part.rgba->as<std::uint32_t>()[k] = frame.rgba->as<std::uint32_t>()[i];
    if (part.pieces) part.pieces->as<std::uint32_t>()[k] = frame.pieces->as<std::uint32_t>()[i];
  }
  part.builds = frame.builds;
  part.build_seconds = frame.build_seconds;
  part.launch_seconds = frame.launch_seconds;
  part.kernel_seconds = frame.kernel_seconds;
  part.outcome = frame.outcome;
  return part;
}

// Unit normals towards the viewer where there is a root; nan elsewhere.
void add_normals(const Formulas& formulas, const std::vector<numerics::Ray>& rays, Answer& answer) {
  std::vector<double> t;
  for (std::size_t i = 0; i < rays.size(); ++i) t.push_back(answer.wide ? answer.depth->as<double>()[i] : static_cast<double>(answer.depth->as<float>()[i]));
  const HostNormals found = normals_at(formulas, rays, t);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const unsigned char status = answer.status->as<unsigned char>()[i];
    for (int axis = 0; axis < 3; ++axis)
      answer.normal->as<float>()[axis * answer.pitch + i] = status == 1 || status == 2 ? static_cast<float>(found.normals[i][axis]) : std::nanf("");
  }
}

Answer frustum_passes(const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options, device::Device& device) {
  const auto start = std::chrono::steady_clock::now();
  const numerics::Formula formula(formulas.f, formulas.parameters);
  const numerics::PolynomialPlan plan = plan_of(formula);
  const Precision first = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  const Screen screen = screen_of(view, bounds, plan.degree());
  const numerics::Cells cells = numerics::cells_of(plan, screen.frustum, {rounding_of(plan.degree(), first), options.eps});
  const double prepared = seconds_since(start);
  Answer answer = pass(cells, screen, view, bounds, options, device, first);
  answer.prepare_seconds += prepared;
  if (options.precision == PrecisionMode::Single || !device.info().fp64 || !options.outward || answer.outcome != device::Outcome::done) return answer;
  std::vector<std::size_t> open = undecided(answer, options);
  if (first == Precision::Single && open.size() > kFewPixels) {
    const Answer second = pass(only(cells, screen, open, answer.pitch), screen, view, bounds, options, device, Precision::Double);
    std::vector<std::size_t> there;  // rows of the two frames may be padded differently
    for (const std::size_t i : open) there.push_back(i / answer.pitch * second.pitch + i % answer.pitch);
    const double spent = second.prepare_seconds;
    scatter(answer, picked(second, there, options), open);
    answer.prepare_seconds += spent;
    if (answer.outcome != device::Outcome::done) return answer;
    open = undecided(answer, options);
    answer.escalated -= open.size();  // they are counted once
  }
  if (!open.empty()) {
    // Zeros that a clip formula passes over are judged later, by apply_clip.
    const Formulas unclipped{formulas.f, {}, formulas.parameters};
    const std::size_t counted = answer.escalated + open.size();
    decide(answer, open, rays_of(view, open, answer.pitch), unclipped, query_of(unclipped, bounds, options), options);
    answer.escalated = counted;
  }
  return answer;
}

}  // namespace

Answer render_frustum(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
                      device::Device& device) {
  const Finder find = [&](const View& v, const Options& o) {
    Answer answer = frustum_passes(formulas, v, bounds, o, device);
    if (formulas.g && answer.outcome == device::Outcome::done) apply_clip(answer, program, formulas, v, bounds, o, device);
    return answer;
  };
  return picture(find, program, formulas, view, bounds, options, device);
}

Answer trace_frustum(const Formulas& formulas, const Rays& rays, const Bounds& bounds, const Options& options, device::Device& device) {
  const auto start = std::chrono::steady_clock::now();
  const numerics::Formula formula(formulas.f, formulas.parameters);
  const numerics::PolynomialPlan plan = plan_of(formula);
  const std::size_t n = static_cast<std::size_t>(plan.degree()) + 1, count = rays.count;
  const Precision precision = options.precision == PrecisionMode::Single || !device.info().fp64 ? Precision::Single : Precision::Double;
  if (count == 0) return make_answer(0, 1, packet_width(device, precision), precision, options);
  kernel::Spec spec = spec_of(options, device, precision, plan.degree(), 0);
  spec.entry = kernel::Entry::RayList;
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  Answer answer = make_answer(count, 1, spec.width, precision, options);
  const std::size_t stride = answer.pitch;
  const RayTerms terms = make_terms(rays, nullptr, count, stride, bounds, precision, spec.split);
  const double size = coarse(reach(bounds) * 1.001);
  const auto vector = [](const double* p) { return glm::dvec3(p[0], p[1], p[2]); };
  Reals form(precision, (n + 1) * stride);
  const double rounding = precision == Precision::Double ? 0x1p-52 : 0x1p-23;
  for (std::size_t k = 0; k < stride; ++k) {
    const std::size_t i = std::min(k, count - 1);
    const long double nearest = terms.nearest[k], scale = terms.scale[k];
    const auto c = plan.coefficients({vector(rays.origins + 3 * i), vector(rays.directions + 3 * i)}, static_cast<double>((nearest - size) * scale),
                                     static_cast<double>((nearest + size) * scale));
    // Scaled so that the largest lies in [1, 2): any size fits.
    double largest = 0, error = 0;
    for (const auto& v : c) largest = std::max({largest, std::fabs(v.lo), std::fabs(v.hi)});
    int exponent = 0;
    std::frexp(largest, &exponent);
    for (std::size_t m = 0; m < n; ++m) {
      const double middle = 0.5 * c[m].lo + 0.5 * c[m].hi;
      form.set(m * stride + k, std::ldexp(middle, 1 - exponent));
      error = std::max(error, std::ldexp(0.5 * c[m].hi - 0.5 * c[m].lo, 1 - exponent));
    }
    form.set_above(n * stride + k, std::isfinite(largest) ? error + 2 * rounding : HUGE_VAL);
  }
  answer.prepare_seconds = seconds_since(start);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, 0);
  const auto list = terms.terms.buffer(device), values = form.buffer(device);
  const device::Arg half = precision == Precision::Double ? device::Arg(size) : device::Arg(static_cast<float>(size));
  launch(kernel::assemble_frustum(spec), spec, {list.get(), static_cast<std::int32_t>(stride)}, settings,
         {values.get(), static_cast<std::int32_t>(stride), half}, options, device, answer);
  if (answer.outcome != device::Outcome::done) return answer;
  if (precision == Precision::Double && options.outward) {
    const std::vector<std::size_t> open = undecided(answer, options);
    decide_rays(answer, open, rays, formulas, query_of(formulas, bounds, options), options);
  }
  if (answer.normal) add_normals(formulas, rays_of(rays), answer);
  return answer;
}

std::string frustum_source(const Expr& f, const std::map<std::string, double>& parameters, const Bounds& bounds, const Options& options,
                           const device::Device& device) {
  const numerics::Formula formula(f, parameters);
  const int degree = plan_of(formula).degree();
  View view;
  view.columns = 640;
  view.rows = 480;
  const Precision precision = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  kernel::Spec spec = spec_of(options, device, precision, degree, tile_of(view, degree));
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  return kernel::assemble_frustum(spec);
}

}  // namespace irt::render
