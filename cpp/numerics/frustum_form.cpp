// Cutting the frustum form into cells; see frustum_form.h.
//
// Columns of tiles come first, in sums of two doubles; each is then cut down and along its depth by one thread. There double
// takes over as soon as it leaves the cells exact enough: where it does not, the same block is cut further in sums of two.
#include "numerics/frustum_form.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "caps.h"
#include "numerics/crew.h"
#include "numerics/double_double.h"
#include "numerics/frustum_cuts.h"
#include "numerics/frustum_reduce.h"

namespace irt::numerics {
namespace {

// Cells may always be as inexact as this, in parts of their largest coefficient: those of floats, those by which roots are refined as well, those of doubles. What
// is less exact leaves pixels beside nodes wide.
constexpr double kExactEnough = 1e-7, kExactToRefine = 1e-8, kExactInDoubles = 1e-11;
// Cuts of a column of tiles after which double takes over at the latest.
constexpr int kPreciseCuts = 6;
// What reduction may lose in each direction, in halves of an ulp of the largest coefficient.
constexpr double kLost = 4;
// Least slope of a steady cell, in parts of its largest value.
constexpr double kSteady = 0.1;
// Halvings of the depth after which slabs are short enough, but for accuracy. For few pixels cells cost more than
// roots do, up to a degree above which long slabs leave pixels to the reference.
constexpr int kUsualDepthCuts = 3, kUsualDepthCutsOfFew = 0, kMostDegreeOfFew = 12;

struct Block {
  int y0, y1;       // tiles of a column
  int first, last;  // depth, in parts of 2^-kMostDepthCuts
};

// Coefficients one behind the other: in a part of the block that they are meant for, or, where that turns out too small, in memory of their own.
class Row {
 public:
  Row() = default;
  Row(std::byte* part, std::size_t size) : at_(part), size_(size) {}

  // Room for so many bytes, and some more that whole vectors may be written to; what follows overwrites them.
  std::byte* add(std::size_t bytes) {
    const std::size_t wanted = used + bytes + kBehind;
    if (wanted > size_) {
      const std::size_t larger = std::max(wanted, size_ + size_ / 2);
      auto moved = std::make_unique_for_overwrite<std::byte[]>(larger);
      std::copy_n(at_, used, moved.get());
      own_ = std::move(moved);
      at_ = own_.get();
      size_ = larger;
    }
    return at_ + std::exchange(used, used + bytes);
  }
  const std::byte* data() const { return at_; }
  bool moved() const { return own_ != nullptr; }

  std::size_t used = 0;  // bytes

 private:
  std::byte* at_ = nullptr;
  std::size_t size_ = 0;
  std::unique_ptr<std::byte[]> own_;
};

// What one thread has found: leaves, whose coefficients begin where they do in its own rows.
struct Found {
  struct Leaf {
    int x, y;
    Cells::Cell cell;
  };
  std::vector<Leaf> leaves;
  Row coefficients, exact;
};

// How much of one kind of coefficients a thread has made of late, and some more.
class Expected {
 public:
  std::size_t bytes() const { return bytes_; }
  void learn(std::size_t used) {
    const std::size_t now = bytes_;
    if (used > now || used < now / 4) bytes_ = (used + used / 4 + kPage - 1) / kPage * kPage;
  }

 private:
  static constexpr std::size_t kPage = 4096;
  std::atomic<std::size_t> bytes_{0};
};

// Coefficients of a kind, of all threads: each has a part of one block. Where a part was too small all of them move to another.
class Rows {
 public:
  Rows(std::vector<Found>& found, Row Found::*row, std::size_t real, const Space& space, Expected& expected)
      : found_(found), row_(row), step_(kCellStep * real), space_(space), expected_(expected), part_(expected.bytes()) {
    auto* const block = static_cast<std::byte*>(space_(part_ * found_.size()));
    for (std::size_t k = 0; k < found_.size(); ++k) found_[k].*row_ = Row(block + k * part_, part_);
  }

