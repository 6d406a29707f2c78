// The polynomial over the whole frustum, composed from its formula by Bernstein arithmetic; see frustum_form.h.
#include <algorithm>
#include <cmath>

#include "error.h"
#include "numerics/double_double.h"
#include "numerics/frustum_form.h"
#include "numerics/widest.h"

namespace irt::numerics {
namespace {

__extension__ typedef __float128 Quad;

DoubleDouble rounded(Quad v) {
  const double hi = static_cast<double>(v);
  return {hi, std::isfinite(hi) ? static_cast<double>(v - static_cast<Quad>(hi)) : 0};
}

// n sums hi + lo and the sums of the sizes of all that went into each.
class Values {
 public:
  explicit Values(std::size_t n) : n_(n), all_(3 * n) {}
  std::size_t count() const { return n_; }
  double* hi() { return all_.data(); }
  double* lo() { return all_.data() + n_; }
  double* size() { return all_.data() + 2 * n_; }
  const double* hi() const { return all_.data(); }
  const double* lo() const { return all_.data() + n_; }
  const double* size() const { return all_.data() + 2 * n_; }
  DoubleDouble at(std::size_t i) const { return {hi()[i], lo()[i]}; }
  void set(std::size_t i, const DoubleDouble& v) {
    hi()[i] = v.hi;
    lo()[i] = v.lo;
    size()[i] = std::fabs(v.hi);
  }

 private:
  std::size_t n_;
  std::vector<double> all_;  // in one block: small tensors are many
};

// A tensor in the scaled Bernstein basis u^i (1 - u)^(n - i), of degree n along each axis; `depth` bounds how many roundings each of its values has seen.
struct Tensor {
  explicit Tensor(int degree = 0) : degree(degree), values(side() * side() * side()) {}
  int degree;
  double depth = 0;
  Values values;

