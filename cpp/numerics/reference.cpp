// Polynomials go to ray_polynomial.cpp. Everything else is subdivided here, front to back: a piece is excluded by the
// range of f, or f is shown monotone on it and its signs at the ends decide. Doubles first; from the piece that they
// cannot decide on, MPFR.
#include "numerics/reference.h"

#include <gmpxx.h>
#include <mpfr.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "error.h"
#include "numerics/crew.h"
#include "numerics/recent.h"

namespace irt::numerics {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// Pieces that one ray may take in an arithmetic before it is undecided. Named surfaces take some hundreds.
constexpr int kPiecesInDouble = 30'000, kPiecesInMpfr = 3'000;
constexpr mpfr_prec_t kPrecisions[] = {160, 640};
// With Query::quick so few pieces are looked at, and polynomials have so few coefficients to make (or are subdivided as other formulas
// are), that a ray takes a few milliseconds at most. Counted in operations, not in time: answers do not depend on how busy the machine is.
constexpr std::size_t kQuickWork = 400'000;
constexpr int kQuickPiecesInMpfr = 20;
// How often the caller is asked whether to stop, and how many rays a thread takes at a time: it stops between rays.
constexpr std::chrono::milliseconds kAskEvery{30};
constexpr std::size_t kMostAtATime = 4;
// Formulas of so many steps are forgotten at once: some megabytes each.
constexpr std::size_t kKeptSteps = 1 << 14;

std::optional<Clip> clip_of(const Ray& ray, double tmin, double tmax, const Query& query) {
  // Intervals around where the ray enters and leaves.
  Interval enter(tmin), leave(tmax);
  const auto cut = [&](const Interval& in, const Interval& out) {
    enter = {std::max(enter.lo, in.lo), std::max(enter.hi, in.hi)};
    leave = {std::min(leave.lo, out.lo), std::min(leave.hi, out.hi)};
  };
  const auto quotient = [](const Interval& a, double b) {
    const double p = a.lo / b, q = a.hi / b;
    return Interval(down(std::min(p, q)), up(std::max(p, q)));
  };
  for (int k = 0; k < 3; ++k) {
    const double o = ray.origin[k], d = ray.direction[k];
    if (d == 0) {
      if (o < query.lower[k] || o > query.upper[k]) return std::nullopt;
      continue;
    }
    const Interval low = quotient(Interval(query.lower[k]) - Interval(o), d), high = quotient(Interval(query.upper[k]) - Interval(o), d);
    d > 0 ? cut(low, high) : cut(high, low);
  }
  for (const Sphere& s : query.spheres) {
    Interval aa(0), ab(0), bb(0);
    for (int k = 0; k < 3; ++k) {
      const Interval d(ray.direction[k]), c = Interval(ray.origin[k]) - Interval(s.center[k]);
      aa = aa + d * d;
      ab = ab + d * c;
      bb = bb + c * c;
    }
    // |c + t d| = r, about the nearest point: t = -ab / aa -+ sqrt(r^2 - |c - (ab / aa) d|^2) / sqrt(aa)
    const Interval* one[] = {&aa};
    const Interval inverse = apply(Op::Pow, -1, one), nearest = -(ab * inverse);
    Interval distance(0);
    for (int k = 0; k < 3; ++k) {
      const Interval at = Interval(ray.origin[k]) - Interval(s.center[k]) + nearest * Interval(ray.direction[k]);
      const Interval* args[] = {&at};
      distance = distance + apply(Op::Pow, 2, args);
    }
    const Interval left = (Interval(s.radius) * Interval(s.radius) - distance) * inverse;
    if (left.hi < 0) return std::nullopt;
    const Interval reach(std::max(0.0, down(std::sqrt(std::max(0.0, left.lo)))), up(std::sqrt(left.hi)));
    cut(nearest - reach, nearest + reach);
  }
  for (const HalfSpace& h : query.half_spaces) {
    mpq_class slope, left(h.offset);
    for (int k = 0; k < 3; ++k) {
      const mpq_class n(h.normal[k]);
      slope += n * mpq_class(ray.direction[k]);
      left -= n * mpq_class(ray.origin[k]);
    }
    if (sgn(slope) == 0) {
      if (sgn(left) < 0) return std::nullopt;
      continue;
    }
    const double t = mpq_class(left / slope).get_d();  // truncated
    const Interval at(down(t), up(t));
    sgn(slope) > 0 ? cut(Interval(-kInf, -kInf), at) : cut(at, Interval(kInf, kInf));
  }
  if (!(enter.lo <= leave.hi)) return std::nullopt;
  if (!std::isfinite(enter.lo) || !std::isfinite(leave.hi)) throw ArgumentError("a ray is left infinite");
  return Clip{enter.lo, enter.hi, leave.lo, leave.hi};
}

struct Piece {
  double a, b;
};

class March {
 public:
  March(const Clip& clip, Arithmetic arithmetic, const Stop& stop) : clip_(clip), arithmetic_(arithmetic), stop_(stop), span_(clip.leave_hi - clip.enter_lo) {}

