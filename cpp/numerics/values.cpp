// Values at points: MPFR intervals of growing precision, until the doubles around the value are known.
#include "numerics/values.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "error.h"
#include "expr/build.h"
#include "numerics/mpfr_interval.h"

namespace irt::numerics {
namespace {

struct Step {
  Expr e;
  int axis = -1;       // 0, 1, 2 for x, y, z
  bool fixed = false;  // the same at all points
  std::vector<std::size_t> args;
};

std::vector<Step> steps_of(const Expr& f) {
  std::vector<Step> steps;
  std::unordered_map<const Node*, std::size_t> known;
  for (const Expr& e : postorder(f)) {
    Step s{e, -1, e.op() != Op::Symbol, {}};
    if (e.op() == Op::Symbol) {
      s.axis = e.name() == "x" ? 0 : e.name() == "y" ? 1 : e.name() == "z" ? 2 : -1;
      if (s.axis < 0) throw ExpressionError("'" + e.name() + "' has no value here; only x, y and z have");
    }
    for (const Expr& a : e.args()) {
      s.args.push_back(known.at(a.key()));
      s.fixed = s.fixed && steps[s.args.back()].fixed;
    }
    known[e.key()] = steps.size();
    steps.push_back(std::move(s));
  }
  return steps;
}

}  // namespace

std::vector<std::array<double, 2>> values_at(const Expr& f, std::span<const std::array<double, 3>> points) {
  if (f.is_condition()) throw ExpressionError("a condition has no value");
  constexpr mpfr_prec_t kFirst = 128, kLast = 4096;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Step> steps = steps_of(f);
  std::vector<std::array<double, 2>> out(points.size(), {kNone, kNone});
  std::vector<std::size_t> open(points.size());
  std::iota(open.begin(), open.end(), std::size_t{0});
  std::vector<const MpfrInterval*> args;
  for (mpfr_prec_t p = kFirst; p <= kLast && !open.empty(); p *= 2) {
    std::vector<MpfrInterval> values(steps.size(), MpfrInterval(p));
    bool first = true;
    std::vector<std::size_t> left;
    for (const std::size_t i : open) {
      for (std::size_t k = 0; k < steps.size(); ++k) {
        const Step& s = steps[k];
        if (s.fixed && !first) continue;
        if (s.axis >= 0) {
          const double at = points[i][static_cast<std::size_t>(s.axis)];
          values[k] = MpfrInterval::of(at, at, p);
          continue;
        }
        args.clear();
        for (std::size_t a : s.args) args.push_back(&values[a]);
        values[k] = apply(s.e, args, p);
      }
      first = false;
      const MpfrInterval& v = values.back();
      if (v.empty) continue;
      auto& best = out[i] = {mpfr_get_d(v.lo, MPFR_RNDD), mpfr_get_d(v.hi, MPFR_RNDU)};
      if (best[0] != best[1] && std::nextafter(best[0], HUGE_VAL) != best[1]) left.push_back(i);
    }
    open = std::move(left);
  }
  return out;
}

}  // namespace irt::numerics