  std::size_t side() const { return static_cast<std::size_t>(degree) + 1; }
};

// to[at + m] += with[from + m] for n values, times (v, s) where `times` is given.
[[gnu::always_inline]] inline void add_run(Values& to, std::size_t at, const Values& with, std::size_t from, std::size_t n, DoubleDouble v, double s, bool times) {
  double *const hi = to.hi() + at, *const lo = to.lo() + at, *const size = to.size() + at;
  const double *const with_hi = with.hi() + from, *const with_lo = with.lo() + from, *const with_size = with.size() + from;
#pragma GCC ivdep
  for (std::size_t m = 0; m < n; ++m) {
    const DoubleDouble w{with_hi[m], with_lo[m]}, sum = near_sum({hi[m], lo[m]}, times ? v * w : w);
    hi[m] = sum.hi;
    lo[m] = sum.lo;
    size[m] += times ? s * with_size[m] : with_size[m];
  }
}

// The same values in a tensor of a larger side, with zeros beyond.
Values spread(const Values& v, std::size_t side, std::size_t larger) {
  Values out(larger * larger * larger);
  for (std::size_t i = 0; i < side; ++i)
    for (std::size_t j = 0; j < side; ++j) {
      const std::size_t from = (i * side + j) * side, to = (i * larger + j) * larger;
      std::copy_n(v.hi() + from, side, out.hi() + to);
      std::copy_n(v.lo() + from, side, out.lo() + to);
      std::copy_n(v.size() + from, side, out.size() + to);
    }
  return out;
}

// Whether a coordinate is the same at both ends along an axis: 1 innermost, 2 or 4.
bool same_along(const Values& v, std::size_t axis) {
  for (std::size_t i = 0; i < 8; ++i)
    if (!(i & axis) && (v.hi()[i] != v.hi()[i + axis] || v.lo()[i] != v.lo()[i + axis])) return false;
  return true;
}

// Factors as small as coordinates meet a tensor of the product's own side, which is then added as one run.
constexpr std::size_t kSmallSide = 3;

IRT_WIDEST void add_products(const Tensor& a, const Tensor& b, Tensor& r) {
  const std::size_t n = r.side(), na = a.side(), nb = b.side();
  const bool whole = na <= kSmallSide;
  std::size_t run = ((nb - 1) * n + nb - 1) * n + nb, same = 0;
  Values wide = whole ? spread(b.values, nb, n) : Values(0);
  if (na == 2)
    // Along an axis that a coordinate does not depend on it is u + (1 - u) times what it is: half the products, and a sum.
    for (const auto& [step, axis] : {std::pair<std::size_t, std::size_t>{1, 1}, {n, 2}, {n * n, 4}})
      if (same_along(a.values, axis)) {
        const Values before = wide;
        add_run(wide, step, before, 0, run, {}, 0, false);
        run += step;
        same |= axis;
      }
  for (std::size_t i = 0; i < na; ++i)
    for (std::size_t j = 0; j < na; ++j)
      for (std::size_t k = 0; k < na; ++k) {
        const std::size_t at = (i * na + j) * na + k;
        const DoubleDouble v = a.values.at(at);
        const double s = a.values.size()[at];
        if (s == 0 || (at & same)) continue;
        if (whole) {
          add_run(r.values, (i * n + j) * n + k, wide, 0, run, v, s, true);
          continue;
        }
        for (std::size_t p = 0; p < nb; ++p)
          for (std::size_t q = 0; q < nb; ++q) add_run(r.values, ((i + p) * n + j + q) * n + k, b.values, (p * nb + q) * nb, nb, v, s, true);
      }
}

Tensor product(const Tensor& a, const Tensor& b) {
  if (a.side() > b.side()) return product(b, a);
  Tensor r(a.degree + b.degree);
  const double terms = static_cast<double>(a.side() * a.side() * a.side());
  r.depth = a.depth + b.depth + 1 + terms;
  add_products(a, b, r);
  return r;
}

// Of a degree that is larger by `by`: times u + (1 - u) along each axis, so many times.
IRT_WIDEST void raise(Values& v, std::size_t side, std::size_t n) {
  for (const std::size_t step : {std::size_t{1}, n, n * n})
    for (std::size_t last = side; last < n; ++last)
      for (std::size_t i = last; i > 0; --i) {
        // Lines or planes that follow one another; along the innermost axis, single values of lines.
        if (step > 1) {
          const std::size_t rows = step == n ? side : 1;
          for (std::size_t row = 0; row < rows; ++row) add_run(v, row * n * n + i * step, v, row * n * n + (i - 1) * step, step, {}, 0, false);
        } else {
          for (std::size_t row = 0; row < side; ++row)
            for (std::size_t line = 0; line < side; ++line) add_run(v, (row * n + line) * n + i, v, (row * n + line) * n + i - 1, 1, {}, 0, false);
        }
      }
}

Tensor raised(const Tensor& b, int by) {
  Tensor r(b.degree + by);
  r.depth = b.depth + 3 * by;
  r.values = spread(b.values, b.side(), r.side());
  raise(r.values, b.side(), r.side());
  return r;
}

std::vector<double> binomials(std::size_t n) {
  std::vector<double> b(n, 1);
  for (std::size_t i = 1; i < n; ++i) b[i] = std::round(b[i - 1] * static_cast<double>(n - i) / static_cast<double>(i));
  return b;
}

// A constant, which is one in every basis: in this one, the product of three binomials times it.
IRT_WIDEST void add_constant(Values& v, std::size_t n, const DoubleDouble& c, double c_size) {
  const std::vector<double> binomial = binomials(n);
  for (std::size_t line = 0; line < n * n; ++line) {
    const DoubleDouble scaled = c * (DoubleDouble(binomial[line / n]) * DoubleDouble(binomial[line % n]));
    const double line_size = c_size * binomial[line / n] * binomial[line % n];
    double *const hi = v.hi() + line * n, *const lo = v.lo() + line * n, *const size = v.size() + line * n;
#pragma GCC ivdep
    for (std::size_t k = 0; k < n; ++k) {
      const DoubleDouble term = scaled * DoubleDouble(binomial[k]), sum = DoubleDouble{hi[k], lo[k]} + term;
      hi[k] = sum.hi;
      lo[k] = sum.lo;
      size[k] += line_size * binomial[k];
    }
  }
}

Tensor sum(Tensor a, Tensor b) {
  if (a.degree < b.degree) std::swap(a, b);
  if (b.degree == 0) {
    add_constant(a.values, a.side(), b.values.at(0), b.values.size()[0]);
    a.depth = std::max(a.depth, b.depth + 3) + 1;
    return a;
  }
  if (b.degree < a.degree) b = raised(b, a.degree - b.degree);
  add_run(a.values, 0, b.values, 0, a.values.count(), {}, 0, false);
  a.depth = std::max(a.depth, b.depth) + 1;
  return a;
}

// The coordinate `axis` over the whole frustum: trilinear, so its corners say all.
Tensor coordinate(const Frustum& f, int axis) {
  Tensor r(1);
  r.depth = 8;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) {
        // In quad precision, so that nothing is lost to cancellation; compose() allows for the last of its digits.
        const Quad s = k ? f.far : f.near, spread = f.perspective ? Quad(f.distance) + s : Quad(1);
        const Quad sx = Quad(f.left) + Quad(f.tile_x0 + (i ? f.span_x() : 0)) * Quad(f.across),
                   sy = Quad(f.top) + Quad(f.tile_y0 + (j ? f.span_y() : 0)) * Quad(f.down);
        const Quad parts[] = {Quad(f.middle[axis]) + Quad(f.middle_rest[axis]), sx * spread * Quad(f.right[axis]), sy * spread * Quad(f.up[axis]), s * Quad(f.forward[axis])};
        r.values.set(static_cast<std::size_t>((i * 2 + j) * 2 + k), rounded(parts[0] + parts[1] + parts[2] + parts[3]));
      }
  return r;
}

}  // namespace

