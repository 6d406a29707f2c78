// decide: see decide.h. Shading is that of kernels/shade.cl.
#include "render/decide.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "error.h"
#include "expr/calculus.h"
#include "expr/tape.h"
#include "numerics/recent.h"

namespace irt::render {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Up to so many open rays go to the reference: some milliseconds, where a kernel in double takes longer to compile than the picture to
// draw. Where that kernel is there, up to so few: such a picture is the same to the last bit however often it is drawn.
constexpr std::size_t kFewRays = 192, kVeryFewRays = 40;
// Of formulas of up to so many operations: the reference differentiates them.
constexpr std::size_t kShortProgram = 500;

// The gradient of f at points, in double.
std::array<std::vector<double>, 3> gradients(const Formulas& formulas, const std::array<std::vector<double>, 3>& points) {
  using Tapes = std::array<Tape, 3>;
  static auto* const recent = new numerics::Recent<Expr, Tapes>;  // cameras move more often than formulas change
  const auto tapes = recent->get(formulas.f, [&] {
    return std::make_shared<const Tapes>(Tapes{Tape(differentiate(formulas.f, "x")), Tape(differentiate(formulas.f, "y")), Tape(differentiate(formulas.f, "z"))});
  });
  const std::size_t count = points[0].size();
  std::array<std::vector<double>, 3> out;
  for (int axis = 0; axis < 3; ++axis) {
    const Tape& tape = (*tapes)[axis];
    std::vector<std::vector<double>> inputs;
    for (const std::string& name : tape.symbols()) {
      const int of = name == "x" ? 0 : name == "y" ? 1 : name == "z" ? 2 : -1;
      inputs.push_back(of >= 0 ? points[of] : std::vector<double>(count, formulas.parameters.at(name)));
    }
    std::vector<const double*> pointers;
    for (const auto& v : inputs) pointers.push_back(v.data());
    out[axis].resize(count);
    tape.run(pointers, out[axis].data(), count);
  }
  return out;
}

// The pixel of a point with the normal n (nan: lit as if it faced the eye); v: unit, towards the eye.
std::uint32_t shade(glm::dvec3 n, bool front, const glm::dvec3& v, const Options& options) {
  if (std::isnan(n.x)) n = v;
  const double power = glm::length(options.light) > 0 ? 1 : 0;
  const double facing = std::max(glm::dot(n, v), 0.0), lit = std::max(glm::dot(n, options.light), 0.0);
  const glm::dvec3 half = v + options.light;
  const double along = std::max(glm::dot(n, half) / std::max(glm::length(half), 1e-6), 0.0);
  const double diffuse = 0.08 + 0.5 * facing + power * 0.55 * lit;
  const double gloss = 0.12 * std::pow(facing, 32) + power * (lit > 0 ? 0.25 * std::pow(along, 32) : 0);
  const auto& color = front ? options.color : options.back_color;
  return pixel_of({color[0] * diffuse + gloss, color[1] * diffuse + gloss, color[2] * diffuse + gloss, 1});
}

}  // namespace

std::vector<numerics::Ray> rays_of(const View& view, const std::vector<std::size_t>& pixels, std::size_t pitch) {
  // As Camera.rays does in Python, to the last bit: what is said of a pixel is said of that ray, and far from the origin rounding moves rays by more than brackets are wide.
  const double half = view.perspective ? view.tan_half_fov : 0.5 * view.height, aspect = static_cast<double>(view.columns) / view.rows;
  std::vector<numerics::Ray> rays;
  for (const std::size_t i : pixels) {
    const double column = static_cast<double>(i % pitch), row = static_cast<double>(i / pitch);
    const double u = 2 * (column + 0.5 + view.right_by) / view.columns - 1, v = 1 - 2 * (row + 0.5 + view.down_by) / view.rows;
    const glm::dvec3 there = (view.perspective ? view.forward : view.origin) + u * half * aspect * view.right + v * half * view.up;
    if (view.perspective) {
      rays.push_back({view.origin, there / glm::length(there)});
    } else {
      rays.push_back({there, view.forward});
    }
  }
  return rays;
}

numerics::Query query_of(const Formulas& formulas, const Bounds& bounds, const Options& options, bool quick) {
  numerics::Query query{bounds.lower, bounds.upper, {}, {}, formulas.g, formulas.parameters, [&options](double) {
    return (options.control.cancelled && options.control.cancelled()) || std::chrono::steady_clock::now() > options.control.deadline;
  }};
  for (const Ball& ball : bounds.balls) query.spheres.push_back({ball.center, ball.radius});
  for (const HalfSpace& h : bounds.half_spaces) query.half_spaces.push_back({h.normal, h.offset});
  query.quick = quick;
  return query;
}

HostNormals normals_at(const Formulas& formulas, const std::vector<numerics::Ray>& rays, const std::vector<double>& t) {
  std::array<std::vector<double>, 3> points;
  for (std::size_t k = 0; k < rays.size(); ++k)
    for (int axis = 0; axis < 3; ++axis) points[axis].push_back(rays[k].origin[axis] + (std::isfinite(t[k]) ? t[k] : 0) * rays[k].direction[axis]);
  const auto g = gradients(formulas, points);
  HostNormals out;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    glm::dvec3 n(g[0][k], g[1][k], g[2][k]);
    const double largest = std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)});
    n = largest > 0 && std::isfinite(largest) ? glm::normalize(n / largest) : glm::dvec3(kNone);
    out.front.push_back(!(glm::dot(n, rays[k].direction) > 0));
    out.normals.push_back(out.front.back() ? n : -n);
  }
  return out;
}