  // Where each thread's row begins in the block, in steps.
  std::vector<std::int32_t> settle() {
    std::vector<std::int32_t> begins;
    std::size_t most = 0, all = 0;
    bool moved = false;
    for (const Found& part : found_) {
      const Row& row = part.*row_;
      most = std::max(most, row.used + kBehind);
      moved = moved || row.moved();
    }
    for (const Found& part : found_) {
      begins.push_back(static_cast<std::int32_t>(all / step_));
      all += moved ? (part.*row_).used : part_;
    }
    if (moved) {
      auto* const block = static_cast<std::byte*>(space_(all + kBehind));
      for (std::size_t k = 0; k < found_.size(); ++k) std::copy_n((found_[k].*row_).data(), (found_[k].*row_).used, block + begins[k] * step_);
    }
    expected_.learn(most);
    return begins;
  }

 private:
  std::vector<Found>& found_;
  Row Found::*row_;
  std::size_t step_;
  const Space& space_;
  Expected& expected_;
  std::size_t part_;
};

std::size_t whole_steps(std::size_t count) { return (count + kCellStep - 1) / kCellStep; }

// Coefficients as hi + lo; lo is absent where double is enough.
struct Form {
  double *hi, *lo;
};

// One column of tiles after another.
class Cutter {
 public:
  Cutter(const Frustum& frustum, const Demand& demand, int degree, const Reduction& reduction, Found& found)
      : frustum_(frustum), demand_(demand), reduction_(reduction), found_(found), n_(static_cast<std::size_t>(degree) + 1), m_((n_ + kLanes - 1) / kLanes * kLanes),
        size_(n_ * n_ * m_), grow_(degree + 2),
        slack_(1e-12 * (glm::length(frustum.upper - frustum.lower) + glm::length(frustum.middle) + std::fabs(frustum.distance))) {}

  // hi + lo is the form over column x: [across][down][depth].
  void run(int x, const double* hi, const double* lo, double error) {
    x_ = x;
    for (int k = 0; k < 2; ++k) sx_[k] = static_cast<double>(frustum_.left + (x + k) * frustum_.across);
    full_.assign(static_cast<std::size_t>(frustum_.span_y()), false);
    if (demand_.tiles)
      for (int y = frustum_.tile_y0; y < frustum_.tile_y1; ++y) full_[y - frustum_.tile_y0] = !(*demand_.tiles)[frustum_.tile_index(x, y)];
    if (hidden({frustum_.tile_y0, frustum_.tile_y1, 0, 1})) return;
    precise_ = 0;
    const Form form = at_level(0);
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t k = 0; k < n_; ++k)
        for (std::size_t i = 0; i < m_; ++i) {
          const std::size_t from = (std::min(i, n_ - 1) * n_ + j) * n_ + k, to = (j * n_ + k) * m_ + i;
          form.hi[to] = hi[from];
          form.lo[to] = lo[from];
        }
    cut({frustum_.tile_y0, frustum_.tile_y0 + frustum_.span_y(), 0, 1 << kMostDepthCuts}, form, extent_of(form.hi, size_), error, 0);
  }

 private:
  // A buffer for each level of the recursion: [down][depth][across], lines across padded by repetition.
  Form at_level(int level) {
    while (static_cast<int>(pool_.size()) <= level) pool_.emplace_back();
    double* const hi = pool_[level].of(2 * size_);
    return {hi, hi + size_};
  }

  Runs along_depth() const { return {n_, m_, m_, n_, n_ * m_}; }

