#include "numerics/around_zeros.h"

#include <algorithm>

#include "expr/build.h"
#include "numerics/along.h"

namespace irt::numerics {
namespace {

// Looks for what is free of zeros, by so many values at most.
class Search {
 public:
  explicit Search(const Formula& formula) : values_(formula), steps_(formula.f() + 1) {}

  void allow(std::size_t values) { allowed_ = values; }

  // Whether f has no zero in the box: by its range there, or in both halves, so many times.
  bool free(const Box& box, int halvings) {
    if (allowed_ == 0) return false;
    --allowed_;
    values_.run(steps_, [&](int axis) { return Interval(box.lower[axis], box.upper[axis]); });
    if (values_.f().empty || values_.f().sign()) return true;
    if (halvings == 0) return false;
    const glm::dvec3 size = box.upper - box.lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    Box low = box, high = box;
    low.upper[axis] = high.lower[axis] = 0.5 * (box.lower[axis] + box.upper[axis]);
    return free(low, halvings - 1) && free(high, halvings - 1);
  }

 private:
  Enclosures values_;
  std::size_t steps_;
  std::size_t allowed_ = 0;
};

}  // namespace

Box around_zeros(const Expr& f, const std::map<std::string, double>& parameters, const Box& box) {
  // Values for each side, of which each takes 30 to 50 nanoseconds a part of the formula. Formulas that have so many that few values are left, mostly multiplied out, have
  // wide ranges as well.
  constexpr std::size_t kParts = 2000, kFewest = 8;
  // How thick a slab can be cut off is halved in on so many times, after a first try; thicker ones are looked at in smaller parts.
  constexpr int kCuts = 12, kHalvings = 5;
  constexpr double kFirst = 1.0 / 64, kLeft = 0.0625, kRoom = 0x1p-13;
  const std::size_t allowed = kParts / postorder(f).size();
  if (allowed < kFewest) return box;
  const Formula formula(f, parameters, false);
  Search search(formula);
  Box left = box;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool above : {false, true}) {
      double &end = above ? left.upper[axis] : left.lower[axis], &other = above ? left.lower[axis] : left.upper[axis];
      const double side = other - end, room = kRoom * side;
      if (end + room == end) continue;  // there are few doubles between
      search.allow(allowed);
      const auto cuts = [&](double from, double to, int halvings) {
        Box slab = left;
        (above ? slab.upper : slab.lower)[axis] = from;
        (above ? slab.lower : slab.upper)[axis] = to;
        return search.free(slab, halvings);
      };
      double cut = end + kFirst * side, most = end + (1 - kLeft) * side;
      if (!cuts(end, cut, kHalvings)) continue;
      for (int n = 0; n < kCuts; ++n) {
        const double middle = 0.5 * (cut + most);
        (cuts(cut, middle, std::max(0, kHalvings + 1 - n)) ? cut : most) = middle;
      }
      end = above ? std::min(end, cut - room) : std::max(end, cut - room);
    }
  return left;
}

}  // namespace irt::numerics
