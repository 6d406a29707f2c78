// The frustum form and its cells; see frustum_form.h.
#include "numerics/frustum_form.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>
#include <type_traits>

#include "error.h"

namespace irt::numerics {
namespace {

__extension__ typedef __float128 Quad;

// Half an ulp, in parts of a value (twice that for Quad, whose operations are emulated).
template <class T>
constexpr double kUnit = std::is_same_v<T, double> ? 0x1p-53 : std::is_same_v<T, long double> ? 0x1p-64 : 0x1p-112;

// Cuts that are made in more digits before fewer take over.
constexpr int kPreciseCuts = 6;
// Cells that may be less exact than what the kernel's rounding does to them.
constexpr double kInexactCells = 0.02, kExactEnough = 1e-7;

// Least slope of a steady cell, in parts of its largest value.
constexpr double kSteady = 0.1;
// Halvings of the depth after which slabs are short enough, but for accuracy.
constexpr int kUsualDepthCuts = 3;

// A tensor in the scaled Bernstein basis u^i (1 - u)^(n - i), of degree n along each axis, with the sum of the sizes of all that
// went into each coefficient; `depth` bounds how many roundings each of these has seen.
template <class T>
struct Tensor {
  int degree = 0, depth = 0;
  std::vector<T> value{T(0)};
  std::vector<double> size{0.0};

