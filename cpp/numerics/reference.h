// The reference: the first zero of f on each ray, proven, whatever that takes.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "numerics/ray_polynomial.h"

namespace irt::numerics {

struct Sphere {
  glm::dvec3 center;
  double radius;
};

// normal . p <= offset
struct HalfSpace {
  glm::dvec3 normal;
  double offset;
};

struct Query {
  glm::dvec3 lower, upper;
  std::vector<Sphere> spheres;
  std::vector<HalfSpace> half_spaces;
  std::optional<Expr> clip;  // zeros where it is above zero, or undefined, do not count
  std::map<std::string, double> parameters;
  // Asked on the calling thread, many times a second; true ends the work, and the rays left are undecided.
  std::function<bool(double done)> stop;
  // Gives up on what would take long: rays of more than some hundred pieces, high degrees.
  bool quick = false;
};

// rays[i] for t in [tmin[i], tmax[i]] (exactly these doubles), clipped to the bounds. Uses all cores.
std::vector<Root> reference(const Expr& f, std::span<const Ray> rays, const double* tmin, const double* tmax, const Query& query);

}  // namespace irt::numerics
