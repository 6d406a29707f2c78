// Bindings of cpp/render: requests are dictionaries that python/implicitrt (request.py, render.py) has checked.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <chrono>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>

#include "bindings/bindings.h"
#include "expr/build.h"
#include "error.h"
#include "kernel/assemble.h"
#include "numerics/recent.h"
#include "render/launch.h"

namespace py = pybind11;

namespace irt::bindings {
namespace {

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

template <class T>
T get(const py::dict& request, const char* key) {
  return request[key].cast<T>();
}

glm::dvec3 vector(py::handle h) {
  const auto v = h.cast<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}

render::Bounds bounds_of(const py::dict& request) {
  render::Bounds b{vector(request["lower"]), vector(request["upper"]), {}, {}};
  for (const auto& s : get<std::vector<std::array<double, 4>>>(request, "spheres"))
    b.balls.push_back({{s[0], s[1], s[2]}, s[3]});
  for (const auto& h : get<std::vector<std::array<double, 4>>>(request, "half_spaces"))
    b.half_spaces.push_back({{h[0], h[1], h[2]}, h[3]});
  return b;
}

// Asks Python for signals (Ctrl-C) and tells it how far the frame is, with the GIL taken for as long as that needs.
device::Control control_of(const py::dict& request) {
  device::Control control;
  control.cancelled = [] {
    const py::gil_scoped_acquire gil;
    return PyErr_Occurred() != nullptr || PyErr_CheckSignals() != 0;
  };
  if (request.contains("progress") && !request["progress"].is_none()) {
    control.progress = [progress = request["progress"].cast<py::function>()](double fraction) {
      const py::gil_scoped_acquire gil;
      if (PyErr_Occurred()) return;
      try {
        progress(fraction);
      } catch (py::error_already_set& error) {
        error.restore();  // the next question for signals sees it
      }
    };
  }
  if (request.contains("time_limit") && !request["time_limit"].is_none())
    control.deadline = std::chrono::steady_clock::now() +
                       std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                           std::chrono::duration<double>(std::min(get<double>(request, "time_limit"), 1e8)));
  return control;
}

render::Options options_of(const py::dict& request, const program::Program& program) {
  render::Options o;
  o.affine = get<std::string>(request, "algebra") == "raa";
  if (request.contains("finder")) o.finder = get<std::string>(request, "finder");
  if (request.contains("or_march")) o.or_march = get<bool>(request, "or_march");
  if (request.contains("reads")) o.reads = get<std::string>(request, "reads");
  if (request.contains("beams") && !request["beams"].is_none()) o.beams = get<bool>(request, "beams");
  if (request.contains("defines")) o.defines = get<std::vector<std::string>>(request, "defines");
  if (request.contains("steps")) o.steps = get<int>(request, "steps");
  o.outward = get<std::string>(request, "rounding") == "outward";
  if (request.contains("bare")) o.bare = get<bool>(request, "bare");
  const auto precision = get<std::string>(request, "precision");
  o.precision = precision == "single"   ? render::PrecisionMode::Single
                : precision == "double" ? render::PrecisionMode::Double
                                        : render::PrecisionMode::Auto;
  const auto params = get<py::dict>(request, "params");
  for (const std::string& name : program.parameters) {
    if (!params.contains(name.c_str())) throw ArgumentError("parameter '" + name + "' has no value; give it in params");
    o.parameters.push_back(params[name.c_str()].cast<double>());
  }
  if (request.contains("isovalue") && !request["isovalue"].is_none()) o.parameters.push_back(get<double>(request, "isovalue"));
  return o;
}

// The program of a picture: with the clip formula, and with what sees through poles.
// Frames ask for the same again and again.
std::shared_ptr<const program::Program> program_of(const Expr& f, const py::dict& request) {
  using Key = std::tuple<Expr, bool, std::optional<Expr>>;
  static auto* const recent = new numerics::Recent<Key, program::Program>;
  const bool isovalue = request.contains("isovalue") && !request["isovalue"].is_none(), clipped = request.contains("clip") && !request["clip"].is_none();
  const std::optional<Expr> g = clipped ? std::optional(get<Expr>(request, "clip")) : std::nullopt;
  return recent->get({f, isovalue, g}, [&] { return std::make_shared<const program::Program>(program::lower(f, isovalue, g ? &*g : nullptr, true)); });
}

// (depths (rows, columns), distance), as rows of whole packets.
render::Previous previous_of(const py::handle& given) {
  constexpr std::size_t kWidest = 16;
  const auto [depth, distance] = given.cast<std::pair<py::array_t<float, py::array::c_style | py::array::forcecast>, double>>();
  const auto rows = static_cast<std::size_t>(depth.shape(0)), columns = static_cast<std::size_t>(depth.shape(1)), pitch = (columns + kWidest - 1) / kWidest * kWidest;
  render::Previous previous{render::Memory(rows * pitch * sizeof(float)), pitch, distance};
  for (std::size_t row = 0; row < rows; ++row) {
    float* to = previous.depth.as<float>() + row * pitch;
    std::fill(std::copy_n(depth.data(static_cast<py::ssize_t>(row), 0), columns, to), to + pitch, HUGE_VALF);
  }
  return previous;
}

render::Options picture_options(const py::dict& request, const program::Program& program) {
  render::Options o = options_of(request, program);
  o.eps = get<double>(request, "eps");
  if (request.contains("first_eps")) o.first_eps = get<double>(request, "first_eps");
  if (request.contains("max_pieces")) o.max_pieces = get<int>(request, "max_pieces");
  const auto want = get<std::set<std::string>>(request, "want");
  o.normal = want.count("normal") > 0;
  o.rgb = want.count("rgb") > 0;
  o.pieces = want.count("pieces") > 0;
  if (o.rgb) {
    o.color = get<std::array<double, 3>>(request, "color");
    o.back_color = get<std::array<double, 3>>(request, "back_color");
    o.unresolved_color = get<std::array<double, 3>>(request, "unresolved_color");
    if (!request["background"].is_none()) {
      const auto b = get<std::array<double, 3>>(request, "background");
      o.background = {b[0], b[1], b[2], 1};
    }
    if (!request["light"].is_none()) o.light = vector(request["light"]);
  }
  if (request.contains("neighbours")) {
    o.neighbours = get<bool>(request, "neighbours");
    o.samples = get<int>(request, "samples");
    o.everywhere = get<bool>(request, "everywhere");
  }
  if (request.contains("previous") && !request["previous"].is_none()) o.previous = previous_of(request["previous"]);
  o.control = control_of(request);
  return o;
}

// An array over memory of the core: it owns a share, nothing is copied.
template <class T>
py::array view(const render::Memory& memory, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides) {
  auto* share = new render::Memory(memory);
  const py::capsule owner(share, [](void* p) { delete static_cast<render::Memory*>(p); });
  return py::array_t<T>(std::move(shape), std::move(strides), static_cast<const T*>(memory.data()), owner);
}

template <class T>
py::array plane(const render::Answer& a, const render::Memory& memory) {
  return view<T>(memory, {static_cast<py::ssize_t>(a.rows), static_cast<py::ssize_t>(a.columns)},
                 {static_cast<py::ssize_t>(a.pitch * sizeof(T)), static_cast<py::ssize_t>(sizeof(T))});
}

py::dict answer_dict(const render::Answer& a) {
  py::dict d;
  const auto rows = static_cast<py::ssize_t>(a.rows), columns = static_cast<py::ssize_t>(a.columns),
             pitch = static_cast<py::ssize_t>(a.pitch);
  d["depth"] = a.wide ? plane<double>(a, *a.depth) : plane<float>(a, *a.depth);
  d["uncertainty"] = a.wide ? plane<double>(a, *a.uncertainty) : plane<float>(a, *a.uncertainty);
  d["status"] = plane<std::uint8_t>(a, *a.status);
  if (a.finer) {  // pixels, counted row by row, and what doubles tell of them
    py::array_t<std::int64_t> where(static_cast<py::ssize_t>(a.finer->where.size()));
    std::transform(a.finer->where.begin(), a.finer->where.end(), where.mutable_data(), [&](std::size_t i) { return static_cast<std::int64_t>(i / a.pitch * a.columns + i % a.pitch); });
    const auto some = [&](const render::Memory& m) { return view<double>(m, {where.shape(0)}, {sizeof(double)}); };
    d["finer"] = py::make_tuple(where, some(a.finer->depth), some(a.finer->uncertainty));
  }
  if (a.normal) d["normal"] = view<float>(*a.normal, {rows, columns, 3}, {4 * pitch, 4, 4 * pitch * rows});
  if (a.rgba) d["rgba"] = view<std::uint8_t>(*a.rgba, {rows, columns, 4}, {4 * pitch, 4, 1});
  if (a.pieces) d["pieces"] = plane<std::uint32_t>(a, *a.pieces);
  d["width"] = a.width;
  d["engine"] = "kernel";
  d["marched"] = a.marched;
  d["in_double"] = a.in_double;
  d["builds"] = a.builds;
  d["escalated"] = a.escalated;
  d["by_reference"] = a.by_reference;
  d["counts"] = a.tally->counts;
  d["wide"] = a.tally->wide_hits;
  d["seconds"] = py::dict(py::arg("build") = a.build_seconds, py::arg("launch") = a.launch_seconds, py::arg("kernel") = a.kernel_seconds);
  if (a.prepare_seconds > 0) d["seconds"]["prepare"] = a.prepare_seconds;  // coefficients, on the host
  d["finished"] = a.outcome == device::Outcome::done;
  return d;
}

void raise_if_interrupted(device::Outcome outcome) {
  if (PyErr_Occurred()) throw py::error_already_set();
  if (outcome == device::Outcome::cancelled) throw Error("the call was interrupted");
}

// f less the isovalue.
Expr level_of(const Expr& f, const py::dict& request) {
  const bool level = request.contains("isovalue") && !request["isovalue"].is_none();
  return level ? add(f, from_double(-get<double>(request, "isovalue"))) : f;
}

render::Formulas formulas_of(const Expr& f, const py::dict& request) {
  const bool clipped = request.contains("clip") && !request["clip"].is_none();
  return {level_of(f, request), clipped ? std::optional(get<Expr>(request, "clip")) : std::nullopt, get<std::map<std::string, double>>(request, "params")};
}

py::dict render_frame(const Expr& f, const py::dict& request) {
  const auto kept = program_of(f, request);
  const program::Program& program = *kept;
  const render::Options options = picture_options(request, program);
  const render::Bounds bounds = bounds_of(request);
  const auto camera = get<py::dict>(request, "camera");
  render::View view;
  view.origin = vector(camera["origin"]);
  view.right = vector(camera["right"]);
  view.up = vector(camera["up"]);
  view.forward = vector(camera["forward"]);
  view.perspective = camera["perspective"].cast<bool>();
  view.tan_half_fov = view.perspective ? camera["tan_half_fov"].cast<double>() : 0;
  view.height = view.perspective ? 0 : camera["height"].cast<double>();
  view.columns = get<int>(request, "width");
  view.rows = get<int>(request, "height");
  const render::Formulas formulas = formulas_of(f, request);
  const auto device = get<std::shared_ptr<device::Device>>(request, "device");
  render::Answer answer;
  {
    const py::gil_scoped_release release;
    answer = options.by_frustum() ? render::render_frustum(program, formulas, view, bounds, options, *device)
                                   : render::render_frame(program, formulas, view, bounds, options, *device);
    render::tally(answer, options);
  }
  raise_if_interrupted(answer.outcome);
  return answer_dict(answer);
}

py::dict trace_rays(const Expr& f, const py::dict& request) {
  const auto kept = program_of(f, request);
  const program::Program& program = *kept;
  const render::Options options = picture_options(request, program);
  const render::Bounds bounds = bounds_of(request);
  const auto origins = get<DoubleArray>(request, "origins"), directions = get<DoubleArray>(request, "directions");
  const auto tmin = get<DoubleArray>(request, "tmin"), tmax = get<DoubleArray>(request, "tmax");
  const render::Rays rays{origins.data(), directions.data(), tmin.data(), tmax.data(), static_cast<std::size_t>(tmin.size())};
  const render::Formulas formulas = formulas_of(f, request);
  const auto device = get<std::shared_ptr<device::Device>>(request, "device");
  render::Answer answer;
  {
    const py::gil_scoped_release release;
    answer = options.by_frustum() ? render::trace_frustum(program, formulas, rays, bounds, options, *device)
                                   : render::trace_rays(program, formulas, rays, bounds, options, *device);
    render::widen(answer);
    render::tally(answer, options);
  }
  raise_if_interrupted(answer.outcome);
  return answer_dict(answer);
}

py::array_t<double> enclose_pieces(const Expr& f, const py::dict& request) {
  const program::Program program = program::lower(f);
  const render::Options options = options_of(request, program);
  const auto pieces = get<DoubleArray>(request, "pieces");  // (n, 9)
  const auto directions = request.contains("directions") ? get<DoubleArray>(request, "directions") : DoubleArray(0);  // the same, or none
  const auto n = static_cast<std::size_t>(pieces.shape(0));
  const auto rows = [](const DoubleArray& a) {
    return std::span<const std::array<double, 9>>(reinterpret_cast<const std::array<double, 9>*>(a.data()), static_cast<std::size_t>(a.shape(0)));
  };
  if (directions.shape(0) != 0 && directions.shape(0) != pieces.shape(0)) throw ArgumentError("pieces and directions must be as many");
  const auto device = get<std::shared_ptr<device::Device>>(request, "device");
  std::vector<std::array<double, 2>> result;
  {
    const py::gil_scoped_release release;
    result = render::enclose_pieces(program, rows(pieces), rows(directions), options, *device);
  }
  py::array_t<double> out({static_cast<py::ssize_t>(n), static_cast<py::ssize_t>(2)});
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 2; ++k) out.mutable_at(i, k) = result[i][k];
  return out;
}

