// What a call asks for, and what it answers: the C++ side of render, trace and enclose.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "device/device.h"
#include "expr/expr.h"
#include "program/program.h"

namespace irt::render {

struct Ball {
  glm::dvec3 center;
  double radius;
};

// The side n . p <= offset; the largest of |n| lies in [1, 2).
struct HalfSpace {
  glm::dvec3 normal;
  double offset;
};

struct Bounds {
  glm::dvec3 lower, upper;
  std::vector<Ball> balls;
  std::vector<HalfSpace> half_spaces;
  glm::dvec3 farthest{0};  // what coordinates kernels are made for, where these bounds are a part of others

  glm::dvec3 center() const { return 0.5 * (lower + upper); }
};

struct View {
  glm::dvec3 origin, right, up, forward;  // an orthonormal basis
  bool perspective = true;
  double tan_half_fov = 0.5;  // perspective
  double height = 1;          // orthographic
  int columns = 0, rows = 0;
  double right_by = 0, down_by = 0;  // where samples lie, in pixels from the pixels' centres
};

// A batch of rays: (n, 3) arrays, and the range of t for each.
struct Rays {
  const double *origins, *directions, *tmin, *tmax;
  std::size_t count = 0;
};

// Memory that outlives the call inside NumPy arrays; aligned so that CPU drivers use it in place.
class Memory {
 public:
  explicit Memory(std::size_t bytes);
  void* data() const { return data_.get(); }
  std::size_t bytes() const { return bytes_; }
  template <class T>
  T* as() const {
    return static_cast<T*>(data_.get());
  }

 private:
  std::shared_ptr<void> data_;
  std::size_t bytes_;
};

// What is known of the frame before (frame coherence): its depths, `pitch` apart from row to row with whole packets in each, of a picture of the same
// size, and how far its camera was from the plane through the middle of the bounds.
struct Previous {
  Memory depth;
  std::size_t pitch;
  double distance;
};

// What the host may ask of a formula itself: f less the isovalue, the clip formula, values of parameters by name.
struct Formulas {
  Expr f;
  std::optional<Expr> g;
  std::map<std::string, double> parameters;
};

enum class PrecisionMode { Single, Double, Auto };

struct Options {
  bool affine = true;
  std::string finder = "bisection";  // kernels/<finder>.cl
  std::string reads = "enclosures";  // what it reads of f along the ray
  std::optional<bool> beams;         // kernels/beams.cl; nothing: where the frame is large enough
  std::vector<std::string> defines;  // macros that its file tests
  int steps = 0;                     // of root finders that sample
  bool outward = true;
  bool bare = false;  // enclose_pieces by arithmetic without pads, widened by the bound of its rounding, where there is one
  PrecisionMode precision = PrecisionMode::Auto;
  double eps = 1e-3;
  double first_eps = 0;            // of brackets in single precision, which are narrowed down to eps in double, there or by a pass of its own; 0: none are
  std::vector<double> parameters;  // one for each of Program::inputs()
  int max_pieces = 0;              // 0: the default
  bool normal = true, rgb = true, pieces = false;
  bool neighbours = false;  // normals from the points of neighbouring pixels (frames only)
  int samples = 1;          // in a row and in a column of each pixel that is anti-aliased
  bool everywhere = true;   // all pixels are, not only those at silhouettes
  std::array<double, 3> color{}, back_color{}, unresolved_color{};  // linear light
  std::array<double, 4> background{};                              // and alpha
  glm::dvec3 light{0};                                             // towards it; zero: none
  device::Control control;

