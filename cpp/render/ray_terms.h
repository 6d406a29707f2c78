// A batch of rays for kernels/ray_list.cl, each moved in long double to its point nearest the middle of the bounds.
#pragma once

#include "render/launch.h"

namespace irt::render {

struct RayTerms {
  Reals terms;
  double pad = 0;
  // Per ray, for who needs t: t = (nearest + s) scale.
  std::vector<long double> nearest, scale;
};

// `which`: the rays that count, nullptr: all; lanes past `count` repeat the last, up to `padded`.
RayTerms make_terms(const Rays& rays, const std::vector<std::size_t>* which, std::size_t count, std::size_t padded,
                    const Bounds& bounds, program::Precision precision, bool split);

}  // namespace irt::render