  std::size_t side() const { return static_cast<std::size_t>(degree) + 1; }
};

template <class T>
double magnitude(T v) {
  return std::fabs(static_cast<double>(v));
}

// Sums run along one axis after the other, so that no term sees more than three sides of additions.
template <class T>
Tensor<T> product(const Tensor<T>& a, const Tensor<T>& b) {
  if (a.side() > b.side()) return product(b, a);
  Tensor<T> r;
  r.degree = a.degree + b.degree;
  r.depth = a.depth + b.depth + 1 + 3 * static_cast<int>(a.side());
  const std::size_t n = r.side(), na = a.side(), nb = b.side();
  r.value.assign(n * n * n, T(0));
  r.size.assign(n * n * n, 0);
  std::vector<T> line(nb * nb * n), plane(nb * n * n);
  for (std::size_t i = 0; i < na; ++i) {
    std::fill(plane.begin(), plane.end(), T(0));
    for (std::size_t j = 0; j < na; ++j) {
      std::fill(line.begin(), line.end(), T(0));
      for (std::size_t k = 0; k < na; ++k) {
        const T v = a.value[(i * na + j) * na + k];
        const double s = a.size[(i * na + j) * na + k];
        if (s == 0) continue;
        for (std::size_t p = 0; p < nb; ++p)
          for (std::size_t q = 0; q < nb; ++q) {
            const T* with = &b.value[(p * nb + q) * nb];
            const double* sizes = &b.size[(p * nb + q) * nb];
            T* to = &line[(p * nb + q) * n + k];
            double* out = &r.size[((i + p) * n + j + q) * n + k];
            for (std::size_t m = 0; m < nb; ++m) {
              to[m] += v * with[m];
              out[m] += s * sizes[m];
            }
          }
      }
      for (std::size_t p = 0; p < nb; ++p)
        for (std::size_t q = 0; q < nb; ++q)
          for (std::size_t m = 0; m < n; ++m) plane[(p * n + j + q) * n + m] += line[(p * nb + q) * n + m];
    }
    for (std::size_t m = 0; m < nb * n * n; ++m) r.value[i * n * n + m] += plane[m];
  }
  return r;
}

// Times (u + (1 - u)) (v + (1 - v)) (w + (1 - w)), until the degree is n.
template <class T>
void raise(Tensor<T>& a, int degree) {
  while (a.degree < degree) {
    Tensor<T> r;
    r.degree = a.degree + 1;
    r.depth = a.depth + 7;
    const std::size_t n = r.side(), m = a.side();
    r.value.assign(n * n * n, T(0));
    r.size.assign(n * n * n, 0);
    for (std::size_t i = 0; i < m; ++i)
      for (std::size_t j = 0; j < m; ++j)
        for (std::size_t k = 0; k < m; ++k)
          for (std::size_t corner = 0; corner < 8; ++corner) {
            const std::size_t at = ((i + (corner & 1)) * n + j + ((corner >> 1) & 1)) * n + k + (corner >> 2);
            r.value[at] += a.value[(i * m + j) * m + k];
            r.size[at] += a.size[(i * m + j) * m + k];
          }
    a = std::move(r);
  }
}

template <class T>
Tensor<T> sum(Tensor<T> a, Tensor<T> b) {
  raise(a, b.degree);
  raise(b, a.degree);
  for (std::size_t i = 0; i < a.value.size(); ++i) {
    a.value[i] += b.value[i];
    a.size[i] += b.size[i];
  }
  a.depth = std::max(a.depth, b.depth) + 1;
  return a;
}

// The coordinate `axis` over the whole frustum: trilinear, so its corners say all.
template <class T>
Tensor<T> coordinate(const Frustum& f, int axis) {
  Tensor<T> r;
  r.degree = 1;
  r.depth = 8;
  r.value.resize(8);
  r.size.resize(8);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) {
        // In quad precision, so that nothing is lost to cancellation; compose() allows for the last of its digits.
        const Quad s = k ? f.far : f.near, spread = f.perspective ? Quad(f.distance) + s : Quad(1);
        const Quad sx = Quad(f.left) + Quad(i ? f.tile_x1 : f.tile_x0) * Quad(f.across), sy = Quad(f.top) + Quad(j ? f.tile_y1 : f.tile_y0) * Quad(f.down);
        const Quad parts[] = {Quad(f.middle[axis]), sx * spread * Quad(f.right[axis]), sy * spread * Quad(f.up[axis]), s * Quad(f.forward[axis])};
        const std::size_t at = (i * 2 + j) * 2 + k;
        r.value[at] = static_cast<T>(parts[0] + parts[1] + parts[2] + parts[3]);
        r.size[at] = magnitude(r.value[at]);
      }
  return r;
}

// f over the whole frustum: Bernstein coefficients [i][j][k], and a bound of their error.
template <class T>
struct Whole {
  std::vector<T> value;
  double error, largest;
};

template <class T>
Whole<T> compose(const PolynomialPlan& plan, const Frustum& frustum) {
  const Formula& formula = plan.formula();
  const std::size_t count = formula.f() + 1;
  std::vector<Tensor<T>> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Formula::Step& step = formula.steps()[i];
    Tensor<T>& r = values[i];
    if (step.constant) {
      r.value[0] = plan.constant(i).template as<T>();
      r.size[0] = magnitude(r.value[0]);
      r.depth = 1;
    } else if (step.axis >= 0) {
      r = coordinate<T>(frustum, step.axis);
    } else if (step.e.op() == Op::Pow) {
      r = values[step.args[0]];
      for (long k = 1; k < step.exponent; ++k) r = product(r, values[step.args[0]]);
    } else {
      r = values[step.args[0]];
      for (std::size_t k = 1; k < step.args.size(); ++k)
        r = step.e.op() == Op::Mul ? product(r, values[step.args[k]]) : sum(std::move(r), values[step.args[k]]);
    }
  }
  Tensor<T>& f = values.back();
  const std::size_t n = f.side();
  std::vector<double> binomial(n, 1);
  for (std::size_t i = 1; i < n; ++i) binomial[i] = binomial[i - 1] * static_cast<double>(n - i) / static_cast<double>(i);
  Whole<T> whole{std::move(f.value), 0, 0};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t at = (i * n + j) * n + k;
        const double all = binomial[i] * binomial[j] * binomial[k];
        whole.value[at] = whole.value[at] / T(binomial[i]) / T(binomial[j]) / T(binomial[k]);
        whole.error = std::max(whole.error, f.size[at] / all);
      }
  if (!std::isfinite(whole.error))
    throw MethodError("the coefficients of the polynomial over the view leave the range of doubles; scale the formula, or use method=\"contract\"");
  whole.error *= (f.depth + 8) * kUnit<T> * 1.001;
  for (const T& v : whole.value) whole.largest = std::max(whole.largest, magnitude(v));
  // The corners of the frustum may be off by 1e-30 of its size.
  whole.error += 1e-25 * whole.largest;
  return whole;
}

