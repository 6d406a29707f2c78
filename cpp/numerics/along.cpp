// Enclosures along a ray: the natural extension, cut with the mean value form where f is continuous.
#include "numerics/along.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"

namespace irt::numerics {
namespace {

int axis_of(const Expr& e) {
  if (e.op() != Op::Symbol || e.name().size() != 1) return -1;
  return e.name() == "x" ? 0 : e.name() == "y" ? 1 : e.name() == "z" ? 2 : -1;
}

constexpr mpfr_prec_t kConstantBits = 128;

Interval outward(const MpfrInterval& v) {
  Interval r(mpfr_get_d(v.lo, MPFR_RNDD), mpfr_get_d(v.hi, MPFR_RNDU));
  r.empty = v.empty;
  r.doubtful = v.doubtful;
  return r;
}

class DoubleAlong final : public Along {
 public:
  DoubleAlong(const Formula& formula, const Ray& ray) : formula_(formula), ray_(ray), values_(formula) {}

  Look look(double a, double b) override {
    run(Interval(a, b), formula_.steps().size());
    const Interval f = values_.f();
    Look look{.sign = f.sign(), .empty = f.empty, .doubtful = f.doubtful, .nonpositive = !f.empty && f.hi <= 0, .slope = 0};
    if (look.sign || look.empty || look.doubtful) return look;
    const Interval slope = derivative();
    look.slope = slope.sign();
    if (slope.empty || !slope.finite()) return look;
    // f(m) + f'([a, b]) ([a, b] - m)
    const double m = 0.5 * (a + b);
    run(Interval(m), formula_.f() + 1);
    const Interval& middle = values_.f();
    if (!middle.empty && !middle.doubtful) look.sign = (middle + slope * (Interval(a, b) - Interval(m))).sign();
    return look;
  }

  int sign(double t) override {
    const Interval& f = value(t);
    return f.doubtful ? 0 : f.sign();
  }

  const Interval& value(double t) {
    run(Interval(t), formula_.f() + 1);
    return values_.f();
  }

 private:
  void run(const Interval& t, std::size_t count) {
    values_.run(count, [&](int axis) { return Interval(ray_.origin[axis]) + Interval(ray_.direction[axis]) * t; });
  }

  Interval derivative() const {
    Interval sum(0);
    for (int axis = 0; axis < 3; ++axis) {
      if (ray_.direction[axis] == 0) continue;
      const Interval& g = values_[formula_.gradient()[axis]];
      if (g.empty) return g;
      sum = sum + g * Interval(ray_.direction[axis]);
    }
    return sum;
  }

  const Formula& formula_;
  const Ray& ray_;
  Enclosures values_;
};

class MpfrAlong final : public Along {
 public:
  MpfrAlong(const Formula& formula, const Ray& ray, mpfr_prec_t precision)
      : formula_(formula), ray_(ray), precision_(precision), values_(formula.steps().size(), MpfrInterval(precision)) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const Formula::Step& step = formula.steps()[i];
      if (step.constant) values_[i] = formula.constant(step, arguments(step), precision);
    }
  }

  Look look(double a, double b) override {
    const MpfrInterval t = MpfrInterval::of(a, b, precision_);
    run(t, values_.size());
    const MpfrInterval& f = values_[formula_.f()];
    Look look{.sign = sign_of(f), .empty = f.empty, .doubtful = f.doubtful, .nonpositive = !f.empty && !mpfr_nan_p((mpfr_srcptr)f.hi) && mpfr_sgn((mpfr_srcptr)f.hi) <= 0, .slope = 0};
    if (look.sign || look.empty || look.doubtful) return look;
    MpfrInterval slope(precision_);
    if (!derivative(slope)) return look;
    look.slope = sign_of(slope);
    const double m = 0.5 * (a + b);
    run(MpfrInterval::of(m, m, precision_), formula_.f() + 1);
    const MpfrInterval& middle = values_[formula_.f()];
    if (middle.empty || middle.doubtful) return look;
    MpfrInterval off = t;
    mpfr_sub_d(off.lo, off.lo, m, MPFR_RNDD);
    mpfr_sub_d(off.hi, off.hi, m, MPFR_RNDU);
    const MpfrInterval step = product(slope, off);
    mpfr_add(off.lo, middle.lo, step.lo, MPFR_RNDD);
    mpfr_add(off.hi, middle.hi, step.hi, MPFR_RNDU);
    look.sign = sign_of(off);
    return look;
  }