  // `form` over `block`; front to back within each tile. False where double leaves a cell less exact than it may be.
  bool cut(const Block& block, Form form, const Extent& extent, double error, int level) {
    if (block.y0 >= frustum_.tile_y1) return true;
    const double largest = std::max(std::fabs(extent.lowest), std::fabs(extent.highest)), known = error + (form.lo ? 0x1p-53 * largest : 0);
    if (extent.lowest > known || extent.highest < -known || hidden(block) || place(block) > 0) return true;
    if (form.lo && level >= precise_) {
      // In double; and where that fails, once more a cut further on.
      const std::size_t leaves = found_.leaves.size(), used = found_.coefficients.used, exact = found_.exact.used;
      const std::vector<bool> full = full_;
      const Form copy{at_level(level + 1).hi, nullptr};
      std::copy_n(form.hi, size_, copy.hi);
      strict_ = level < kPreciseCuts;
      if (cut(block, copy, extent, known, level + 1)) return true;
      found_.leaves.resize(leaves);
      found_.coefficients.used = used;
      found_.exact.used = exact;
      full_ = full;
      precise_ = level + 1;
    }
    Axis axis = longest(block, form, known, largest);
    if (axis == Axis::none && demand_.reduced && !reduction_.run(form.hi, m_, largest, kLost * demand_.unit * largest, block.last - block.first == 1, reduced_))
      axis = Axis::depth;
    if (axis == Axis::none) return emit(block, form, known, largest);
    const Form buffer = at_level(level + 1), second{buffer.hi, form.lo ? buffer.lo : nullptr};
    Block a = block, b = block;
    Runs runs{n_, n_ * m_, n_ * m_, 1, 0};
    if (axis == Axis::depth) {
      a.last = b.first = (block.first + block.last) / 2;
      runs = along_depth();
    } else {
      a.y1 = b.y0 = (block.y0 + block.y1) / 2;
    }
    Halves halves;
    if (form.lo) {
      halve(form.hi, form.lo, second.hi, second.lo, runs);
      halves = {extent_of(form.hi, size_), extent_of(second.hi, size_)};
    } else {
      halves = halve(form.hi, second.hi, runs);
    }
    const double child = error + grow_ * (form.lo ? kDoubleDoubleUnit : 0x1p-53) * largest;
    // `form` serves the first part's own cuts; the second waits in its buffer, where deeper levels do not reach.
    return cut(a, form, halves.first, child, level + 1) && cut(b, second, halves.second, child, level + 1);
  }

  double at(int part) const {
    const double share = part * std::ldexp(1.0, -kMostDepthCuts);
    return frustum_.near + share * (frustum_.far - frustum_.near);
  }

  // 1 outside the bounds, -1 inside, 0 where that depends.
  int place(const Block& b) const {
    glm::dvec3 corners[8], low(HUGE_VAL), high(-HUGE_VAL);
    const double sy[] = {static_cast<double>(frustum_.top + b.y0 * frustum_.down), static_cast<double>(frustum_.top + b.y1 * frustum_.down)};
    for (int k = 0; k < 8; ++k) {
      corners[k] = frustum_.point(sx_[k & 1], sy[k >> 1 & 1], at(k & 4 ? b.last : b.first));
      low = glm::min(low, corners[k]);
      high = glm::max(high, corners[k]);
    }
    if (glm::any(glm::greaterThan(low, frustum_.upper + slack_)) || glm::any(glm::lessThan(high, frustum_.lower - slack_))) return 1;
    bool inside = at(b.first) > -frustum_.distance && glm::all(glm::lessThan(high, frustum_.upper - slack_)) &&
                  glm::all(glm::greaterThan(low, frustum_.lower + slack_));
    for (const auto& ball : frustum_.balls)
      for (const auto& c : corners) inside = inside && glm::length(c - glm::dvec3(ball)) < ball.w - slack_;
    for (const auto& h : frustum_.half_spaces) {
      bool beyond = true;
      for (const auto& c : corners) {
        const double by = glm::dot(glm::dvec3(h), c) - h.w;
        beyond = beyond && by > 4 * slack_;
        inside = inside && by < -4 * slack_;
      }
      if (beyond) return 1;
    }
    return inside ? -1 : 0;
  }

  // Whether nothing in the block can be seen.
  bool hidden(const Block& b) const {
    for (int y = b.y0; y < std::min(b.y1, frustum_.tile_y1); ++y)
      if (!full_[y - frustum_.tile_y0]) return false;
    return true;
  }

  enum class Axis { none, down, depth };

