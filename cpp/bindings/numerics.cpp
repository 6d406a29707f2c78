// Bindings of cpp/numerics: the reference, and values at points.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <chrono>
#include <cmath>
#include <cstring>

#include "bindings/bindings.h"
#include "error.h"
#include "numerics/reference.h"
#include "numerics/values.h"

namespace py = pybind11;

namespace irt::bindings {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

glm::dvec3 vector(const double* v) { return {v[0], v[1], v[2]}; }

py::dict reference(const Expr& f, const py::dict& request) {
  const auto origins = request["origins"].cast<Doubles>(), directions = request["directions"].cast<Doubles>();
  const auto tmin = request["tmin"].cast<Doubles>(), tmax = request["tmax"].cast<Doubles>();
  const auto count = static_cast<std::size_t>(tmin.size());
  std::vector<numerics::Ray> rays;
  for (std::size_t i = 0; i < count; ++i) rays.push_back({vector(origins.data() + 3 * i), vector(directions.data() + 3 * i)});
  numerics::Query query;
  query.lower = vector(request["lower"].cast<std::array<double, 3>>().data());
  query.upper = vector(request["upper"].cast<std::array<double, 3>>().data());
  for (const auto& s : request["spheres"].cast<std::vector<std::array<double, 4>>>()) query.spheres.push_back({vector(s.data()), s[3]});
  for (const auto& h : request["half_spaces"].cast<std::vector<std::array<double, 4>>>()) query.half_spaces.push_back({vector(h.data()), h[3]});
  if (!request["clip"].is_none()) query.clip = request["clip"].cast<Expr>();
  query.parameters = request["params"].cast<std::map<std::string, double>>();
  using Clock = std::chrono::steady_clock;
  const double seconds = request["time_limit"].is_none() ? 1e8 : std::min(request["time_limit"].cast<double>(), 1e8);
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  const py::object progress = request["progress"];
  query.stop = [&](double done) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) return true;
    if (!progress.is_none()) {
      try {
        progress(done);
      } catch (py::error_already_set& error) {
        error.restore();
        return true;
      }
    }
    return Clock::now() > deadline;
  };
  std::vector<numerics::Root> roots;
  {
    const py::gil_scoped_release release;
    roots = numerics::reference(f, rays, tmin.data(), tmax.data(), query);
  }
  if (PyErr_Occurred()) throw py::error_already_set();
  const auto n = static_cast<py::ssize_t>(count);
  py::array_t<std::uint8_t> kind(n), arithmetic(n);
  py::array_t<double> lo(n), hi(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const numerics::Root& r = roots[static_cast<std::size_t>(i)];
    kind.mutable_at(i) = static_cast<std::uint8_t>(r.kind);
    arithmetic.mutable_at(i) = static_cast<std::uint8_t>(r.arithmetic);
    lo.mutable_at(i) = r.lo;
    hi.mutable_at(i) = r.hi;
  }
  return py::dict(py::arg("kind") = kind, py::arg("arithmetic") = arithmetic, py::arg("lo") = lo, py::arg("hi") = hi);
}

double single_blur(const Expr& f, const std::array<double, 3>& lower, const std::array<double, 3>& upper, const std::map<std::string, double>& params) {
  return numerics::single_blur(f, vector(lower.data()), vector(upper.data()), params);
}

py::array_t<double> values(const Expr& f, const Doubles& points) {
  if (points.ndim() != 2 || points.shape(1) != 3) throw ArgumentError("points must have shape (N, 3)");
  for (py::ssize_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points.data()[i])) throw ArgumentError("points must be finite");
  const auto n = static_cast<std::size_t>(points.shape(0));
  const std::span<const std::array<double, 3>> span(reinterpret_cast<const std::array<double, 3>*>(points.data()), n);
  std::vector<std::array<double, 2>> found;
  {
    const py::gil_scoped_release release;
    found = numerics::values_at(f, span);
  }
  py::array_t<double> out({static_cast<py::ssize_t>(n), static_cast<py::ssize_t>(2)});
  if (n) std::memcpy(out.mutable_data(), found.data(), n * sizeof found[0]);
  return out;
}

}  // namespace

void bind_numerics(py::module_& m) {
  m.def("reference", &reference, py::arg("expr"), py::arg("request"), "The first zero on each ray, proven; see reference.py.");
  m.def("single_blur", &single_blur, py::arg("expr"), py::arg("lower"), py::arg("upper"), py::arg("params"),
        "An estimate of how far along a ray single precision blurs zeros of f; nan where none was met.");
  m.def("values", &values, py::arg("expr"), py::arg("points"),
        "The doubles around f at each of (N, 3) points, by MPFR: (N, 2); nan where f has no value.");
}

}  // namespace irt::bindings