  int sign(double t) override {
    run(MpfrInterval::of(t, t, precision_), formula_.f() + 1);
    const MpfrInterval& f = values_[formula_.f()];
    return f.empty || f.doubtful ? 0 : sign_of(f);
  }

 private:
  static int sign_of(const MpfrInterval& v) {
    if (v.empty || mpfr_nan_p((mpfr_srcptr)v.lo) || mpfr_nan_p((mpfr_srcptr)v.hi)) return 0;
    return mpfr_sgn((mpfr_srcptr)v.lo) > 0 ? 1 : mpfr_sgn((mpfr_srcptr)v.hi) < 0 ? -1 : 0;
  }

  static MpfrInterval product(const MpfrInterval& a, const MpfrInterval& b) {
    static const Expr times = mul(symbol("x"), symbol("y"));
    const MpfrInterval* args[] = {&a, &b};
    return apply(times, args, a.precision());
  }

  std::span<const MpfrInterval* const> arguments(const Formula::Step& step) {
    args_.clear();
    for (const std::uint32_t k : step.args) args_.push_back(&values_[k]);
    return args_;
  }

  void run(const MpfrInterval& t, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const Formula::Step& step = formula_.steps()[i];
      if (step.constant) continue;
      if (step.axis < 0) {
        values_[i] = apply(step.e, arguments(step), precision_);
        continue;
      }
      MpfrInterval& v = values_[i];
      const double d = ray_.direction[step.axis], o = ray_.origin[step.axis];
      mpfr_mul_d(v.lo, d < 0 ? t.hi : t.lo, d, MPFR_RNDD);
      mpfr_mul_d(v.hi, d < 0 ? t.lo : t.hi, d, MPFR_RNDU);
      mpfr_add_d(v.lo, v.lo, o, MPFR_RNDD);
      mpfr_add_d(v.hi, v.hi, o, MPFR_RNDU);
    }
  }

  // False where it has no bounds.
  bool derivative(MpfrInterval& sum) const {
    mpfr_set_zero(sum.lo, 1);
    mpfr_set_zero(sum.hi, 1);
    Real part(precision_);
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray_.direction[axis];
      if (d == 0) continue;
      const MpfrInterval& g = values_[formula_.gradient()[axis]];
      if (g.empty || !mpfr_number_p((mpfr_srcptr)g.lo) || !mpfr_number_p((mpfr_srcptr)g.hi)) return false;
      mpfr_mul_d(part, d < 0 ? g.hi : g.lo, d, MPFR_RNDD);
      mpfr_add(sum.lo, sum.lo, part, MPFR_RNDD);
      mpfr_mul_d(part, d < 0 ? g.lo : g.hi, d, MPFR_RNDU);
      mpfr_add(sum.hi, sum.hi, part, MPFR_RNDU);
    }
    return true;
  }

  const Formula& formula_;
  const Ray& ray_;
  mpfr_prec_t precision_;
  std::vector<MpfrInterval> values_;
  std::vector<const MpfrInterval*> args_;
};

}  // namespace