Whole compose(const PolynomialPlan& plan, const Frustum& frustum) {
  const Formula& formula = plan.formula();
  const std::size_t count = formula.f() + 1;
  // Whether a step is an argument once in all: then it makes room.
  std::vector<int> uses(count, 0);
  for (std::size_t i = 0; i < count; ++i)
    for (const std::uint32_t arg : formula.steps()[i].args) ++uses[arg];
  std::vector<Tensor> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Formula::Step& step = formula.steps()[i];
    Tensor& r = values[i];
    const auto take = [&](std::uint32_t arg) { return uses[arg] == 1 && formula.steps()[arg].axis < 0 ? std::move(values[arg]) : values[arg]; };
    if (step.constant) {
      r.values.set(0, rounded(plan.constant(i).as<Quad>()));
      r.depth = 1;
    } else if (step.axis >= 0) {
      r = coordinate(frustum, step.axis);
    } else if (step.e.op() == Op::Pow) {
      r = values[step.args[0]];
      for (long k = 1; k < step.exponent; ++k) r = product(r, values[step.args[0]]);
    } else if (step.e.op() == Op::Add) {
      r = take(step.args[0]);
      for (std::size_t k = 1; k < step.args.size(); ++k) r = sum(std::move(r), take(step.args[k]));
    } else {
      // Powers of coordinates last, one coordinate at a time: 8 terms n times instead of (n + 1)^3 once.
      const auto is_power_of_coordinate = [&](std::uint32_t arg) {
        const Formula::Step& factor = formula.steps()[arg];
        return factor.e.op() == Op::Pow && factor.exponent > 1 && formula.steps()[factor.args[0]].axis >= 0;
      };
      std::vector<std::uint32_t> args(step.args.begin(), step.args.end());
      std::stable_partition(args.begin(), args.end(), [&](std::uint32_t arg) { return !is_power_of_coordinate(arg); });
      r = values[args[0]];
      for (std::size_t k = 1; k < args.size(); ++k) {
        const Formula::Step& factor = formula.steps()[args[k]];
        const bool power = is_power_of_coordinate(args[k]);
        for (long n = power ? factor.exponent : 1; n > 0; --n) r = product(r, values[power ? factor.args[0] : args[k]]);
      }
    }
  }
  const Tensor& f = values.back();
  const std::size_t n = f.side();
  const std::vector<double> binomial = binomials(n);
  Whole whole;
  whole.hi.resize(n * n * n);
  whole.lo.resize(n * n * n);
  for (std::size_t line = 0, at = 0; line < n * n; ++line) {
    const DoubleDouble scale = DoubleDouble(binomial[line / n]) * DoubleDouble(binomial[line % n]);
    for (std::size_t k = 0; k < n; ++k, ++at) {
      // Two steps of a division: v / s to twice the digits.
      const DoubleDouble v = f.values.at(at), s = scale * DoubleDouble(binomial[k]);
      const double q = v.hi / s.hi;
      const DoubleDouble rest = v + DoubleDouble(-q) * s, quotient = quick_sum(q, rest.hi / s.hi);
      whole.hi[at] = quotient.hi;
      whole.lo[at] = quotient.lo;
      whole.error = std::max(whole.error, f.values.size()[at] / s.hi);
      whole.largest = std::max(whole.largest, std::fabs(quotient.hi));
    }
  }
  if (!std::isfinite(whole.error) || !std::isfinite(whole.largest) || !(whole.error < 1e290))
    throw MethodError("the coefficients of the polynomial over the view leave the range of doubles; scale the formula, or use method=\"contract\"");
  // The corners of the frustum may be off by 1e-30 of its size.
  whole.error = whole.error * (f.depth + 16) * kDoubleDoubleUnit * 1.001 + 1e-26 * whole.largest;
  return whole;
}

}  // namespace irt::numerics