  // From the last of `stack` on; where undecided, `stack` still holds that piece and what follows.
  Root run(std::vector<Piece>& stack, Along& along, int budget) {
    for (; !stack.empty(); stop_()) {
      const Piece p = stack.back();
      const Look look = along.look(p.a, p.b);
      if (look.empty || look.sign) {
        stack.pop_back();
        continue;
      }
      if (!look.doubtful && look.slope) {
        const int left = along.sign(p.a), right = along.sign(p.b);
        if (left * right > 0) {
          stack.pop_back();
          continue;
        }
        if (left * right < 0) return bracket(stack, p, left, along);
      }
      if (p.b - p.a <= 0.25 * wanted_width(p.a, span_)) return smallest(p, along);
      if (--budget < 0) return {Kind::undecided, p.a, p.b, arithmetic_};
      // Off the middle: the roots of symmetric scenes lie in the middle.
      const double m = p.a + 0.48828125 * (p.b - p.a);
      stack.back() = {m, p.b};
      stack.push_back({p.a, m});
    }
    return {Kind::miss, 0, 0, arithmetic_};
  }

 private:
  Root answer(double lo, double hi) const {
    // Whether it lies inside is not known at the very ends of the clip.
    const bool edge = lo < clip_.enter_hi || hi > clip_.leave_lo;
    return {edge ? Kind::undecided : Kind::hit, lo, hi, arithmetic_};
  }

  // One root in p, opposite signs at its ends.
  Root bracket(std::vector<Piece>& stack, Piece p, int left, Along& along) const {
    while (p.b - p.a > 0.2 * wanted_width(p.a, span_)) {
      const double m = 0.5 * (p.a + p.b);
      if (m <= p.a || m >= p.b) break;
      int s = along.sign(m);
      if (s == 0) {
        // The root is about there: a little to both sides.
        const double w = 0.1 * wanted_width(m, span_), lo = std::max(p.a, m - w), hi = std::min(p.b, m + w);
        if (along.sign(lo) == left && along.sign(hi) == -left) {
          p = {lo, hi};
          break;
        }
        stack.back() = p;
        return {Kind::undecided, p.a, p.b, arithmetic_};
      }
      (s == left ? p.a : p.b) = m;
    }
    return answer(p.a, p.b);
  }

  // A piece that cannot be divided further: the root may lie at an end of it, or be of odd multiplicity.
  Root smallest(Piece p, Along& along) const {
    const double length = p.b - p.a;
    for (double w = 0.125 * length; w > 0 && p.b - p.a + 2 * w <= wanted_width(p.a, span_); w *= 1.5) {
      const Piece q{p.a - w, p.b + w};
      const Look look = along.look(q.a, q.b);
      if (look.doubtful) break;
      const int left = along.sign(q.a), right = along.sign(q.b);
      if (left * right < 0) return answer(q.a, q.b);
    }
    return {Kind::undecided, p.a, p.b, arithmetic_};
  }

  const Clip& clip_;
  Arithmetic arithmetic_;
  const Stop& stop_;
  double span_;
};

// What one thread needs for formulas that are no polynomials.
class Subdivision {
 public:
  Subdivision(const Formula& formula, bool quick) : formula_(formula), quick_(quick), in_double_(along_in_double(formula, ray_)) {}

  Root first_root(const Ray& ray, const Clip& clip, const Stop& stop) {
    ray_ = ray;
    std::vector<Piece> stack{{clip.enter_lo, clip.leave_hi}};
    Root root = March(clip, Arithmetic::dbl, stop).run(stack, *in_double_, quick_ ? static_cast<int>(std::min<std::size_t>(1000, kQuickWork / formula_.steps().size())) : kPiecesInDouble);
    const std::size_t arithmetics = quick_ ? 1 : std::size(kPrecisions);
    for (std::size_t k = 0; k < arithmetics && root.kind == Kind::undecided; ++k) {
      if (!in_mpfr_[k]) in_mpfr_[k] = along_in_mpfr(formula_, ray_, kPrecisions[k]);
      root = March(clip, Arithmetic::mpfr, stop).run(stack, *in_mpfr_[k], quick_ ? kQuickPiecesInMpfr : kPiecesInMpfr);
    }
    return root;
  }

 private:
  const Formula& formula_;
  bool quick_;
  Ray ray_{};
  std::unique_ptr<Along> in_double_;
  std::array<std::unique_ptr<Along>, std::size(kPrecisions)> in_mpfr_;
};

// Where the sign of the clip formula g decides which zeros count. For one thread.
class Region {
 public:
  Region(const Formula& g) : formula_(g), in_double_(along_in_double(g, ray_)) {}

