// Cutting the frustum form into cells; see frustum_form.h.
//
// Columns of tiles come first, in sums of two doubles; each is then cut down and along its depth by one thread. There double
// takes over as soon as it leaves the cells exact enough: where it does not, the same block is cut further in sums of two.
#include "numerics/frustum_form.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <utility>

#include "caps.h"
#include "numerics/crew.h"
#include "numerics/double_double.h"
#include "numerics/frustum_cuts.h"
#include "numerics/frustum_reduce.h"
#include "numerics/recent.h"

namespace irt::numerics {
namespace {

// Cells may always be as inexact as this, in parts of their largest coefficient: those of floats, those by which roots are refined as well, those of doubles. What
// is less exact leaves pixels beside nodes wide. The first may be as inexact as rounding is, the second as kMostToRefine, where no root suffers.
constexpr double kExactEnough = 1e-7, kExactToRefine = 1e-11, kExactInDoubles = 1e-11, kMostToRefine = 1e-8;
// How far rounding may put a root off, in parts of the width that is asked for; as nets tell it, which look at fewer places; and the error of a cell alone, where it is
// more than the least.
constexpr double kMostBlur = 0.25, kMostBlurOfNets = 0.0625, kLittleBlur = 0.05;
// Cuts of a column of tiles after which double takes over at the latest.
constexpr int kPreciseCuts = 6;
// What reduction may lose in each direction: in halves of an ulp of the largest coefficient; of cells in doubles in parts of it, between these and by the eps they are for.
constexpr double kLost = 4, kLeastLost = 1e-11, kMostLost = 1e-9, kLostToRefine = 0.002;
// Least slope of a steady cell, in parts of its largest value.
constexpr double kSteady = 0.1;
// Halvings of the depth after which slabs are short enough, but for accuracy. For few pixels cells cost more than
// roots do, up to a degree above which long slabs leave pixels to the reference.
constexpr int kUsualDepthCuts = 3, kUsualDepthCutsOfFew = 0, kMostDegreeOfFew = 12;
// One more where in a slab f changes its sign twice on more than this share of the tile: one cut here spares all packets one.
constexpr double kWinding = 0.5;

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

std::shared_ptr<const Reduction> reduction_of(int degree, int depth) {
  static auto* const recent = new Recent<std::pair<int, int>, Reduction>;
  return recent->get({degree, depth}, [&] { return std::make_shared<const Reduction>(degree, depth); });
}

// One column of tiles after another.
class Cutter {
 public:
  Cutter(const Frustum& frustum, const Demand& demand, int degree, Found& found)
      : frustum_(frustum), demand_(demand), found_(found), n_(static_cast<std::size_t>(degree) + 1), m_(in_lanes(n_)),
        size_(n_ * n_ * m_), grow_(degree + 1),
        slack_(1e-12 * (glm::length(frustum.upper - frustum.lower) + glm::length(frustum.middle) + std::fabs(frustum.distance))) {
    if (!demand.reduced) return;
    reduction_ = reduction_of(degree, demand.depth);
    if (demand.exact) exact_reduction_ = reduction_of(degree, demand.exact_depth);
  }

  // hi + lo is the form over column x: [across][down][depth].
  void run(int x, const double* hi, const double* lo, double error) {
    x_ = x;
    for (int k = 0; k < 2; ++k) sx_[k] = static_cast<double>(frustum_.left + (x + k) * frustum_.across);
    full_.assign(static_cast<std::size_t>(frustum_.span_y()), false);
    if (demand_.tiles)
      for (int y = frustum_.tile_y0; y < frustum_.tile_y1; ++y) full_[y - frustum_.tile_y0] = !(*demand_.tiles)[frustum_.tile_index(x, y)];
    const Block all{frustum_.tile_y0, frustum_.tile_y0 + frustum_.span_y(), 0, 1 << kMostDepthCuts};
    if (hidden(all)) return;
    allowed_ = HUGE_VAL;
    const Extent extent = extent_of(hi, n_ * n_ * n_);
    if (demand_.reduced) {
      const double largest = extent.size();
      if (in_strips(all, 0, hi, {1, n_ * n_}, error + 0x1p-53 * largest, largest)) return;
      only(failed_, all);
    }
    const Form form = at_level(0);
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t k = 0; k < n_; ++k)
        for (std::size_t i = 0; i < m_; ++i) {
          const std::size_t from = (std::min(i, n_ - 1) * n_ + j) * n_ + k, to = (j * n_ + k) * m_ + i;
          form.hi[to] = hi[from];
          form.lo[to] = lo[from];
        }
    cut(all, form, extent, error, 0);
  }