  // Where to cut: across what is longest. Within a tile slabs stay long where f rises or falls steadily along its rays, and become
  // short where rounding would blur a root by more than is asked for.
  Axis longest(const Block& b, const Form& form, double error, double largest) const {
    const int parts = b.last - b.first;
    const double length = at(b.last) - at(b.first);
    const bool long_slab = parts > 1 << (kMostDepthCuts - (demand_.few && n_ <= kMostDegreeOfFew + 1 ? kUsualDepthCutsOfFew : kUsualDepthCuts));
    if (b.y1 - b.y0 > 1) {
      const double middle = at((b.first + b.last) / 2), spread = frustum_.perspective ? std::fabs(frustum_.distance + middle) : 1;
      return long_slab && length >= (b.y1 - b.y0) * std::fabs(static_cast<double>(frustum_.down)) * spread ? Axis::depth : Axis::down;
    }
    if (parts == 1) return Axis::none;
    const double degree = static_cast<double>(n_ - 1);
    if (long_slab) {
      // Steady: the least slope along any ray is a fair share of the largest value, so that roots are as exact as coefficients are.
      const double slope = kSteady * largest / degree + 2 * error;
      const Extent steps = steps_of(form.hi, along_depth());
      if (!(steps.lowest > slope || steps.highest < -slope)) return Axis::depth;
    }
    // How far off rounding may put a root, in parts of the slab: where coefficients change their sign most slowly.
    const double blur = (largest * rounding() + error) / std::max(slowest_change(form.hi, along_depth()) * degree, 1e-300);
    return blur * length > 0.25 * demand_.eps ? Axis::depth : Axis::none;
  }

  bool emit(const Block& b, const Form& form, double error, double largest) {
    int exponent;
    std::frexp(largest, &exponent);
    const double scale = std::ldexp(1.0, 1 - exponent), kept = error * scale + 0x1p-52;
    if (!form.lo && strict_ && kept > enough()) return false;
    bool above = true, below = true;  // at the near end, and the opposite at the far one, on every ray
    for (std::size_t j = 0; j < n_ && (above || below); ++j)
      for (std::size_t i = 0; i < n_; ++i) {
        const double first = form.hi[j * n_ * m_ + i], last = form.hi[(j * n_ + n_ - 1) * m_ + i];
        above = above && first > error && last < -error;
        below = below && first < -error && last > error;
      }
    if ((above || below) && place(b) < 0) full_[b.y0 - frustum_.tile_y0] = true;
    const std::size_t depth = static_cast<std::size_t>(demand_.depth) + 1, down = demand_.reduced ? reduced_.down : n_, across = demand_.reduced ? reduced_.across : n_;
    const std::size_t step = kCellStep * (demand_.single() ? sizeof(float) : sizeof(double)), begin = found_.coefficients.used / step;
    std::byte* const to = found_.coefficients.add(whole_steps(down * depth * across) * step);
    const double* const from = demand_.reduced ? reduced_.values.data() : form.hi;
    const std::size_t lines = demand_.reduced ? reduction_.padded() : m_;
    if (demand_.single()) {
      pack(from, down * depth, across, lines, scale, reinterpret_cast<float*>(to));
    } else {
      pack(from, down * depth, across, lines, scale, reinterpret_cast<double*>(to));
    }
    // Coefficients and both bases are rounded once, and each sum once a term; a term more for the rest.
    const auto bound = [&](std::size_t terms, double unit, double weight, double lost) { return kept + scale * (lost + static_cast<double>(terms + 4) * unit * weight); };
    Cells::Cell cell{at(b.first), at(b.last), bound(down + across, demand_.unit, demand_.reduced ? reduced_.weight : largest, demand_.reduced ? reduced_.error : 0),
                     static_cast<std::int32_t>(down), static_cast<std::int32_t>(across), static_cast<std::int32_t>(begin)};
    if (demand_.exact) {
      cell.exact_begin = static_cast<std::int32_t>(found_.exact.used / (kCellStep * sizeof(double)));
      pack(form.hi, n_ * n_, n_, m_, scale, reinterpret_cast<double*>(found_.exact.add(whole_steps(n_ * n_ * n_) * kCellStep * sizeof(double))));
      cell.exact_error = bound(2 * n_, 0x1p-53, largest, 0);
    }
    found_.leaves.push_back({x_, b.y0, cell});
    return true;
  }

  double enough() const { return !demand_.single() ? kExactInDoubles : demand_.exact ? kExactToRefine : std::max(rounding(), kExactEnough); }

  // What is to be expected of the kernel's, in parts of the largest coefficient.
  double rounding() const { return 2 * (demand_.depth + 5) * demand_.unit; }