  // What `search` finds first on the clipped ray, and counts; past zeros where g is above zero it goes on.
  template <class Search>
  Root first_root(const Ray& ray, Clip clip, const Search& search) {
    ray_ = ray;
    const double span = clip.leave_hi - clip.enter_lo;
    for (int k = 0; k < kPassedOver; ++k) {
      Root root = search(clip);
      if (root.kind == Kind::miss) return root;
      const int side = side_of(root.lo, root.hi, true);
      if (side < 0) return root;
      if (side == 0) return {Kind::undecided, root.lo, root.hi, root.arithmetic};
      // As far as g stays above zero nothing counts.
      double end = root.hi;
      for (double w = std::max(root.hi - root.lo, 1e-12 * span); end < clip.leave_hi && side_of(root.lo, root.hi + w, false) > 0; w *= 2) end = root.hi + w;
      if (end >= clip.leave_hi) return {Kind::miss, 0, 0, root.arithmetic};
      clip.enter_lo = clip.enter_hi = end;
    }
    return {Kind::undecided, clip.enter_lo, clip.leave_hi, Arithmetic::none};
  }

 private:
  static constexpr int kPassedOver = 1000;

  // 1: outside on all of [a, b], -1: inside, 0: not known, by more bits where it matters.
  int side_of(double a, double b, bool matters) {
    const auto side = [](const Look& look) { return look.empty || look.sign > 0 ? 1 : (look.sign < 0 || look.nonpositive) && !look.doubtful ? -1 : 0; };
    int known = side(in_double_->look(a, b));
    for (std::size_t k = 0; matters && k < std::size(kPrecisions) && known == 0; ++k) {
      if (!in_mpfr_[k]) in_mpfr_[k] = along_in_mpfr(formula_, ray_, kPrecisions[k]);
      known = side(in_mpfr_[k]->look(a, b));
    }
    return known;
  }

  const Formula& formula_;
  Ray ray_{};
  std::unique_ptr<Along> in_double_;
  std::array<std::unique_ptr<Along>, std::size(kPrecisions)> in_mpfr_;
};

// What all rays share.
struct Prepared {
  Prepared(const Expr& f, const std::map<std::string, double>& parameters) : formula(f, parameters), plan(PolynomialPlan::of(formula)) {}
  Prepared(const Prepared&) = delete;  // the plan points to the formula
  Formula formula;
  std::optional<PolynomialPlan> plan;
};

}  // namespace

std::vector<Root> reference(const Expr& f, std::span<const Ray> rays, const double* tmin, const double* tmax, const Query& query) {
  static auto* const recent = new Recent<std::pair<Expr, std::map<std::string, double>>, Prepared>;  // frames ask again and again
  const auto prepared = recent->get(
      {f, query.parameters}, [&] { return std::make_shared<const Prepared>(f, query.parameters); }, [](const Prepared& p) { return p.formula.steps().size() < kKeptSteps; });
  const Formula& formula = prepared->formula;
  const PolynomialPlan* plan = prepared->plan ? &*prepared->plan : nullptr;
  if (query.quick && plan && formula.steps().size() * static_cast<std::size_t>(plan->degree()) * static_cast<std::size_t>(plan->degree()) > kQuickWork)
    plan = nullptr;
  std::optional<Formula> g;
  if (query.clip) g.emplace(*query.clip, query.parameters);
  std::vector<Root> roots(rays.size());
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<bool> stopped{false};
  std::mutex mutex;
  std::exception_ptr failure;
  // Asked by the caller's thread alone, which Python knows.
  auto asked = std::chrono::steady_clock::now();
  const auto ask = [&] {
    const auto now = std::chrono::steady_clock::now();
    if (!query.stop || now - asked < kAskEvery) return;
    asked = now;
    if (query.stop(static_cast<double>(done) / static_cast<double>(rays.size()))) stopped = true;
  };

  // Few rays are shared out too.
  const std::size_t chunk = std::clamp<std::size_t>(rays.size() / (4 * crew_size()), 1, kMostAtATime);
  const auto work = [&](std::size_t worker) {
    try {
      Subdivision subdivision(formula, query.quick);
      std::optional<Region> region;
      if (g) region.emplace(*g);
      const Stop stop = [&] {
        if (worker == 0) ask();
        if (stopped) throw Stopped{};
      };
      for (std::size_t first; !stopped && (first = next.fetch_add(chunk)) < rays.size();) {
        const std::size_t last = std::min(first + chunk, rays.size());
        for (std::size_t i = first; i < last; ++i) {
          const auto clip = clip_of(rays[i], tmin[i], tmax[i], query);
          if (!clip) {
            roots[i] = {Kind::miss, 0, 0, Arithmetic::dbl};
          } else {
            roots[i] = {Kind::undecided, clip->enter_lo, clip->leave_hi, Arithmetic::none};
            const auto search = [&](const Clip& c) { return plan ? plan->first_root(rays[i], c, stop) : subdivision.first_root(rays[i], c, stop); };
            roots[i] = region ? region->first_root(rays[i], *clip, search) : search(*clip);
          }
          ++done;
          stop();
        }
      }
      // Who asks stays until the others are done.
      for (int k = 0; worker == 0 && done < rays.size(); ++k) {
        stop();
        k < 1000 ? std::this_thread::yield() : std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    } catch (const Stopped&) {  // what it was at stays open
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
      stopped = true;
    }
    mpfr_free_cache();
  };
  by_crew(work);
  if (failure) std::rethrow_exception(failure);
  return roots;
}

}  // namespace irt::numerics
