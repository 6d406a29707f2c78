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

// A tensor in the scaled Bernstein basis u^i (1 - u)^(n - i), of degree n along each axis, with the sum of the sizes of all that
// went into each coefficient; `depth` bounds how many roundings each of these has seen.
struct Tensor {
  int degree = 0;
  double depth = 0;
  std::vector<DoubleDouble> value{DoubleDouble(0)};
  std::vector<double> size{0.0};

  std::size_t side() const { return static_cast<std::size_t>(degree) + 1; }
};

// to += v with, out += s sizes.
IRT_WIDEST void add_scaled(DoubleDouble* to, double* out, const DoubleDouble* with, const double* sizes, DoubleDouble v, double s, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    to[m] = to[m] + v * with[m];
    out[m] += s * sizes[m];
  }
}

Tensor product(const Tensor& a, const Tensor& b) {
  if (a.side() > b.side()) return product(b, a);
  Tensor r;
  r.degree = a.degree + b.degree;
  const std::size_t n = r.side(), na = a.side(), nb = b.side();
  r.depth = a.depth + b.depth + 1 + static_cast<double>(na * na * na);
  r.value.assign(n * n * n, DoubleDouble(0));
  r.size.assign(n * n * n, 0);
  for (std::size_t i = 0; i < na; ++i)
    for (std::size_t j = 0; j < na; ++j)
      for (std::size_t k = 0; k < na; ++k) {
        const std::size_t at = (i * na + j) * na + k;
        if (a.size[at] == 0) continue;
        for (std::size_t p = 0; p < nb; ++p)
          for (std::size_t q = 0; q < nb; ++q) {
            const std::size_t from = (p * nb + q) * nb, to = ((i + p) * n + j + q) * n + k;
            add_scaled(&r.value[to], &r.size[to], &b.value[from], &b.size[from], a.value[at], a.size[at], nb);
          }
      }
  return r;
}

// 1, of degree n: the binomials along each axis.
Tensor one(int degree) {
  Tensor r;
  r.degree = degree;
  r.depth = 3;
  const std::size_t n = r.side();
  std::vector<double> binomial(n, 1);
  for (std::size_t i = 1; i < n; ++i) binomial[i] = std::round(binomial[i - 1] * static_cast<double>(n - i) / static_cast<double>(i));
  r.value.resize(n * n * n);
  r.size.resize(n * n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t at = (i * n + j) * n + k;
        r.value[at] = DoubleDouble(binomial[i]) * DoubleDouble(binomial[j]) * DoubleDouble(binomial[k]);
        r.size[at] = r.value[at].hi;
      }
  return r;
}

Tensor sum(Tensor a, Tensor b) {
  if (a.degree < b.degree) std::swap(a, b);
  if (b.degree < a.degree) b = product(b, one(a.degree - b.degree));
  for (std::size_t i = 0; i < a.value.size(); ++i) {
    a.value[i] = a.value[i] + b.value[i];
    a.size[i] += b.size[i];
  }
  a.depth = std::max(a.depth, b.depth) + 1;
  return a;
}

// The coordinate `axis` over the whole frustum: trilinear, so its corners say all.
Tensor coordinate(const Frustum& f, int axis) {
  Tensor r;
  r.degree = 1;
  r.depth = 8;
  r.value.resize(8);
  r.size.resize(8);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) {
        // In quad precision, so that nothing is lost to cancellation; compose() allows for the last of its digits.
        const Quad s = k ? f.far : f.near, spread = f.perspective ? Quad(f.distance) + s : Quad(1);
        const Quad sx = Quad(f.left) + Quad(f.tile_x0 + (i ? f.span_x() : 0)) * Quad(f.across),
                   sy = Quad(f.top) + Quad(f.tile_y0 + (j ? f.span_y() : 0)) * Quad(f.down);
        const Quad parts[] = {Quad(f.middle[axis]), sx * spread * Quad(f.right[axis]), sy * spread * Quad(f.up[axis]), s * Quad(f.forward[axis])};
        const std::size_t at = (i * 2 + j) * 2 + k;
        r.value[at] = rounded(parts[0] + parts[1] + parts[2] + parts[3]);
        r.size[at] = std::fabs(r.value[at].hi);
      }
  return r;
}

}  // namespace

Whole compose(const PolynomialPlan& plan, const Frustum& frustum) {
  const Formula& formula = plan.formula();
  const std::size_t count = formula.f() + 1;
  std::vector<Tensor> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Formula::Step& step = formula.steps()[i];
    Tensor& r = values[i];
    if (step.constant) {
      r.value[0] = rounded(plan.constant(i).as<Quad>());
      r.size[0] = std::fabs(r.value[0].hi);
      r.depth = 1;
    } else if (step.axis >= 0) {
      r = coordinate(frustum, step.axis);
    } else if (step.e.op() == Op::Pow) {
      r = values[step.args[0]];
      for (long k = 1; k < step.exponent; ++k) r = product(r, values[step.args[0]]);
    } else {
      r = values[step.args[0]];
      for (std::size_t k = 1; k < step.args.size(); ++k)
        r = step.e.op() == Op::Mul ? product(r, values[step.args[k]]) : sum(std::move(r), values[step.args[k]]);
    }
  }
  const Tensor& f = values.back();
  const Tensor scale = one(f.degree);
  Whole whole;
  whole.hi.resize(f.value.size());
  whole.lo.resize(f.value.size());
  for (std::size_t at = 0; at < f.value.size(); ++at) {
    // Two steps of a division: v / s to twice the digits.
    const DoubleDouble &v = f.value[at], &s = scale.value[at];
    const double q = v.hi / s.hi;
    const DoubleDouble rest = v + DoubleDouble(-q) * s, quotient = quick_sum(q, rest.hi / s.hi);
    whole.hi[at] = quotient.hi;
    whole.lo[at] = quotient.lo;
    whole.error = std::max(whole.error, f.size[at] / s.hi);
    whole.largest = std::max(whole.largest, std::fabs(quotient.hi));
  }
  if (!std::isfinite(whole.error) || !std::isfinite(whole.largest) || !(whole.error < 1e290))
    throw MethodError("the coefficients of the polynomial over the view leave the range of doubles; scale the formula, or use method=\"contract\"");
  // The corners of the frustum may be off by 1e-30 of its size.
  whole.error = whole.error * (f.depth + 16) * kDoubleDoubleUnit * 1.001 + 1e-26 * whole.largest;
  return whole;
}

}  // namespace irt::numerics