// One round after another of de Casteljau's algorithm on n runs of `width` values: `lines` become the coefficients of the first part,
// `ends` those of the second.
template <class T>
inline void cut_runs(T* __restrict lines, T* __restrict ends, std::size_t n, std::size_t width, T share) {
  const T rest = T(1) - share;
  for (std::size_t round = 1; round < n; ++round) {
    std::copy_n(lines + (n - 1) * width, width, ends + (n - round) * width);
    for (std::size_t i = n - 1; i >= round; --i) {
      T* __restrict to = lines + i * width;
      const T* __restrict from = lines + (i - 1) * width;
      for (std::size_t m = 0; m < width; ++m) to[m] = rest * from[m] + share * to[m];
    }
  }
  std::copy_n(lines + (n - 1) * width, width, ends);
}

// The same for doubles, in the widest vectors that the processor has: results do not depend on them.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif
void cut_doubles(double* lines, double* ends, std::size_t n, std::size_t width, double share) {
  cut_runs(lines, ends, n, width, share);
}

template <class T>
void transpose(const T* from, T* to, std::size_t rows, std::size_t columns) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) to[j * rows + i] = from[i * columns + j];
}

// Cuts [i][j][k] at `share` along an axis: `a` becomes the first part, `b` the second.
template <class T>
void cut(std::vector<T>& a, std::vector<T>& b, std::size_t n, int axis, T share) {
  b.resize(a.size());
  const auto runs = [&](T* lines, T* ends, std::size_t width) {
    if constexpr (std::is_same_v<T, double>) {
      cut_doubles(lines, ends, n, width, share);
    } else {
      cut_runs(lines, ends, n, width, share);
    }
  };
  if (axis == 0) {
    runs(a.data(), b.data(), n * n);
  } else if (axis == 1) {
    for (std::size_t i = 0; i < n; ++i) runs(&a[i * n * n], &b[i * n * n], n);
  } else {
    thread_local std::vector<T> deep, second;
    deep.resize(a.size());
    second.resize(a.size());
    transpose(a.data(), deep.data(), n * n, n);
    runs(deep.data(), second.data(), n * n);
    transpose(deep.data(), a.data(), n, n * n);
    transpose(second.data(), b.data(), n, n * n);
  }
}

struct Block {
  int x0, x1, y0, y1;     // tiles
  int first, last;        // depth, in parts of 2^-kMostDepthCuts
};

struct Leaf {
  int tile;
  Cells::Cell cell;
};

// What one thread has found.
struct Found {
  std::vector<Leaf> leaves;
  std::vector<double> coefficients;
  std::vector<bool> full;  // tiles all of whose rays have a root in a cell that stands already: nothing behind it is seen
};

template <class T>
class Cutter {
 public:
  using Next = std::function<void(const Block&, const std::vector<T>&, double)>;

  // Hands over to `next`, where there is one, after kPreciseCuts cuts; `unit` is the rounding of T.
  Cutter(const Frustum& frustum, const Demand& demand, int degree, double unit, Found& found, Next next = {})
      : frustum_(frustum), demand_(demand), found_(found), next_(std::move(next)), n_(static_cast<std::size_t>(degree) + 1), unit_(unit),
        grow_((4 * degree + 8) * unit), pool_(64),
        slack_(1e-12 * (glm::length(frustum.upper - frustum.lower) + glm::length(frustum.middle) + std::fabs(frustum.distance))) {}

