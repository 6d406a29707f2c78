#include "numerics/around_zeros.h"

#include <algorithm>

#include "numerics/along.h"

namespace irt::numerics {
namespace {

// Whether f has no zero in the box: by its range there, or in both halves, so many times.
bool free_of_zeros(Enclosures& values, std::size_t count, const Box& box, int halvings) {
  values.run(count, [&](int axis) { return Interval(box.lower[axis], box.upper[axis]); });
  if (values.f().empty || values.f().sign()) return true;
  if (halvings == 0) return false;
  const glm::dvec3 size = box.upper - box.lower;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  Box low = box, high = box;
  low.upper[axis] = high.lower[axis] = 0.5 * (box.lower[axis] + box.upper[axis]);
  return free_of_zeros(values, count, low, halvings - 1) && free_of_zeros(values, count, high, halvings - 1);
}

}  // namespace

Box around_zeros(const Expr& f, const std::map<std::string, double>& parameters, const Box& box) {
  // How thick a slab can be cut off is halved in on so many times; thicker ones are looked at in smaller parts.
  constexpr int kCuts = 11, kHalvings = 5;
  constexpr double kLeft = 0.0625, kRoom = 0x1p-12;
  const Formula formula(f, parameters, false);
  const std::size_t count = formula.f() + 1;
  Enclosures values(formula);
  Box left = box;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool above : {false, true}) {
      double &end = above ? left.upper[axis] : left.lower[axis], &other = above ? left.lower[axis] : left.upper[axis];
      double cut = end, most = other + kLeft * (end - other);
      const double room = kRoom * (end - other);
      if (end - room == end) continue;  // there are few doubles between
      for (int n = 0; n < kCuts; ++n) {
        const double middle = 0.5 * (cut + most);
        Box slab = left;
        (above ? slab.upper : slab.lower)[axis] = cut;
        (above ? slab.lower : slab.upper)[axis] = middle;
        (free_of_zeros(values, count, slab, std::max(0, kHalvings - n)) ? cut : most) = middle;
      }
      end = above ? std::min(end, cut + room) : std::max(end, cut + room);
    }
  return left;
}

}  // namespace irt::numerics