  // Whether few open rays go to the reference: where statuses are proven, and no budget of pieces was set.
  bool refers() const { return outward && max_pieces == 0 && (by_frustum() || finder == "bisection" || finder == "contract" || finder == "mitchell"); }
  std::optional<Previous> previous;  // of by_frustum()
  bool or_march = false;  // of `auto`: where the frustum form is refused, or leaves many pixels open, contraction goes on, and narrows brackets down
  // Root finders of the frustum form take coefficients instead of a program.
  bool by_frustum() const { return finder.starts_with("frustum_"); }
  // Those that march by enclosures of f, or by its Bernstein coefficients: they pass over what is proven free of zeros.
  bool by_enclosures() const { return reads == "enclosures"; }
};

struct Tally {
  std::array<std::size_t, 4> counts{};  // by status
  std::size_t wide_hits = 0;            // HITs wider than eps
};

// What a pass in double has told of some elements of an answer in floats: depths and uncertainties, one after the other.
struct Finer {
  std::vector<std::size_t> where;
  Memory depth, uncertainty;
};

// Per pixel or ray; `pitch` elements lie between rows. depth and uncertainty are double where `wide`.
struct Answer {
  std::size_t columns = 0, rows = 1, pitch = 0;
  bool wide = false;
  std::optional<Finer> finer;  // until somebody wants it (widen): doubles for all elements take as long as it takes to find such few
  std::optional<Memory> depth, uncertainty, status, normal, rgba, pieces;  // normal: three planes of rows * pitch floats
  std::size_t escalated = 0;     // pixels that another pass decides, or the reference
  std::size_t by_reference = 0;  // of these, those that the reference was asked about
  std::optional<Tally> tally;  // of the results as they are, once they have been looked at
  bool in_double = false;  // from the start, though the call left that open
  bool marched = false;  // the frustum form was refused, and contraction ran (Options::or_march)
  std::uint64_t builds = 0;
  double prepare_seconds = 0;  // coefficients, on the host
  double build_seconds = 0, launch_seconds = 0, kernel_seconds = 0;
  int width = 1;
  device::Outcome outcome = device::Outcome::done;

  // What another pass has cost, on top.
  void add_work_of(const Answer& pass) {
    builds += pass.builds;
    build_seconds += pass.build_seconds;
    launch_seconds += pass.launch_seconds;
    kernel_seconds += pass.kernel_seconds;
  }

  double depth_at(std::size_t i) const { return at(*depth, i); }
  double uncertainty_at(std::size_t i) const { return at(*uncertainty, i); }

 private:
  double at(const Memory& m, std::size_t i) const { return wide ? m.as<double>()[i] : static_cast<double>(m.as<float>()[i]); }
};

// Makes depths and uncertainties double where some of them are known in double (Answer::finer).
void widen(Answer& answer);

Answer render_frame(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
                    device::Device& device);

// By the frustum form; `program` is that of f. Throws MethodError where f is no polynomial, or one of too high a degree.
Answer render_frustum(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options, device::Device& device);

Answer trace_frustum(const program::Program& program, const Formulas& formulas, const Rays& rays, const Bounds& bounds,
                     const Options& options, device::Device& device);

// The source of the kernel that render_frustum would run at 640 x 480.
std::string frustum_source(const Expr& f, const std::map<std::string, double>& parameters, const Bounds& bounds, const Options& options,
                           const device::Device& device);

Answer trace_rays(const program::Program& program, const Formulas& formulas, const Rays& rays, const Bounds& bounds, const Options& options,
                  device::Device& device);

// Coordinates of pieces, rounded outward by the caller: 9 doubles each, three an axis (lo, hi, 0 or x, y, z). The
// result has lower, upper for each. With `directions`, the coordinates' changes in the same form, it is bounds of the derivative
// along them, nan where f may jump; throws MethodError where no rule gives that.
std::vector<std::array<double, 2>> enclose_pieces(const program::Program& program, std::span<const std::array<double, 9>> pieces,
                                                  std::span<const std::array<double, 9>> directions, const Options& options,
                                                  device::Device& device);

// The source of the kernel that the call would run.
std::string frame_source(const program::Program& program, const Bounds& bounds, const Options& options,
                         const device::Device& device);

}  // namespace irt::render
