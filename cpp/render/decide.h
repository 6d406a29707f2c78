// Rays that a kernel left open, decided by the reference on the host and shaded there: a few rays are not worth a kernel.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "numerics/reference.h"
#include "render/launch.h"

namespace irt::render {

// Pixels row * pitch + column of a view as rays with unit directions.
std::vector<numerics::Ray> rays_of(const View& view, const std::vector<std::size_t>& pixels, std::size_t pitch);

// Of a batch, all or some.
std::vector<numerics::Ray> rays_of(const Rays& rays);
std::vector<numerics::Ray> rays_of(const Rays& rays, const std::vector<std::size_t>& which);

// What the reference is asked, or asked in its quick way. The options must outlive it.
numerics::Query query_of(const Formulas& formulas, const Bounds& bounds, const Options& options, bool quick = false);

// Puts what the reference finds on `rays`, which are the elements `where` of the answer, into it: status, depth, uncertainty, normal,
// colour. t counts in lengths of the directions. Returns those that it cannot decide, which stay as they are.
std::vector<std::size_t> decide(Answer& answer, const std::vector<std::size_t>& where, const std::vector<numerics::Ray>& rays,
                                const double* tmin, const double* tmax, const Formulas& formulas, const numerics::Query& query, const Options& options);

// The same for the pixels of a view, all of the ray in front of the eye.
std::vector<std::size_t> decide(Answer& answer, const std::vector<std::size_t>& where, const std::vector<numerics::Ray>& rays,
                                const Formulas& formulas, const numerics::Query& query, const Options& options);

// The same for some of a batch of rays, which are the answer's elements.
std::vector<std::size_t> decide_rays(Answer& answer, const std::vector<std::size_t>& where, const Rays& rays, const Formulas& formulas,
                                     const numerics::Query& query, const Options& options);

// How rays that single precision left open, elements of the answer, are decided.
struct Second {
  std::function<std::vector<std::size_t>(const std::vector<std::size_t>&)> refer;  // `decide`, in the reference's quick way
  std::function<Answer(const std::vector<std::size_t>&)> pass;                     // by the kernel in double
  std::function<bool()> prepare;                                                   // begins to build that kernel; whether it is there
};

// By the reference and the kernel in double: by whichever is at hand first, and what that leaves by the other.
void decide_open(Answer& answer, const program::Program& program, const Second& second, const Options& options);

// Unit normals towards the viewer at the points of the rays given, from the gradient in double; nan where there is none. `front`: the
// side of the viewer is that where f > 0.
struct HostNormals {
  std::vector<glm::dvec3> normals;
  std::vector<bool> front;
};
HostNormals normals_at(const Formulas& formulas, const std::vector<numerics::Ray>& rays, const std::vector<double>& t);

}  // namespace irt::render