  const Frustum& frustum_;
  Demand demand_;
  const Reduction& reduction_;
  Reduction::Reduced reduced_;
  Found& found_;
  std::size_t n_, m_, size_;
  double grow_, slack_;
  int x_ = 0;
  double sx_[2] = {};   // its left and its right
  int precise_ = 0;     // cuts that this column needs in sums of two doubles
  bool strict_ = true;  // whether cells have to be exact enough
  std::vector<bool> full_;  // tiles all of whose rays have a root in a cell that stands already (nothing behind it is seen), or that nobody asked for
  std::vector<Room> pool_;
};

}  // namespace

Columns::Columns(Whole whole, int degree, const Frustum& frustum) : degree_(degree) { split(frustum.tile_x0, frustum.span_x(), std::move(whole), frustum); }

void Columns::split(int x, int span, Whole form, const Frustum& frustum) {
  if (x >= frustum.tile_x1) return;
  if (span == 1) return forms_.push_back(std::move(form));
  const std::size_t n = static_cast<std::size_t>(degree_) + 1;
  Whole second = form;
  halve(form.hi.data(), form.lo.data(), second.hi.data(), second.lo.data(), {n, n * n, n * n, 1, 0});
  form.error = second.error = form.error + static_cast<double>(n + 1) * kDoubleDoubleUnit * form.largest;
  split(x, span / 2, std::move(form), frustum);
  split(x + span / 2, span / 2, std::move(second), frustum);
}

Cells cells_of(const Columns& forms, const Frustum& f, const Demand& demand, const Space& room, const Space& exact_room) {
  const int columns = f.tile_x1 - f.tile_x0, rows = f.tile_y1 - f.tile_y0;
  Cells out;
  out.begins.assign(static_cast<std::size_t>(std::max(0, rows * columns)) + 1, 0);
  if (rows <= 0 || columns <= 0) {
    room(kBehind);
    if (demand.exact) exact_room(kBehind);
    return out;
  }
  const Reduction reduction(forms.degree(), demand.depth);
  const std::size_t workers = crew_size();
  std::vector<Found> found(workers);
  static std::array<std::array<Expected, limits::kFrustumDegree + 1>, 3> expected;  // in floats, in doubles, besides floats
  Rows coefficients(found, &Found::coefficients, demand.single() ? sizeof(float) : sizeof(double), room, expected[demand.single() ? 0 : 1][forms.degree()]);
  std::optional<Rows> exact;
  if (demand.exact) exact.emplace(found, &Found::exact, sizeof(double), exact_room, expected[2][forms.degree()]);
  std::atomic<std::size_t> next{0};
  by_crew([&](std::size_t worker) {
    Cutter cutter(f, demand, forms.degree(), reduction, found[worker]);
    // From the middle outward: the last columns hold little, so that workers end together.
    for (std::size_t k; (k = next++) < forms.count();) {
      const std::size_t middle = (forms.count() - 1) / 2, column = k % 2 ? middle + (k + 1) / 2 : middle - k / 2;
      const Whole& form = forms.form(column);
      cutter.run(f.tile_x0 + static_cast<int>(column), form.hi.data(), form.lo.data(), form.error);
    }
  });
  for (const Found& part : found)
    for (const auto& leaf : part.leaves) ++out.begins[f.tile_index(leaf.x, leaf.y) + 1];
  for (std::size_t i = 1; i < out.begins.size(); ++i) out.begins[i] += out.begins[i - 1];
  const auto count = static_cast<std::size_t>(out.begins.back());
  out.cells.resize(count);
  const std::vector<std::int32_t> begins = coefficients.settle(), exact_begins = exact ? exact->settle() : std::vector<std::int32_t>(workers, 0);
  std::vector<std::int32_t> at = out.begins;
  for (std::size_t worker = 0; worker < workers; ++worker)
    for (const auto& leaf : found[worker].leaves) {
      Cells::Cell& cell = out.cells[at[f.tile_index(leaf.x, leaf.y)]++];
      cell = leaf.cell;
      cell.begin += begins[worker];
      cell.exact_begin += exact_begins[worker];
    }
  return out;
}

}  // namespace irt::numerics