  // Whether nothing in the block can be seen.
  bool hidden(const Block& b) const {
    for (int y = b.y0; y < b.y1; ++y)
      for (int x = b.x0; x < b.x1; ++x)
        if (!found_.full[index(x, y)]) return false;
    return true;
  }

  // `form` over `block`; front to back within each tile.
  void run(const Block& block, std::vector<T>& form, double error, int level) {
    T lowest = form[0], highest = form[0];
    for (const T& v : form) {
      lowest = std::min(lowest, v);
      highest = std::max(highest, v);
    }
    if (static_cast<double>(lowest) > error || static_cast<double>(highest) < -error || hidden(block) || place(block) > 0) return;
    const double largest = std::max(magnitude(lowest), magnitude(highest));
    const int axis = longest(block, form, error, largest);
    if (next_ && (axis < 0 || level == kPreciseCuts)) return next_(block, form, error);
    if (axis < 0) return emit(block, form, error, largest);
    std::vector<T>& second = pool_[level];
    Block a = block, b = block;
    T share = T(0.5);
    if (axis == 2) {
      a.last = b.first = (block.first + block.last) / 2;
    } else {
      int& middle = axis == 0 ? a.x1 : a.y1;
      const int from = axis == 0 ? block.x0 : block.y0, to = axis == 0 ? block.x1 : block.y1;
      middle = (from + to) / 2;
      (axis == 0 ? b.x0 : b.y0) = middle;
      share = T(middle - from) / T(to - from);
    }
    cut(form, second, n_, axis, share);
    const double child = error + grow_ * largest;
    // `form` serves the first part's own cuts; the second waits in the pool, where deeper levels do not reach.
    run(a, form, child, level + 1);
    run(b, second, child, level + 1);
  }

 private:
  double at(int part) const {
    const double share = part * std::ldexp(1.0, -kMostDepthCuts);
    return frustum_.near + share * (frustum_.far - frustum_.near);
  }

  glm::dvec3 corner(int tile_x, int tile_y, double s) const {
    const double spread = frustum_.perspective ? frustum_.distance + s : 1;
    const double sx = static_cast<double>(frustum_.left + tile_x * frustum_.across), sy = static_cast<double>(frustum_.top + tile_y * frustum_.down);
    return frustum_.middle + sx * spread * frustum_.right + sy * spread * frustum_.up + s * frustum_.forward;
  }