 private:
  // A buffer for each level of the recursion: [down][depth][across], lines across padded by repetition.
  Form at_level(int level) {
    while (static_cast<int>(pool_.size()) <= level) pool_.emplace_back();
    double* const hi = pool_[level].of(2 * size_);
    return {hi, hi + size_};
  }

  Runs along_depth() const { return {n_, m_, m_, n_, n_ * m_}; }
  Runs along_down() const { return {n_, n_ * m_, n_ * m_, 1, 0}; }

  // `form` over `block`; front to back within each tile. False where double leaves a cell less exact than it may be.
  bool cut(const Block& block, Form form, const Extent& extent, double error, int level) {
    if (block.y0 >= frustum_.tile_y1) return true;
    const double largest = extent.size(), known = error + (form.lo ? 0x1p-53 * largest : 0);
    const double unsure = known + astray(block, largest, along_coefficients());
    if (extent.lowest > unsure || extent.highest < -unsure || hidden(block) || place(block) > 0) return true;
    if (!form.lo || (largest > allowed_ && level < kPreciseCuts)) return cut_further(block, form, largest, error, level);
    if (!demand_.reduced) return in_double(block, form, extent, known, largest, level) || cut_further(block, form, largest, error, level);
    if (in_strips(block, level, form.hi, {m_, 1}, known, largest)) return true;
    const std::vector<bool> full = full_;
    const std::vector<int> failed = failed_;
    only(failed, block);
    cut_further(block, form, largest, error, level);
    for (int y = block.y0; y < std::min(block.y1, frustum_.tile_y1); ++y)
      if (std::find(failed.begin(), failed.end(), y) == failed.end()) full_[y - frustum_.tile_y0] = full[y - frustum_.tile_y0];
    return true;
  }