Formula::Formula(const Expr& f, const std::map<std::string, double>& parameters, bool gradient) : parameters_(parameters) {
  std::unordered_map<const Node*, std::uint32_t> index;
  std::vector<MpfrInterval> constants;
  const auto append = [&](const Expr& root) {
    for (const Expr& p : postorder(root)) {
      if (index.count(p.key())) continue;
      Step step{.e = p, .args = {}, .value = {}};
      step.axis = axis_of(p);
      step.constant = step.axis < 0;
      for (const Expr& a : p.args()) {
        step.args.push_back(index.at(a.key()));
        step.constant = step.constant && steps_[step.args.back()].constant;
      }
      if (p.op() == Op::Symbol && step.axis < 0 && !parameters_.count(p.name()))
        throw ArgumentError("parameter '" + p.name() + "' has no value; give it in params");
      if (p.op() == Op::Pow && p.arg(1).op() == Op::Number && p.arg(1).number().get_den() == 1) {
        if (abs(p.arg(1).number().get_num()) > limits::kExponent)
          throw LimitError(fmt::format("the power {} is above the limit of {}", p.arg(1).number().get_str(), limits::kExponent));
        step.exponent = p.arg(1).number().get_num().get_si();
      }
      constants.emplace_back(kConstantBits);
      if (step.constant) {
        std::vector<const MpfrInterval*> args;
        for (const std::uint32_t k : step.args) args.push_back(&constants[k]);
        constants.back() = constant(step, args, kConstantBits);
        step.value = outward(constants.back());
      }
      if (steps_.size() >= limits::kNodes)
        throw LimitError(fmt::format("the formula and its derivatives have {} parts or more; the limit is {}", steps_.size() + 1, limits::kNodes));
      index.emplace(p.key(), static_cast<std::uint32_t>(steps_.size()));
      steps_.push_back(std::move(step));
    }
    return index.at(root.key());
  };
  f_ = append(f);
  if (!gradient) return;
  const char* axes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) gradient_[axis] = append(differentiate(f, axes[axis]));
}

MpfrInterval Formula::constant(const Step& step, std::span<const MpfrInterval* const> args, mpfr_prec_t precision) const {
  if (step.e.op() != Op::Symbol) return apply(step.e, args, precision);
  const double v = parameters_.at(step.e.name());
  return MpfrInterval::of(v, v, precision);
}

Enclosures::Enclosures(const Formula& formula) : formula_(formula) {
  for (const Formula::Step& step : formula.steps()) values_.push_back(step.value);
}

double single_blur(const Expr& f, const glm::dvec3& lower, const glm::dvec3& upper, const std::map<std::string, double>& parameters) {
  constexpr int kLines = 12, kSteps = 32, kHalvings = 8;
  constexpr std::size_t kEnough = 7;
  const Formula formula(f, parameters, false);
  Ray ray{};
  DoubleAlong along(formula, ray);
  std::vector<double> blurs;
  for (int k = 0; k < kLines && blurs.size() < kEnough; ++k) {
    // Points of a sequence of low discrepancy on opposite faces of the box, three pairs of faces in turn.
    const int axis = k % 3;
    glm::dvec3 from(0), to(1);
    for (int i = 1; i < 3; ++i) {
      const int other = (axis + i) % 3;
      from[other] = std::fmod(0.5 + k * (i == 1 ? 0.7548776662466927 : 0.5698402909980532), 1);
      to[other] = std::fmod(0.25 + k * (i == 1 ? 0.5698402909980532 : 0.7548776662466927), 1);
    }
    from = glm::mix(lower, upper, from);
    to = glm::mix(lower, upper, to);
    ray = {from, glm::normalize(to - from)};
    const double step = glm::length(to - from) / kSteps;
    int before = 0;
    for (int j = 0; j <= kSteps; ++j) {
      const int now = along.sign(j * step);
      if (before * now < 0) {
        double a = (j - 1) * step, b = j * step;
        for (int n = 0; n < kHalvings; ++n) {
          const double m = 0.5 * (a + b);
          (along.sign(m) == now ? b : a) = m;
        }
        const Interval at_a = along.value(a), at_b = along.value(b);
        const double slope = std::fabs(0.5 * (at_b.lo + at_b.hi) - 0.5 * (at_a.lo + at_a.hi)) / (b - a);
        if (slope > 0) blurs.push_back(0x1p29 * std::max(at_a.hi - at_a.lo, at_b.hi - at_b.lo) / slope);
      }
      before = now;
    }
  }
  if (blurs.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::nth_element(blurs, blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 2));
  return blurs[blurs.size() / 2];
}

std::unique_ptr<Along> along_in_double(const Formula& formula, const Ray& ray) { return std::make_unique<DoubleAlong>(formula, ray); }

std::unique_ptr<Along> along_in_mpfr(const Formula& formula, const Ray& ray, mpfr_prec_t precision) {
  return std::make_unique<MpfrAlong>(formula, ray, precision);
}

}  // namespace irt::numerics