  // 1 outside the bounds, -1 inside, 0 where that depends.
  int place(const Block& b) const {
    glm::dvec3 low(HUGE_VAL), high(-HUGE_VAL);
    bool in_balls = true;
    for (int k = 0; k < 8; ++k) {
      const glm::dvec3 c = corner(k & 1 ? b.x1 : b.x0, k & 2 ? b.y1 : b.y0, at(k & 4 ? b.last : b.first));
      low = glm::min(low, c);
      high = glm::max(high, c);
      for (const auto& ball : frustum_.balls) in_balls = in_balls && glm::length(c - glm::dvec3(ball)) < ball.w - slack_;
    }
    if (glm::any(glm::greaterThan(low, frustum_.upper + slack_)) || glm::any(glm::lessThan(high, frustum_.lower - slack_))) return 1;
    return in_balls && at(b.first) > -frustum_.distance && glm::all(glm::lessThan(high, frustum_.upper - slack_)) &&
                   glm::all(glm::greaterThan(low, frustum_.lower + slack_))
               ? -1 : 0;
  }

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y - frustum_.tile_y0) * (frustum_.tile_x1 - frustum_.tile_x0) + (x - frustum_.tile_x0); }

  // Where to cut: across what is longest. Within a tile slabs stay long where f rises or falls steadily along its rays, and become
  // short where rounding would blur a root by more than is asked for.
  int longest(const Block& b, const std::vector<T>& form, double error, double largest) const {
    const double middle = at((b.first + b.last) / 2), spread = frustum_.perspective ? std::fabs(frustum_.distance + middle) : 1;
    const double wide = b.x1 - b.x0 > 1 ? (b.x1 - b.x0) * std::fabs(static_cast<double>(frustum_.across)) * spread : 0,
                 high = b.y1 - b.y0 > 1 ? (b.y1 - b.y0) * std::fabs(static_cast<double>(frustum_.down)) * spread : 0;
    const int parts = b.last - b.first;
    const double length = at(b.last) - at(b.first);
    if (wide == 0 && high == 0) {
      if (parts == 1) return -1;
      const bool long_slab = parts > 1 << (kMostDepthCuts - kUsualDepthCuts);
      const bool apart = long_slab && !steady(form, error, largest);
      return apart || blur(form, error, largest) * length > 0.25 * demand_.eps ? 2 : -1;
    }
    const double deep = parts > 1 << (kMostDepthCuts - kUsualDepthCuts) ? length : 0;
    return deep >= wide && deep >= high ? 2 : wide >= high ? 0 : 1;
  }

  // How far off rounding may put a root, in parts of the slab: on the line of coefficients that changes its sign most slowly.
  double blur(const std::vector<T>& form, double error, double largest) const {
    double slowest = HUGE_VAL;
    for (std::size_t i = 0; i < form.size(); i += n_)
      for (std::size_t k = i + 1; k < i + n_; ++k)
        if ((form[k] < T(0)) != (form[k - 1] < T(0))) {
          slowest = std::min(slowest, std::fabs(static_cast<double>(form[k] - form[k - 1])));
          break;
        }
    return (largest * demand_.rounding + error) / std::max(slowest * static_cast<double>(n_ - 1), 1e-300);
  }

  // Whether the least slope along any ray is a fair share of the largest value: then roots are as exact as coefficients are.
  bool steady(const std::vector<T>& form, double error, double largest) const {
    const double least = kSteady * largest / static_cast<double>(n_ - 1) + 2 * error;
    bool rises = true, falls = true;
    for (std::size_t i = 0; i < form.size(); i += n_)
      for (std::size_t k = i + 1; k < i + n_; ++k) {
        const double step = static_cast<double>(form[k] - form[k - 1]);
        rises = rises && step > least;
        falls = falls && step < -least;
      }
    return rises || falls;
  }

  void emit(const Block& b, const std::vector<T>& form, double error, double largest) {
    int exponent;
    std::frexp(largest, &exponent);
    const double scale = std::ldexp(1.0, 1 - exponent);
    const double kept = (error + largest * 0x1p-53) * scale;
    bool above = true, below = true;  // at the near end, and the opposite at the far one, on every ray
    for (std::size_t i = 0; i < form.size(); i += n_) {
      const double first = static_cast<double>(form[i]), last = static_cast<double>(form[i + n_ - 1]);
      above = above && first > error && last < -error;
      below = below && first < -error && last > error;
    }
    if ((above || below) && place(b) < 0) found_.full[index(b.x0, b.y0)] = true;
    found_.leaves.push_back({b.y0 * 65536 + b.x0, {at(b.first), at(b.last), kept, found_.coefficients.size()}});
    for (const T& v : form) found_.coefficients.push_back(static_cast<double>(v * T(scale)));
  }

  const Frustum& frustum_;
  Demand demand_;
  Found& found_;
  Next next_;
  std::size_t n_;
  double unit_, grow_;
  std::vector<std::vector<T>> pool_;
  double slack_;
};