  bool cut_further(const Block& block, const Form& form, double largest, double error, int level) {
    const double known = error + (form.lo ? 0x1p-53 * largest : 0);
    const Axis axis = longest(block, form, known, largest);
    if (axis == Axis::none && demand_.reduced) return in_strips(block, kPreciseCuts, form.hi, {m_, 1}, known, largest);
    if (axis == Axis::none) return emit(block, form, known, largest);
    const Form buffer = at_level(level + 1), second{buffer.hi, form.lo ? buffer.lo : nullptr};
    Block a = block, b = block;
    Runs runs = along_down();
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

  // `form` in double from here on; where that is not enough nothing is found.
  bool in_double(const Block& block, const Form& form, const Extent& extent, double error, double largest, int level) {
    const Mark mark = here();
    const std::vector<bool> full = full_;
    const Form copy{at_level(level + 1).hi, nullptr};
    std::copy_n(form.hi, size_, copy.hi);
    strict_ = level < kPreciseCuts;
    if (cut(block, copy, extent, error, level + 1)) return true;
    forget(mark);
    full_ = full;
    allow(largest);
    return false;
  }

  // Double was not enough for a block with so large a coefficient.
  void allow(double largest) { allowed_ = std::min(allowed_, largest * std::min(0.5, enough() / failed_error_)); }

  // How much has been found, and what was found since.
  struct Mark {
    std::size_t leaves, coefficients, exact;
  };
  Mark here() const { return {found_.leaves.size(), found_.coefficients.used, found_.exact.used}; }
  void forget(const Mark& since) {
    found_.leaves.resize(since.leaves);
    found_.coefficients.used = since.coefficients;
    found_.exact.used = since.exact;
  }

  // The same by polynomials across (frustum_reduce.h); `form` has no coefficient larger than `largest`. Tiles for which that is not enough are left to be tried once more.
  bool in_strips(const Block& block, int level, const double* form, const Reduction::Steps& steps, double error, double largest) {
    double* const values = strips_[0].of(n_ * reduction_->plane());
    Reduction::Strip strip;
    const double lost = reduction_->strip_of(form, steps, largest, strip, values, scratch_);
    strict_ = level < kPreciseCuts;
    failed_.clear();
    strip_cut(block, strip, values, error + lost, 1);
    if (failed_.empty()) return true;
    allow(largest);
    return false;
  }

  // Nothing of a block is asked for but these tiles.
  void only(const std::vector<int>& tiles, const Block& block) {
    for (int y = block.y0; y < std::min(block.y1, frustum_.tile_y1); ++y) full_[y - frustum_.tile_y0] = true;
    for (const int y : tiles) full_[y - frustum_.tile_y0] = false;
  }

  void strip_cut(const Block& block, const Reduction::Strip& strip, double* values, double error, std::size_t level) {
    if (block.y0 >= frustum_.tile_y1 || hidden(block)) return;
    if (block.y1 - block.y0 == 1) {
      const Mark mark = here();
      double *const pencil = pencils_[0].of(n_ * (reduction_->width() + reduction_->net_width())), *const net = pencil + n_ * reduction_->width();
      const double lost = reduction_->pencil_of(values, strip, kMostDepthCuts, pencil, net, longest_, scratch_);
      if (slab(block, pencil, net, extent_of(net, n_ * reduction_->net_width()), error + lost, 1)) return;
      forget(mark);
      failed_.push_back(block.y0);
      return;
    }
    if (strips_.size() <= level) strips_.emplace_back();
    const std::size_t plane = reduction_->plane();
    double* const second = strips_[level].of(n_ * plane);
    halve_unseen(values, second, {n_, plane, plane, 1, 0});
    Block a = block, b = block;
    a.y1 = b.y0 = (block.y0 + block.y1) / 2;
    const Reduction::Strip half{strip.widest, 0.5 * strip.steepest};
    const double child = error + grow_ * 0x1p-53 * strip.widest;
    strip_cut(a, half, values, child, level + 1);
    strip_cut(b, half, second, child, level + 1);
  }

  // A slab of a pencil, and its net.
  bool slab(const Block& block, double* pencil, double* net, const Extent& extent, double error, std::size_t level, int placed = 0) {
    if (hidden(block)) return true;
    const std::size_t width = reduction_->width(), net_width = reduction_->net_width();
    double beside = 0;
    for (std::size_t k = 0; k < n_; ++k) beside = std::max(beside, reduction_->beside(pencil + k * width));
    const double largest = extent.size() + beside, off = astray(block, largest, along_values());
    if (extent.lowest - beside > error + off || extent.highest + beside < -(error + off)) return true;
    if (placed == 0) placed = place(block);  // what lies inside has parts inside
    if (placed > 0) return true;
    const Runs runs{n_, net_width, net_width, 1, 0};
    const bool shortest = block.last - block.first == 1;
    const bool winds = !demand_.few && cuts_left(block, kUsualDepthCuts + 1) && static_cast<double>(winding(net, runs)) > kWinding * static_cast<double>(net_width);
    if (!winds && !too_long(block, error, largest, kMostBlurOfNets, [&] { return steps_of(net, runs); }, [&] { return slowest_change(net, runs); }) &&
        reduction_->run(pencil, kLost * demand_.unit * largest, shortest, reduced_)) {
      const Extent first = extent_of(net, net_width), last = extent_of(net + (n_ - 1) * net_width, net_width);
      const double known = error + beside + off;
      if (!suffices(error / largest, [&] { return blur(block, error, slowest_change(net, runs)); })) return false;
      const bool enters = (first.lowest > known && last.highest < -known) || (first.highest < -known && last.lowest > known);
      return emit(block, pencil, error, largest, off, enters && placed < 0);
    }
    double *const second = pencils_[level].of(n_ * (width + net_width)), *const second_net = second + n_ * width;
    halve_unseen(pencil, second, {n_, width, width, 1, 0});
    const Halves halves = halve(net, second_net, runs);
    Block a = block, b = block;
    a.last = b.first = (block.first + block.last) / 2;
    const double child = error + grow_ * 0x1p-53 * longest_;
    return slab(a, pencil, net, halves.first, child, level + 1, placed) && slab(b, second, second_net, halves.second, child, level + 1, placed);
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

  // Where to cut: across what is longest.
  Axis longest(const Block& b, const Form& form, double error, double largest) const {
    if (b.y1 - b.y0 > 1) {
      const double middle = at((b.first + b.last) / 2), spread = frustum_.perspective ? std::fabs(frustum_.distance + middle) : 1;
      return long_slab(b) && length(b) >= (b.y1 - b.y0) * std::fabs(static_cast<double>(frustum_.down)) * spread ? Axis::depth : Axis::down;
    }
    const bool cuts = too_long(b, error, largest, kMostBlur, [&] { return steps_of(form.hi, along_depth()); }, [&] { return slowest_change(form.hi, along_depth()); });
    return cuts ? Axis::depth : Axis::none;
  }

  double length(const Block& b) const { return at(b.last) - at(b.first); }

  // How far values in a block, none of them or of its coefficients larger than `largest`, may be off because rays lie a little beside where they should. `slope`: how steep it is at most
  // from side to side, in parts of that: a polynomial of degree n by its coefficients, which differ by 2 at most, and by its values (Markov).
  double astray(const Block& b, double largest, double slope) const { return largest * slope * (frustum_.astray.x + frustum_.astray.y / (b.y1 - b.y0)); }
  // The same by the coefficients of a block; errors of these add a millionth of a millionth of themselves, for which bounds have room.
  double astray(const Block& b, const double* form) const {
    const double down = steps_of(form, along_down()).size();
    double across = 0;
    for (std::size_t line = 0; line < n_ * n_; ++line)
      for (std::size_t i = 0; i + 1 < n_; ++i) across = std::max(across, std::fabs(form[line * m_ + i + 1] - form[line * m_ + i]));
    return 1.01 * static_cast<double>(n_ - 1) * (across * frustum_.astray.x + down * frustum_.astray.y / (b.y1 - b.y0));
  }
  double along_coefficients() const { return 2 * static_cast<double>(n_ - 1); }
  double along_values() const { return 2 * static_cast<double>((n_ - 1) * (n_ - 1)); }
  // Whether the block has been halved along its depth less often than that.
  static bool cuts_left(const Block& b, int cuts) { return b.last - b.first > 1 << (kMostDepthCuts - cuts); }
  bool long_slab(const Block& b) const { return cuts_left(b, demand_.few && n_ <= kMostDegreeOfFew + 1 ? kUsualDepthCutsOfFew : kUsualDepthCuts); }

  // Whether a block of one tile is to be cut along its depth. Slabs stay long where f rises or falls steadily along the rays, and become
  // short where rounding would blur a root by more than is asked for.
  bool too_long(const Block& b, double error, double largest, double most_blur, const auto& steps, const auto& slowest) const {
    if (b.last - b.first == 1) return false;
    const double degree = static_cast<double>(n_ - 1);
    if (long_slab(b)) {
      // Steady: the least slope along any ray is a fair share of the largest value, so that roots are as exact as coefficients are.
      const double slope = kSteady * largest / degree + 2 * error;
      const Extent e = steps();
      if (!(e.lowest > slope || e.highest < -slope)) return true;
    }
    return blur(b, largest * rounding() + error, slowest()) > most_blur * demand_.eps;
  }

  // How far off a root may be in a cell whose values are off by `error` and change their sign so slowly from coefficient to coefficient.
  double blur(const Block& b, double error, double slowest) const { return error * length(b) / std::max(slowest * static_cast<double>(n_ - 1), 1e-300); }

  // What coefficients of a cell, none larger than `largest`, are multiplied by.
  static double scale_of(double largest) {
    int exponent;
    std::frexp(largest, &exponent);
    return std::ldexp(1.0, 1 - exponent);
  }

  // Coefficients and both bases are rounded once, and each sum once a term; a term more for the rest.
  static double bound(double kept, std::size_t terms, double unit, double weight) { return kept + static_cast<double>(terms + 4) * unit * weight; }

  // Whether a cell whose coefficients are so inexact, in parts of the largest, is exact enough: it need not be more than floats are where roots do not suffer.
  bool suffices(double kept, const auto& blur) {
    if (!strict_ || kept <= enough() || (kept <= most_inexact() && blur() <= kLittleBlur * (demand_.exact ? demand_.exact_eps : demand_.eps))) return true;
    failed_error_ = kept;
    return false;
  }

  template <typename Real>
  static Real* coefficients(Row& row, std::size_t count, std::int32_t& begin) {
    constexpr std::size_t step = kCellStep * sizeof(Real);
    begin = static_cast<std::int32_t>(row.used / step);
    return reinterpret_cast<Real*>(row.add(whole_steps(count) * step));
  }

  // full: every ray has a root in it, and what is behind nobody sees.
  bool emit(const Block& b, const double* pencil, double error, double largest, double off, bool full) {
    const double scale = scale_of(largest), kept = (error + off) * scale + 0x1p-52;
    if (full) full_[b.y0 - frustum_.tile_y0] = true;
    const auto down = static_cast<std::int32_t>(reduced_.down), across = static_cast<std::int32_t>(reduced_.across);
    Cells::Cell cell{at(b.first), at(b.last), bound(kept + scale * reduced_.error, reduced_.down + reduced_.across, demand_.unit, scale * reduced_.weight), down, across, 0};
    reduction_->pack(reduced_, scale, coefficients<float>(found_.coefficients, reduced_.down * (static_cast<std::size_t>(demand_.depth) + 1) * reduced_.across, cell.begin));
    if (demand_.exact) {
      const double lost = std::clamp(kLostToRefine * demand_.exact_eps / (frustum_.far - frustum_.near), kLeastLost, kMostLost);
      exact_reduction_->run(pencil, lost * largest, true, reduced_);
      cell.exact_error = bound(kept + scale * reduced_.error, reduced_.down + reduced_.across, 0x1p-53, scale * reduced_.weight);
      cell.exact_down = static_cast<std::int32_t>(reduced_.down);
      cell.exact_across = static_cast<std::int32_t>(reduced_.across);
      exact_reduction_->pack(reduced_, scale, coefficients<double>(found_.exact, reduced_.down * (static_cast<std::size_t>(demand_.exact_depth) + 1) * reduced_.across, cell.exact_begin));
    }
    found_.leaves.push_back({x_, b.y0, cell});
    return true;
  }

  bool emit(const Block& b, const Form& form, double error, double largest) {
    // Where rounding to the kernel's reals is more, nothing closer is looked for.
    const double most_off = astray(b, largest, along_coefficients()), off = most_off <= demand_.unit * largest ? most_off : astray(b, form.hi);
    const double scale = scale_of(largest), unsure = error + off, kept = unsure * scale + 0x1p-52;
    if (!form.lo && !suffices(error * scale + 0x1p-52, [] { return HUGE_VAL; })) return false;
    bool above = true, below = true;  // at the near end, and the opposite at the far one, on every ray
    for (std::size_t j = 0; j < n_ && (above || below); ++j)
      for (std::size_t i = 0; i < n_; ++i) {
        const double first = form.hi[j * n_ * m_ + i], last = form.hi[(j * n_ + n_ - 1) * m_ + i];
        above = above && first > unsure && last < -unsure;
        below = below && first < -unsure && last > unsure;
      }
    if ((above || below) && place(b) < 0) full_[b.y0 - frustum_.tile_y0] = true;
    const auto n = static_cast<std::int32_t>(n_);
    Cells::Cell cell{at(b.first), at(b.last), bound(kept, 2 * n_, demand_.unit, scale * largest), n, n, 0};
    if (demand_.single()) {
      pack(form.hi, n_ * n_, n_, m_, scale, coefficients<float>(found_.coefficients, n_ * n_ * n_, cell.begin));
    } else {
      pack(form.hi, n_ * n_, n_, m_, scale, coefficients<double>(found_.coefficients, n_ * n_ * n_, cell.begin));
    }
    if (demand_.exact) {
      cell.exact_error = bound(kept, 2 * n_, 0x1p-53, scale * largest);
      cell.exact_down = cell.exact_across = n;
      pack(form.hi, n_ * n_, n_, m_, scale, coefficients<double>(found_.exact, n_ * n_ * n_, cell.exact_begin));
    }
    found_.leaves.push_back({x_, b.y0, cell});
    return true;
  }

  double most_inexact() const { return demand_.exact ? kMostToRefine : demand_.single() ? rounding() : 0; }
  double enough() const { return !demand_.single() ? kExactInDoubles : demand_.exact ? kExactToRefine : kExactEnough; }

  // What is to be expected of the kernel's, in parts of the largest coefficient.
  double rounding() const { return 2 * (demand_.depth + 5) * demand_.unit; }

  const Frustum& frustum_;
  Demand demand_;
  std::shared_ptr<const Reduction> reduction_, exact_reduction_;  // Demand::reduced
  Reduction::Reduced reduced_;
  std::deque<Room> strips_{1};
  double longest_ = 0;       // the largest sum of sizes in a line of the pencil
  std::vector<int> failed_;  // tiles of the last strips that are less exact than they may be
  Room pencils_[kMostDepthCuts + 1], scratch_;  // pencils: by level
  Found& found_;
  std::size_t n_, m_, size_;
  double grow_, slack_;
  int x_ = 0;
  double sx_[2] = {};   // its left and its right
  double allowed_ = HUGE_VAL;  // how large coefficients may be for double to be enough, as far as this column has shown
  double failed_error_ = 0;    // of the last cell that was less exact than it may be
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
  const std::size_t workers = crew_size();
  std::vector<Found> found(workers);
  static std::array<std::array<Expected, limits::kFrustumDegree + 1>, 3> expected;  // in floats, in doubles, besides floats
  Rows coefficients(found, &Found::coefficients, demand.single() ? sizeof(float) : sizeof(double), room, expected[demand.single() ? 0 : 1][forms.degree()]);
  std::optional<Rows> exact;
  if (demand.exact) exact.emplace(found, &Found::exact, sizeof(double), exact_room, expected[2][forms.degree()]);
  std::atomic<std::size_t> next{0};
  by_crew([&](std::size_t worker) {
    Cutter cutter(f, demand, forms.degree(), found[worker]);
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