std::string kernel_source(const Expr& f, const py::dict& request) {
  const auto kept = program_of(f, request);
  const program::Program& program = *kept;
  const auto device = get<std::shared_ptr<device::Device>>(request, "device");
  const render::Options options = picture_options(request, program);
  return options.by_frustum()
             ? render::frustum_source(level_of(f, request), get<std::map<std::string, double>>(request, "params"), bounds_of(request), options, *device)
             : render::frame_source(program, bounds_of(request), options, *device);
}

}  // namespace

void bind_render(py::module_& m) {
  m.def("set_kernel_directory", &kernel::set_directory, py::arg("path"), "Where the kernel library files lie.");
  m.def("render_frame", &render_frame, py::arg("expr"), py::arg("request"), "Renders a frame; see request.py and render.py.");
  m.def("trace_rays", &trace_rays, py::arg("expr"), py::arg("request"), "Traces a batch of rays; see request.py and render.py.");
  m.def("enclose_pieces", &enclose_pieces, py::arg("expr"), py::arg("request"), "Bounds of f over pieces; see request.py and render.py.");
  m.def("kernel_source", &kernel_source, py::arg("expr"), py::arg("request"), "The OpenCL C that a call runs.");
  m.def("parameters", [](const Expr& f) { return program::lower(f).parameters; }, py::arg("expr"),
        "The names of the parameters of f, sorted.");
}

}  // namespace irt::bindings