// Which arithmetics cut: First for the first cuts, Then for the rest; the same: one of them for all.
template <class First, class Then>
Cells cut_up(const Frustum& f, const Demand& demand, int degree, const Whole<First>& whole) {
  // Bands of tile rows, one thread each.
  const int rows = f.tile_y1 - f.tile_y0, columns = f.tile_x1 - f.tile_x0;
  const int bands = std::max(1, std::min(rows, static_cast<int>(std::thread::hardware_concurrency())));
  std::vector<Found> found(static_cast<std::size_t>(bands));
  const auto band = [&](int k) {
    found[k].full.assign(static_cast<std::size_t>(rows) * columns, false);
    Cutter<Then> then(f, demand, degree, kUnit<Then>, found[k]);
    typename Cutter<First>::Next next;
    if (!std::is_same_v<First, Then>)
      next = [&](const Block& block, const std::vector<First>& form, double error) {
        std::vector<Then> rounded(form.begin(), form.end());
        double largest = 0;
        for (const Then& v : rounded) largest = std::max(largest, magnitude(v));
        then.run(block, rounded, error + largest * kUnit<Then>, 0);
      };
    Cutter<First> first(f, demand, degree, kUnit<First>, found[k], std::move(next));
    std::vector<First> mine = whole.value, other;
    const std::size_t n = static_cast<std::size_t>(degree) + 1;
    const int from = k * rows / bands, to = (k + 1) * rows / bands;
    if (to < rows) cut(mine, other, n, 1, First(to) / First(rows));
    if (from > 0) {
      cut(mine, other, n, 1, First(from) / First(to));
      std::swap(mine, other);
    }
    first.run({f.tile_x0, f.tile_x1, f.tile_y0 + from, f.tile_y0 + to, 0, 1 << kMostDepthCuts}, mine,
              whole.error + (2 * (4 * degree + 8) + 1) * kUnit<First> * whole.largest, 0);
  };
  std::vector<std::thread> threads;
  for (int k = 1; k < bands; ++k) threads.emplace_back(band, k);
  band(0);
  for (std::thread& t : threads) t.join();

  Cells out;
  out.degree = degree;
  out.begins.assign(static_cast<std::size_t>(rows) * columns + 1, 0);
  const auto index = [&](int tile) { return static_cast<std::size_t>(tile / 65536 - f.tile_y0) * columns + (tile % 65536 - f.tile_x0); };
  std::size_t total = 0;
  for (const auto& c : found) {
    for (const auto& leaf : c.leaves) ++out.begins[index(leaf.tile) + 1];
    total += c.leaves.size();
  }
  for (std::size_t i = 1; i < out.begins.size(); ++i) out.begins[i] += out.begins[i - 1];
  std::vector<std::int32_t> next = out.begins;
  out.cells.resize(total);
  for (const auto& c : found) {
    const std::size_t base = out.coefficients.size();
    for (const auto& leaf : c.leaves) {
      Cells::Cell cell = leaf.cell;
      cell.first += base;
      out.cells[next[index(leaf.tile)]++] = cell;
    }
    out.coefficients.insert(out.coefficients.end(), c.coefficients.begin(), c.coefficients.end());
  }
  return out;
}

}  // namespace

Cells cells_of(const PolynomialPlan& plan, const Frustum& frustum, const Demand& demand) {
  const int degree = plan.degree();
  const auto exact_enough = [&](const Cells& cells) {
    std::size_t inexact = 0;
    for (const auto& cell : cells.cells) inexact += cell.error > std::max(demand.rounding, kExactEnough);
    return static_cast<double>(inexact) <= kInexactCells * static_cast<double>(cells.cells.size());
  };
  const Whole<long double> whole = compose<long double>(plan, frustum);
  const Whole<double> rounded{{whole.value.begin(), whole.value.end()}, whole.error + whole.largest * kUnit<double>, whole.largest};
  if (Cells cells = cut_up<double, double>(frustum, demand, degree, rounded); exact_enough(cells)) return cells;
  if (Cells cells = cut_up<long double, double>(frustum, demand, degree, whole); exact_enough(cells)) return cells;
  return cut_up<Quad, long double>(frustum, demand, degree, compose<Quad>(plan, frustum));
}

}  // namespace irt::numerics