std::vector<std::size_t> decide(Answer& answer, const std::vector<std::size_t>& where, const std::vector<numerics::Ray>& rays,
                                const double* tmin, const double* tmax, const Formulas& formulas, const numerics::Query& query, const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<numerics::Root> roots;
  try {
    roots = numerics::reference(formulas.f, rays, tmin, tmax, query);
  } catch (const LimitError&) {  // its derivative is too long: kernels need none
    return where;
  }
  answer.by_reference += where.size();
  std::vector<std::size_t> open, decided;
  std::vector<numerics::Ray> along;
  std::vector<double> t, half;
  std::vector<unsigned char> kinds;
  for (std::size_t k = 0; k < where.size(); ++k) {
    const numerics::Root& root = roots[k];
    if (root.kind == numerics::Kind::undecided) {
      open.push_back(where[k]);
      continue;
    }
    decided.push_back(where[k]);
    along.push_back(rays[k]);
    kinds.push_back(static_cast<unsigned char>(root.kind));
    const bool miss = root.kind == numerics::Kind::miss;
    t.push_back(miss ? HUGE_VAL : 0.5 * (root.lo + root.hi));
    half.push_back(root.kind == numerics::Kind::hit ? std::max(root.hi - t.back(), t.back() - root.lo) * (1 + 0x1p-50) + 0x1p-51 * std::fabs(t.back()) : kNone);
  }
  if (decided.empty()) return open;
  Options wanted = options;
  wanted.pieces = false;
  wanted.control = {};
  Answer part = make_answer(decided.size(), 1, 1, program::Precision::Double, wanted);
  const std::size_t n = part.pitch;
  HostNormals found;
  if (options.normal || options.rgb) found = normals_at(formulas, along, t);
  for (std::size_t k = 0; k < decided.size(); ++k) {
    part.status->as<unsigned char>()[k] = kinds[k];
    part.depth->as<double>()[k] = t[k];
    part.uncertainty->as<double>()[k] = options.outward ? half[k] : kNone;
    const bool hit = kinds[k] != 0;
    if (part.normal)
      for (int axis = 0; axis < 3; ++axis) part.normal->as<float>()[axis * n + k] = hit ? static_cast<float>(found.normals[k][axis]) : std::nanf("");
    if (part.rgba)
      part.rgba->as<std::uint32_t>()[k] =
          hit ? shade(found.normals[k], found.front[k], -glm::normalize(along[k].direction), options) : pixel_of(options.background);
  }
  part.outcome = answer.outcome;
  if (options.control.cancelled && options.control.cancelled()) part.outcome = device::Outcome::cancelled;
  scatter(answer, part, decided, options);
  answer.kernel_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return open;
}

std::vector<std::size_t> decide(Answer& answer, const std::vector<std::size_t>& where, const std::vector<numerics::Ray>& rays,
                                const Formulas& formulas, const numerics::Query& query, const Options& options) {
  const std::vector<double> tmin(rays.size(), 0), tmax(rays.size(), HUGE_VAL);
  return decide(answer, where, rays, tmin.data(), tmax.data(), formulas, query, options);
}

namespace {
numerics::Ray ray_of(const Rays& rays, std::size_t i) {
  const double *o = rays.origins + 3 * i, *d = rays.directions + 3 * i;
  return {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}};
}
}  // namespace

std::vector<numerics::Ray> rays_of(const Rays& rays, const std::vector<std::size_t>& which) {
  std::vector<numerics::Ray> out;
  for (const std::size_t i : which) out.push_back(ray_of(rays, i));
  return out;
}

std::vector<numerics::Ray> rays_of(const Rays& rays) {
  std::vector<numerics::Ray> out;
  for (std::size_t i = 0; i < rays.count; ++i) out.push_back(ray_of(rays, i));
  return out;
}

std::vector<std::size_t> decide_rays(Answer& answer, const std::vector<std::size_t>& where, const Rays& rays, const Formulas& formulas,
                                     const numerics::Query& query, const Options& options) {
  std::vector<double> tmin, tmax;
  for (const std::size_t i : where) {
    tmin.push_back(rays.tmin[i]);
    tmax.push_back(rays.tmax[i]);
  }
  return decide(answer, where, rays_of(rays, where), tmin.data(), tmax.data(), formulas, query, options);
}

void decide_open(Answer& answer, const program::Program& program, const Second& second, const Options& options) {
  std::vector<std::size_t> open = undecided(answer, options);
  const bool few = open.empty() || (open.size() <= kFewRays && program.code.size() <= kShortProgram && options.refers());
  // What is drawn again has a camera or a slider that moves, and should compile nothing wherever it goes, nor wait for the reference.
  const bool worth = open.size() > kVeryFewRays, ready = few && answer.builds == 0 && (worth || program.inputs() > 0) && second.prepare() && worth;
  if (few && !ready && !open.empty()) open = second.refer(open);
  if (open.empty() || answer.outcome != device::Outcome::done) return;
  open = scatter(answer, second.pass(open), open, options);
  // Statuses do not depend on which of the two came first.
  if (!ready || open.empty() || answer.outcome != device::Outcome::done) return;
  const std::size_t counted = answer.escalated;
  second.refer(open);
  answer.escalated = counted;
}

}  // namespace irt::render
