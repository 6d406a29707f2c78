// render_frustum: polynomials by their frustum form (S2). Cells are made on the host in double, their coefficients are arguments of a
// kernel that depends on the degree only; what single precision leaves open goes the reference's way.
#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "numerics/frustum_form.h"
#include "numerics/frustum_reduce.h"
#include "numerics/recent.h"
#include "render/camera_terms.h"
#include "render/decide.h"
#include "render/frustum_clip.h"
#include "render/passes.h"
#include "render/ray_terms.h"

namespace irt::render {
namespace {

using program::Precision;

// So few open pixels go the reference's way at once, while the kernel in double is not built; so few go there in any case. A picture with no more is the same to the
// last bit however often it is drawn. Of degrees up to the last, this share of a frame is few as well: some 50 us a pixel, where building takes 300 ms.
constexpr std::size_t kFewPixels = 64, kVeryFewPixels = 8, kFewShare = 256;
constexpr int kQuickDegree = 14;
// With Options::or_march, shares of the frame beyond which open pixels are marched instead, and least numbers.
constexpr std::size_t kDoubleShare = 32, kDoubleLeast = 1024, kReferenceShare = 256, kReferenceLeast = 256;
// From the one degree on cells of floats have the other along their depth.
constexpr int kLeastShortened = 9, kShortenedDegree = 7;
// Polynomials of this degree have cells of fewer coefficients; in pictures so large, where kernels are most of a frame, from the other on.
constexpr int kLeastReduced = 7, kLeastReducedInLarge = 6, kLarge = 512;
// Roots are refined in pictures of so many pixels: smaller ones spend more on cells for that than on a search in double.
constexpr std::size_t kRefinedPixels = 1 << 14;
// By how many times the bracket that is wanted cells may blur a root before it is refined: few roots lie where cells blur most.
constexpr double kFineBlur = 10;
constexpr std::size_t kShape = 6;  // integers of a cell
constexpr std::size_t kView = 16;  // reals before the basis (kernels/frustum_cells.cl)

struct Screen {
  int tile;  // pixels along its side
  numerics::Frustum frustum;
  bool boxed;  // whether the box may cut it
};

int longer_side(const View& view) { return std::max(view.columns, view.rows); }

// Pixels along the side of a tile: a multiple of the widest packet. Cells of large degrees are costly, small pictures have few pixels.
int tile_of(const View& view, int degree) {
  const int size = longer_side(view);
  return size <= 256 ? 16 : degree > 9 && size > kLarge ? 64 : 32;
}

// A number at or above v with ten bits.
double coarse(double v) {
  int exponent;
  std::frexp(v, &exponent);
  const double unit = std::ldexp(1.0, exponent - 10);
  return std::ceil(v / unit) * unit;
}

// The depths between which the box reaches into a half-space, and a little more: those of corners inside and of edges that leave it.
std::pair<double, double> depth_within(const Bounds& bounds, const HalfSpace& h, const numerics::Frustum& f) {
  const auto corner = [&](int k) {
    return glm::dvec3(k & 1 ? bounds.upper.x : bounds.lower.x, k & 2 ? bounds.upper.y : bounds.lower.y, k & 4 ? bounds.upper.z : bounds.lower.z);
  };
  const double slack = 1e-9 * (glm::length(bounds.upper) + glm::length(bounds.lower) + glm::length(f.middle));
  double near = HUGE_VAL, far = -HUGE_VAL;
  const auto add = [&](const glm::dvec3& p) {
    const double s = glm::dot(p - f.middle, f.forward);
    near = std::min(near, s - slack);
    far = std::max(far, s + slack);
  };
  for (int k = 0; k < 8; ++k) {
    const double here = glm::dot(h.normal, corner(k)) - h.offset;
    if (here <= 0) add(corner(k));
    for (const int axis : {1, 2, 4}) {
      const double there = glm::dot(h.normal, corner(k | axis)) - h.offset;
      if (!(k & axis) && (here <= 0) != (there <= 0)) add(glm::mix(corner(k), corner(k | axis), here / (here - there)));
    }
  }
  return {near, far};
}

Screen screen_of(const View& view, const Bounds& bounds, int degree) {
  Screen screen{tile_of(view, degree), {}, false};
  numerics::Frustum& f = screen.frustum;
  f.right = view.right;
  f.up = view.up;
  f.forward = view.forward;
  f.perspective = view.perspective;
  f.distance = glm::dot(bounds.center() - view.origin, view.forward);
  using vec = glm::vec<3, long double>;
  const vec middle = vec(view.origin) + static_cast<long double>(f.distance) * vec(view.forward);
  f.middle = glm::dvec3(middle);
  f.middle_rest = glm::dvec3(middle - vec(f.middle));
  f.lower = bounds.lower;
  f.upper = bounds.upper;
  for (const Ball& ball : bounds.balls) f.balls.emplace_back(ball.center, ball.radius);
  for (const HalfSpace& h : bounds.half_spaces) f.half_spaces.emplace_back(h.normal, h.offset);
  const long double half = view.perspective ? view.tan_half_fov : 0.5 * view.height, aspect = static_cast<long double>(view.columns) / view.rows;
  f.left = -half * aspect * (1 - 2 * static_cast<long double>(view.right_by) / view.columns);
  f.across = 2 * half * aspect * screen.tile / view.columns;
  f.top = half * (1 - 2 * static_cast<long double>(view.down_by) / view.rows);
  f.down = -2 * half * screen.tile / view.rows;
  // As Camera.rays rounds them: where orthographic views begin, and directions in perspective.
  const double widest = static_cast<double>(half * std::max(1.0L, aspect)), steepest = 1 + 2 * widest;
  const double off = static_cast<double>(kRounding) * (view.perspective ? steepest * steepest : glm::length(view.origin) + widest);
  f.astray = glm::abs(off / glm::dvec2(static_cast<double>(f.across), static_cast<double>(f.down)));
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
  for (const HalfSpace& h : bounds.half_spaces) {
    const auto [first, last] = depth_within(bounds, h, f);
    near = std::max(near, first);
    far = std::min(far, last);
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
  // All that cells may cover lies between the corners of the outermost tiles, at both ends of the depth.
  for (int k = 0; k < 8; ++k) {
    const auto sx = static_cast<double>(f.left + (k & 1 ? f.tile_x1 : f.tile_x0) * f.across), sy = static_cast<double>(f.top + (k & 2 ? f.tile_y1 : f.tile_y0) * f.down);
    const glm::dvec3 p = f.point(sx, sy, k & 4 ? f.far : f.near);
    screen.boxed |= !(glm::all(glm::greaterThan(p, f.lower + 1e-9 * size)) && glm::all(glm::lessThan(p, f.upper - 1e-9 * size)));
  }
  return screen;
}

// Whether cells are reduced: of a small degree they have few coefficients to lose, and double precision has few pixels.
bool reduces(int degree, const View& view, Precision precision) {
  return precision == Precision::Single && degree >= (longer_side(view) > kLarge ? kLeastReducedInLarge : kLeastReduced);
}

// Degree along a cell's depth. S2's root finders, whose insertions are compared with S2's, and double precision keep the polynomial's.
int depth_degree(int degree, const Options& options, Precision precision) {
  return precision == Precision::Single && options.finder == "frustum_newton" && degree >= kLeastShortened ? kShortenedDegree : degree;
}

// The same of cells in doubles, where those of floats are shortened: down to the eps that they are used for no root is left open by it.
int fine_degree(int degree, const Options& options, Precision precision) {
  return depth_degree(degree, options, precision) < degree ? degree - std::min((degree - 8) / 2, 2) : degree;
}

// Cells as buffers: slabs, shapes and forms.
struct Forms {
  Memory tiles, shapes;
  Reals slabs;
  Memory form;
  std::optional<Memory> exact_form;
};

numerics::Demand demand_of(const numerics::Columns& columns, const View& view, Precision precision, double eps, int depth) {
  return {precision == Precision::Single ? 0x1p-24 : 0x1p-53, eps, depth, reduces(columns.degree(), view, precision)};
}

Forms forms_of(const numerics::Columns& columns, const Screen& screen, const numerics::Demand& demand) {
  const Precision precision = demand.single() ? Precision::Single : Precision::Double;
  std::vector<Memory> form, exact;  // the last one counts
  const auto space = [](std::vector<Memory>& blocks) { return [&blocks](std::size_t bytes) { return blocks.emplace_back(bytes).data(); }; };
  const numerics::Cells cells = numerics::cells_of(columns, screen.frustum, demand, space(form), space(exact));
  const std::size_t count = cells.cells.size();
  Forms out{Memory(cells.begins.size() * sizeof(std::int32_t)), Memory(kShape * count * sizeof(std::int32_t)), Reals(precision, 4 * count), form.back(), {}};
  if (demand.exact) out.exact_form = exact.back();
  std::copy(cells.begins.begin(), cells.begins.end(), out.tiles.as<std::int32_t>());
  for (std::size_t m = 0; m < count; ++m) {
    const auto& cell = cells.cells[m];
    out.slabs.set(4 * m, cell.near);
    out.slabs.set(4 * m + 1, cell.far - cell.near);
    out.slabs.set_above(4 * m + 2, cell.error);
    out.slabs.set_above(4 * m + 3, cell.exact_error);
    const std::int32_t shape[kShape] = {cell.down, cell.across, cell.begin, cell.exact_down, cell.exact_across, cell.exact_begin};
    std::copy_n(shape, kShape, out.shapes.as<std::int32_t>() + kShape * m);
  }
  return out;
}

// The polynomials of cells and their slopes at the centres of a tile's pixels.
Reals basis_of(const Screen& screen, int degree, const Options& options, Precision precision, bool reduced) {
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
  if (options.previous) basis.set(13, options.previous->distance);
  std::vector<double> values(n), slopes(n);
  for (std::size_t pixel = 0; pixel < tile; ++pixel) {
    const double u = (static_cast<double>(pixel) + 0.5) / static_cast<double>(tile);
    if (reduced) {
      numerics::chebyshev_at(u, n, values.data(), slopes.data());
    } else {
      numerics::bernstein_at(u, n, values.data(), slopes.data());
    }
    for (std::size_t i = 0; i < n; ++i) {
      basis.set(kView + i * tile + pixel, values[i]);
      basis.set(kView + (n + i) * tile + pixel, slopes[i]);
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

// A formula that forms are made of, nested and without its gradient, and its plan.
struct Planned {
  Planned(const Expr& f, const std::map<std::string, double>& parameters) : formula(nested(f), parameters, false), plan(plan_of(formula)) {}
  numerics::Formula formula;
  numerics::PolynomialPlan plan;
};

// Cameras move more often than formulas change.
std::shared_ptr<const Planned> planned_of(const Expr& f, const std::map<std::string, double>& parameters) {
  static auto* const recent = new numerics::Recent<std::pair<Expr, std::map<std::string, double>>, Planned>;
  return recent->get({f, parameters}, [&] { return std::make_shared<const Planned>(f, parameters); });
}

// For polynomials of `degree`.
kernel::Spec cells_spec(const Options& options, const device::Device& device, Precision precision, int degree, int tile, const Bounds& bounds,
                        kernel::Entry entry) {
  kernel::Spec spec = spec_of(options, device, precision, depth_degree(degree, options, precision), tile);
  spec.entry = entry;
  spec.previous = options.previous.has_value();
  if (options.first_eps > 0 && spec.split && entry == kernel::Entry::Camera) {
    spec.fine_terms = fine_degree(degree, options, precision) + 1;
    spec.wide_results = true;
  }
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  return spec;
}

// By the kernel of `precision`: one frame, or those packets of it that hold a pixel of `open` (row * pitch + column), one after another.
Answer pass(const numerics::Columns& columns_of_tiles, const Screen& screen, const View& view, const Bounds& bounds, const Options& options,
            device::Device& device, Precision precision, const std::vector<std::size_t>* packets = nullptr, std::size_t pitch = 0, const std::vector<bool>* wanted = nullptr) {
  const auto start = std::chrono::steady_clock::now();
  const int degree = columns_of_tiles.degree();
  const kernel::Spec spec = cells_spec(options, device, precision, degree, screen.tile, bounds, packets ? kernel::Entry::PixelList : kernel::Entry::Camera);
  const CameraTerms terms(view, bounds, spec.split ? Precision::Double : precision, spec.width);
  const Reals settings = scene_settings(bounds, options, precision, terms.pad, -terms.tau, screen.boxed);
  const bool fine = spec.fine_terms > 0;
  Answer answer = packets ? make_answer(packets->size(), 1, spec.width, precision, options)
                          : make_answer(view.columns, view.rows, spec.width, fine ? Precision::Double : precision, options);
  numerics::Demand demand = demand_of(columns_of_tiles, view, precision, fine ? kFineBlur * options.first_eps : options.eps, spec.degree);
  demand.tiles = wanted;
  demand.few = packets && options.first_eps == 0;  // long slabs leave open what is to be narrowed further
  demand.exact = fine;
  demand.exact_eps = options.eps;
  demand.exact_depth = spec.fine_terms - 1;
  const Forms forms = forms_of(columns_of_tiles, screen, demand);
  const Reals basis = basis_of(screen, degree, options, precision, demand.reduced);
  std::optional<Reals> exact_basis;  // to refine roots by
  if (fine) exact_basis.emplace(basis_of(screen, degree, options, Precision::Double, demand.reduced));
  answer.prepare_seconds = seconds_since(start);
  const auto columns = terms.columns.buffer(device), rows = terms.rows.buffer(device);
  std::vector<device::Arg> inputs{columns.get(), rows.get(), static_cast<std::int32_t>(terms.column_stride), static_cast<std::int32_t>(terms.row_stride)};
  std::optional<Memory> list;
  std::unique_ptr<device::Buffer> pixels;
  if (packets) {
    list = pixel_list(*packets, answer.pitch, pitch);
    pixels = device.buffer(list->data(), list->bytes(), device::Access::read);
    inputs.emplace_back(pixels.get());
  }
  const numerics::Frustum& f = screen.frustum;
  const auto tiles = device.buffer(forms.tiles.data(), forms.tiles.bytes(), device::Access::read),
             shapes = device.buffer(forms.shapes.data(), forms.shapes.bytes(), device::Access::read), slabs = forms.slabs.buffer(device),
             form = device.buffer(forms.form.data(), forms.form.bytes(), device::Access::read), values = basis.buffer(device);
  std::vector<device::Arg> more{tiles.get(), shapes.get(), slabs.get(), form.get(), values.get(), degree + 1, f.tile_x0, f.tile_y0, f.tile_x1 - f.tile_x0, f.tile_y1 - f.tile_y0};
  std::unique_ptr<device::Buffer> exact, exact_values;
  if (fine) {
    exact = device.buffer(forms.exact_form->data(), forms.exact_form->bytes(), device::Access::read);
    exact_values = exact_basis->buffer(device);
    more.insert(more.end(), {exact.get(), exact_values.get()});
  }
  std::unique_ptr<device::Buffer> before;
  if (options.previous) {
    before = device.buffer(options.previous->depth.data(), options.previous->depth.bytes(), device::Access::read);
    more.insert(more.end(), {before.get(), static_cast<std::int32_t>(options.previous->pitch)});
  }
  launch(kernel::assemble_frustum(spec), spec, std::move(inputs), settings, std::move(more), options, device, answer);
  return answer;
}

// The tiles of `screen` that have a pixel among `open`.
std::vector<bool> tiles_of(const Screen& screen, const std::vector<std::size_t>& open, std::size_t pitch) {
  const numerics::Frustum& f = screen.frustum;
  std::vector<bool> tiles(static_cast<std::size_t>(f.tile_x1 - f.tile_x0) * static_cast<std::size_t>(f.tile_y1 - f.tile_y0), false);
  for (const std::size_t i : open) {
    const int x = static_cast<int>(i % pitch) / screen.tile, y = static_cast<int>(i / pitch) / screen.tile;
    if (x >= f.tile_x0 && y >= f.tile_y0 && x < f.tile_x1 && y < f.tile_y1) tiles[f.tile_index(x, y)] = true;
  }
  return tiles;
}

// All pixels of the packets of `width` that hold one of `open`, which is sorted.
std::vector<std::size_t> whole_packets(const std::vector<std::size_t>& open, std::size_t width) {
  std::vector<std::size_t> out;
  for (const std::size_t i : open)
    if (const std::size_t first = i / width * width; out.empty() || out.back() < first)
      for (std::size_t k = 0; k < width; ++k) out.push_back(first + k);
  return out;
}

// The pixels that lie at `there` in what a pass made, as a list.
Answer picked(const Answer& pass, const std::vector<std::size_t>& there, const Options& options) {
  Answer part = make_answer(there.size(), 1, 1, Precision::Double, options);
  const std::size_t n = pass.pitch * pass.rows, m = part.pitch * part.rows;
  for (std::size_t k = 0; k < there.size(); ++k) {
    const std::size_t i = there[k];
    part.depth->as<double>()[k] = pass.depth->as<double>()[i];
    part.uncertainty->as<double>()[k] = pass.uncertainty->as<double>()[i];
    part.status->as<unsigned char>()[k] = pass.status->as<unsigned char>()[i];
    for (std::size_t axis = 0; part.normal && axis < 3; ++axis) part.normal->as<float>()[axis * m + k] = pass.normal->as<float>()[axis * n + i];
    if (part.rgba) part.rgba->as<std::uint32_t>()[k] = pass.rgba->as<std::uint32_t>()[i];
    if (part.pieces) part.pieces->as<std::uint32_t>()[k] = pass.pieces->as<std::uint32_t>()[i];
  }
  part.builds = pass.builds;
  part.build_seconds = pass.build_seconds;
  part.launch_seconds = pass.launch_seconds;
  part.kernel_seconds = pass.kernel_seconds;
  part.outcome = pass.outcome;
  return part;
}

// Unit normals towards the viewer where there is a root; nan elsewhere.
void add_normals(const Formulas& formulas, const std::vector<numerics::Ray>& rays, Answer& answer) {
  std::vector<double> t;
  for (std::size_t i = 0; i < rays.size(); ++i) t.push_back(answer.depth_at(i));
  const HostNormals found = normals_at(formulas, rays, t);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const unsigned char status = answer.status->as<unsigned char>()[i];
    for (int axis = 0; axis < 3; ++axis)
      answer.normal->as<float>()[axis * answer.pitch + i] = status == 1 || status == 2 ? static_cast<float>(found.normals[i][axis]) : std::nanf("");
  }
}

Answer frustum_passes(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& given, Options options,
                      device::Device& device) {
  const auto start = std::chrono::steady_clock::now();
  const Bounds bounds = narrowed(given, formulas, options);
  if (options.previous) options.previous->distance += glm::dot(bounds.center() - given.center(), view.forward);
  // Zeros that a clip formula passes over are judged later, by apply_clip.
  const Formulas unclipped{formulas.f, {}, formulas.parameters};
  std::optional<Screen> screen;
  std::optional<numerics::Columns> columns;
  int degree;
  try {
    const auto planned = planned_of(formulas.f, formulas.parameters);
    degree = planned->plan.degree();
    screen = screen_of(view, bounds, degree);
    columns.emplace(numerics::compose(planned->plan, screen->frustum), degree, screen->frustum);
  } catch (const MethodError&) {
    if (!options.or_march) throw;
    Answer answer = camera_passes(program, unclipped, view, given, contracting(options), device);
    answer.marched = true;
    return answer;
  }
  const bool in_double = options.first_eps > 0 && static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows) < kRefinedPixels;
  if (in_double) {
    options.first_eps = 0;
    options.precision = PrecisionMode::Double;
  }
  const Precision first = options.precision == PrecisionMode::Double ? Precision::Double : Precision::Single;
  const double prepared = seconds_since(start);
  Answer answer = pass(*columns, *screen, view, bounds, options, device, first);
  answer.prepare_seconds += prepared;
  answer.in_double = in_double;
  if (options.precision == PrecisionMode::Single || !device.info().fp64 || !options.outward || answer.outcome != device::Outcome::done) return answer;
  std::vector<std::size_t> open = undecided(answer, options);
  const std::size_t pixels = answer.columns * answer.rows;
  const auto marches = [&](std::size_t share, std::size_t least) {
    if (!options.or_march || open.size() <= std::max(pixels / share, least)) return false;
    Options march = contracting(options);
    // Roots that are found, but wider than eps, are so in every way that single precision has.
    const unsigned char* status = answer.status->as<unsigned char>();
    if (2 * std::count_if(open.begin(), open.end(), [&](std::size_t i) { return status[i] == 1; }) > static_cast<std::ptrdiff_t>(open.size()))
      march.precision = PrecisionMode::Double;
    scatter(answer, camera_passes(program, unclipped, view, given, march, device, &open, answer.pitch), open, options);
    return true;
  };
  if (marches(kDoubleShare, kDoubleLeast)) return answer;
  // What is drawn again has a camera or a slider that moves, and should compile nothing wherever it goes.
  const bool again = first == Precision::Single && answer.builds == 0;
  const bool ready = again &&
                     device.prepare(kernel::assemble_frustum(cells_spec(options, device, Precision::Double, degree, screen->tile, bounds, kernel::Entry::PixelList)),
                                    kernel::entry_name(kernel::Entry::PixelList));
  const std::size_t few = ready ? kVeryFewPixels : std::max(kFewPixels, degree <= kQuickDegree ? pixels / kFewShare : 0);
  if (first == Precision::Single && open.size() > few) {
    const std::vector<std::size_t> packets = whole_packets(open, static_cast<std::size_t>(packet_width(device, Precision::Double)));
    const std::vector<bool> tiles = tiles_of(*screen, open, answer.pitch);
    const Answer second = pass(*columns, *screen, view, bounds, options, device, Precision::Double, &packets, answer.pitch, &tiles);
    std::vector<std::size_t> there;  // where each open pixel lies in the list
    for (const std::size_t i : open)
      there.push_back(static_cast<std::size_t>(std::lower_bound(packets.begin(), packets.end(), i) - packets.begin()));
    const double spent = second.prepare_seconds;
    open = scatter(answer, picked(second, there, options), open, options);
    answer.prepare_seconds += spent;
    answer.builds += again && !ready;  // begun ahead, and waited for
    if (answer.outcome != device::Outcome::done) return answer;
    answer.escalated -= open.size();  // they are counted once
  }
  if (open.empty() || marches(kReferenceShare, kReferenceLeast) || !options.refers()) return answer;
  const std::size_t counted = answer.escalated + open.size();
  decide(answer, open, rays_of(view, open, answer.pitch), unclipped, query_of(unclipped, bounds, options), options);
  answer.escalated = counted;
  return answer;
}

}  // namespace

Answer render_frustum(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
                      device::Device& device) {
  const Finder find = [&](const View& v, const Options& o) {
    Answer answer = frustum_passes(program, formulas, v, bounds, o, device);
    if (formulas.g && answer.outcome == device::Outcome::done) apply_clip(answer, program, formulas, v, bounds, o, device);
    return answer;
  };
  return picture(find, program, formulas, view, bounds, options, device);
}

Answer trace_frustum(const program::Program& program, const Formulas& formulas, const Rays& rays, const Bounds& given, const Options& options, device::Device& device) {
  const auto start = std::chrono::steady_clock::now();
  const Bounds bounds = narrowed(given, formulas, options);
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
  if (precision == Precision::Double && options.refers()) {
    const std::vector<std::size_t> open = undecided(answer, options);
    const Formulas unclipped{formulas.f, {}, formulas.parameters};
    decide_rays(answer, open, rays, unclipped, query_of(unclipped, bounds, options), options);
  }
  if (answer.normal) add_normals(formulas, rays_of(rays), answer);
  if (formulas.g && answer.outcome == device::Outcome::done) apply_clip(answer, program, formulas, rays, bounds, options, device);
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
  kernel::Spec spec = spec_of(options, device, precision, depth_degree(degree, options, precision), tile_of(view, degree));
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  return kernel::assemble_frustum(spec);
}

}  // namespace irt::render
