// Kernel choice, buffers, launches, and the second pass in double for what single precision left open.
#include "render/launch.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iterator>
#include <limits>
#include <mutex>
#include <new>
#include <tuple>
#include <utility>

#include "caps.h"
#include "error.h"
#include "numerics/around_zeros.h"
#include "numerics/recent.h"
#include "numerics/widest.h"
#include "program/text.h"

namespace irt::render {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr std::size_t kSettings = 27, kReach = 6, kPositionPad = 7;  // kernels/scene.cl
constexpr double kVague = 16;  // of what bounds reach, how small a part coordinates may be off by
// Packets of a work-item, and how many items a frame has at least while it has more than one packet in each.
constexpr std::size_t kMostPackets = 8, kLeastItems = 256;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// What stands where the time limit stops the frame, or rays are not known: nothing is known from the start of the ray on.
void leave_open(Answer& a, std::size_t n, const Options& options) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  std::memset(a.depth->data(), 0, a.depth->bytes());
  std::memset(a.status->data(), 3, a.status->bytes());
  if (a.wide) {
    std::fill_n(a.uncertainty->as<double>(), n, static_cast<double>(kNone));
  } else {
    std::fill_n(a.uncertainty->as<float>(), n, kNone);
  }
  if (a.normal) std::fill_n(a.normal->as<float>(), 3 * n, kNone);
  if (a.pieces) std::memset(a.pieces->data(), 0, a.pieces->bytes());
  if (a.rgba) {
    const auto& c = options.unresolved_color;
    std::fill_n(a.rgba->as<std::uint32_t>(), n, pixel_of({c[0], c[1], c[2], 1}));
  }
}

// Large blocks lie on huge pages where there are any: results are written once, all over, which costs a fault a page.
void* allocate(std::size_t bytes) {
  constexpr std::size_t kHuge = 2u << 20;
  if (bytes < kHuge) return std::aligned_alloc(kAlignment, bytes);
  void* p = std::aligned_alloc(kHuge, (bytes + kHuge - 1) / kHuge * kHuge);
  if (p) madvise(p, bytes, MADV_HUGEPAGE);
  return p;
}

// Blocks of results that were dropped, for the next frame of the same size: fresh pages cost more than shading does.
class Pool {
 public:
  void* take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    const auto it = std::find_if(blocks_.begin(), blocks_.end(), [&](const auto& b) { return b.second == bytes; });
    if (it == blocks_.end()) return nullptr;
    void* p = it->first;
    held_ -= bytes;
    blocks_.erase(it);
    return p;
  }

  void give(void* block, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (bytes > kLargest) return std::free(block);
    blocks_.emplace_back(block, bytes);
    held_ += bytes;
    while (held_ > kHeld) {
      std::free(blocks_.front().first);
      held_ -= blocks_.front().second;
      blocks_.pop_front();
    }
  }

 private:
  static constexpr std::size_t kHeld = 128u << 20, kLargest = 64u << 20;
  std::mutex mutex_;
  std::deque<std::pair<void*, std::size_t>> blocks_;
  std::size_t held_ = 0;
};

Pool& pool() {
  static Pool* p = new Pool;  // arrays may outlive static storage
  return *p;
}

}  // namespace

std::uint32_t pixel_of(const std::array<double, 4>& color) {
  std::uint32_t pixel = static_cast<std::uint32_t>(std::lround(255 * color[3])) << 24;
  for (int k = 0; k < 3; ++k) {
    const double c = std::clamp(color[k], 0.0, 1.0);
    const double encoded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
    pixel |= static_cast<std::uint32_t>(std::lround(255 * encoded)) << (8 * k);
  }
  return pixel;
}

Memory::Memory(std::size_t bytes) : bytes_(std::max(bytes, kAlignment)) {
  bytes_ = (bytes_ + kAlignment - 1) / kAlignment * kAlignment;
  void* p = pool().take(bytes_);
  if (!p) p = allocate(bytes_);
  if (!p) throw LimitError(fmt::format("no memory for {} bytes; ask for a smaller frame or fewer outputs", bytes_));
  data_ = std::shared_ptr<void>(p, [size = bytes_](void* block) { pool().give(block, size); });
}

int packet_width(const device::Device& device, program::Precision precision) {
  const int width = device.info().width;
  return precision == program::Precision::Double ? std::max(1, width / 2) : width;
}

bool splits(const device::Device& device, const Options& options, program::Precision precision) {
  return precision == program::Precision::Single && options.outward && device.info().fp64;
}

bool needs_infinities(const program::Program& program, const glm::dvec3& coordinates, const Options& options,
                      program::Precision precision) {
  const double at[3] = {coordinates.x, coordinates.y, coordinates.z};
  std::vector<double> parameters = options.parameters;
  for (double& p : parameters) p = std::fabs(p);
  return !(program::magnitude(program, at, parameters) < (precision == program::Precision::Double ? 1e300 : 1e36));
}

Bounds narrowed(const Bounds& bounds, const Formulas& formulas, const Options& options) {
  if (!options.by_enclosures()) return bounds;
  using Key = std::tuple<Expr, std::map<std::string, double>, glm::dvec3, glm::dvec3>;
  static auto* const recent = new numerics::Recent<Key, numerics::Box>;  // cameras move more often than formulas change
  const auto box = recent->get({formulas.f, formulas.parameters, bounds.lower, bounds.upper}, [&] {
    return std::make_shared<const numerics::Box>(numerics::around_zeros(formulas.f, formulas.parameters, {bounds.lower, bounds.upper}));
  });
  Bounds part = bounds;
  part.farthest = 0.5 * brackets_reach(bounds);
  // Brackets of the frustum form reach as far to both sides of their roots.
  const double room = options.by_frustum() ? 2 * std::max(options.eps, options.first_eps) : 0;
  part.lower = glm::max(bounds.lower, box->lower - room);
  part.upper = glm::min(bounds.upper, box->upper + room);
  return part;
}

glm::dvec3 brackets_reach(const Bounds& bounds) { return 2.0 * glm::max(bounds.farthest, glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper))); }

Reals parameter_ends(const program::Program& program, const Options& options, program::Precision precision) {
  Reals ends(precision, 2 * program.inputs());
  for (std::size_t i = 0; i < program.inputs(); ++i) {
    const numerics::Bounds b = program::outward({options.parameters[i], options.parameters[i]}, precision);
    ends.set(2 * i, b.lo);
    ends.set(2 * i + 1, b.hi);
  }
  return ends;
}

double reach(const Bounds& bounds) { return 0.5 * glm::length(bounds.upper - bounds.lower) * (1 + 1e-6); }

namespace {

// Whether no point of the ball is outside the box; sums of two doubles of about the same size are exact.
bool lies_in_box(const Ball& ball, const Bounds& bounds) {
  const long double radius = ball.radius;
  for (int k = 0; k < 3; ++k)
    if (ball.center[k] - radius < bounds.lower[k] || ball.center[k] + radius > bounds.upper[k]) return false;
  return true;
}

}  // namespace

Reals scene_settings(const Bounds& bounds, const Options& options, program::Precision precision, double position_pad,
                     double near, bool boxed) {
  Reals q(precision, kSettings + 4 * (bounds.balls.size() + bounds.half_spaces.size()));
  for (int k = 0; k < 3; ++k) {
    q.set(k, bounds.lower[k]);
    q.set(3 + k, bounds.upper[k]);
    q.set(11 + k, options.color[k]);
    q.set(14 + k, options.back_color[k]);
    q.set(17 + k, options.unresolved_color[k]);
    q.set(20 + k, options.light[k]);
  }
  q.set_above(kReach, reach(bounds));
  q.set_above(kPositionPad, position_pad);
  q.set(8, options.eps);
  q.set(26, precision == program::Precision::Single && options.first_eps > 0 ? options.first_eps : options.eps);
  q.set_below(9, near);
  q.set_above(10, near);
  q.set(23, glm::length(options.light) > 0 ? 1 : 0);
  q.set(24, options.steps);
  q.set(25, boxed && std::none_of(bounds.balls.begin(), bounds.balls.end(), [&](const Ball& ball) { return lies_in_box(ball, bounds); }) ? 1 : 0);
  for (std::size_t i = 0; i < bounds.balls.size(); ++i) {
    for (int k = 0; k < 3; ++k) q.set(kSettings + 4 * i + k, bounds.balls[i].center[k]);
    q.set(kSettings + 4 * i + 3, bounds.balls[i].radius);
  }
  const std::size_t after = kSettings + 4 * bounds.balls.size();
  for (std::size_t i = 0; i < bounds.half_spaces.size(); ++i) {
    for (int k = 0; k < 3; ++k) q.set(after + 4 * i + k, bounds.half_spaces[i].normal[k]);
    q.set(after + 4 * i + 3, bounds.half_spaces[i].offset);
  }
  return q;
}

Options contracting(Options options) {
  options.finder = "contract";
  options.affine = true;
  return options;
}

void add_shading(Answer& a, const Options& options) {
  const std::size_t n = a.pitch * a.rows;
  if (options.normal) a.normal.emplace(3 * n * sizeof(float));
  if (options.rgb) a.rgba.emplace(n * 4);
}

Answer make_answer(std::size_t columns, std::size_t rows, int width, program::Precision precision, const Options& options) {
  Answer a;
  a.columns = columns;
  a.rows = rows;
  a.width = width;
  a.pitch = (columns + width - 1) / width * width;
  a.wide = precision == program::Precision::Double;
  const std::size_t n = a.pitch * rows;
  a.depth.emplace(n * size_of(precision));
  a.uncertainty.emplace(n * size_of(precision));
  a.status.emplace(n);
  add_shading(a, options);
  if (options.pieces) a.pieces.emplace(n * 4);
  if (options.control.deadline != std::chrono::steady_clock::time_point::max()) leave_open(a, n, options);
  return a;
}

kernel::Spec with_options(kernel::Spec spec, const Options& options) {
  spec.affine = options.affine;
  spec.finder = options.finder;
  spec.reads = options.reads;
  spec.defines = options.defines;
  spec.outward = options.outward;
  spec.normal = options.normal;
  spec.rgb = options.rgb;
  spec.pieces = options.pieces;
  return spec;
}

namespace {

// What of a specification depends on the values of f: infinities, and whether the derivative along the ray helps.
void set_enclosures(kernel::Spec& spec, const program::Program& program, const Bounds& bounds, const Options& options) {
  const glm::dvec3 coordinates = brackets_reach(bounds);
  spec.infinite = needs_infinities(program, coordinates, options, spec.precision);
  if (options.finder == "mitchell") {
    const auto derivative = program::along(program);
    spec.along = derivative.has_value();
    spec.infinite = spec.infinite || (derivative && needs_infinities(*derivative, coordinates, options, spec.precision));
    return;
  }
  // Bisection and contraction march without pads where nothing overflows.
  spec.slack = options.outward && !spec.infinite && (options.finder == "bisection" || (options.finder == "contract" && options.affine));
  // Bisection with intervals isolates roots where it is to prove them; not if all of f had to survive infinities for it, and not
  // where a clip formula is to be proven along with each bracket; nor where Min or Max choose, at whose edges the derivative jumps: that
  // gains a tenth at best, and doubles what the driver has to compile.
  if (options.affine || !options.outward || options.finder != "bisection" || program.has_region() || program.has_choices()) return;
  const auto derivative = program::along(program);
  spec.along = derivative && (spec.infinite || !needs_infinities(*derivative, coordinates, options, spec.precision));
}

}  // namespace

kernel::Spec spec_of(const program::Program& program, const Bounds& bounds, const Options& options, const device::Device& device,
                     program::Precision precision, kernel::Entry entry) {
  kernel::Spec spec;
  spec.entry = entry;
  spec.precision = precision;
  spec.width = packet_width(device, precision);
  spec.split = splits(device, options, precision);
  spec.spheres = static_cast<int>(bounds.balls.size());
  spec.half_spaces = static_cast<int>(bounds.half_spaces.size());
  set_enclosures(spec, program, bounds, options);
  return with_options(spec, options);
}

bool prepare(const program::Program& program, const kernel::Spec& spec, device::Device& device) {
  return device.prepare(kernel::assemble(program, spec), kernel::entry_name(spec.entry));
}

void launch(const program::Program& program, const kernel::Spec& spec, std::vector<device::Arg> args, const Reals& settings,
            std::vector<device::Arg> more, const Options& options, device::Device& device, Answer& answer) {
  const Reals parameters = parameter_ends(program, options, spec.precision);
  const auto buffer = parameters.buffer(device);
  if (program.inputs()) more.emplace_back(buffer.get());
  launch(kernel::assemble(program, spec), spec, std::move(args), settings, std::move(more), options, device, answer);
}

void launch(const std::string& source, const kernel::Spec& spec, std::vector<device::Arg> args, const Reals& settings,
            std::vector<device::Arg> more, const Options& options, device::Device& device, Answer& answer) {
  // Of rays from so far away that they may lie anywhere in the bounds nothing can be told, and f would be asked where it may overflow: kernels are made for values within
  // twice the bounds.
  if (spec.entry != kernel::Entry::Neighbours && settings.get(kPositionPad) > settings.get(kReach) / kVague) {
    answer.tally.reset();
    return leave_open(answer, answer.pitch * answer.rows, options);
  }
  if (spec.precision == program::Precision::Double && !device.info().fp64)
    throw DeviceError(fmt::format("{} has no double precision; use precision=\"single\" or another device", device.info().name));
  const auto start = std::chrono::steady_clock::now();
  bool built;
  const auto kernel = device.kernel(source, kernel::entry_name(spec.entry), &built);
  answer.builds += built;
  answer.build_seconds += seconds_since(start);

  std::vector<std::unique_ptr<device::Buffer>> buffers;
  std::vector<const device::Buffer*> outputs;
  const auto keep = [&](std::unique_ptr<device::Buffer> b) -> const device::Buffer* {
    buffers.push_back(std::move(b));
    return buffers.back().get();
  };
  const auto access = spec.sharpens ? device::Access::read_write : device::Access::write;
  const auto output = [&](const Memory& m) { return outputs.emplace_back(keep(device.buffer(m.data(), m.bytes(), access))); };
  args.emplace_back(keep(settings.buffer(device)));
  args.emplace_back(static_cast<std::int32_t>(answer.pitch));
  const bool finds = spec.entry != kernel::Entry::Neighbours;  // or only shades
  const int pieces = spec.precision == program::Precision::Double ? limits::kPiecesInDouble : limits::kPieces;
  if (finds) args.emplace_back(static_cast<std::int32_t>(options.max_pieces > 0 ? options.max_pieces : pieces));
  if (options.normal) {
    args.emplace_back(output(*answer.normal));
    args.emplace_back(static_cast<std::int32_t>(answer.pitch * answer.rows));
  }
  if (options.rgb) {
    args.emplace_back(output(*answer.rgba));
    args.emplace_back(static_cast<std::int32_t>(pixel_of(options.background)));
  }
  if (finds && options.pieces) args.emplace_back(output(*answer.pieces));
  if (finds)
    for (const auto* m : {&answer.depth, &answer.uncertainty, &answer.status}) args.emplace_back(output(**m));
  args.insert(args.end(), more.begin(), more.end());
  const kernel::Shape packet = kernel::shape_of(spec);
  std::size_t across = answer.pitch / packet.width, down = (answer.rows + packet.height - 1) / packet.height;
  if (finds) args.emplace_back(static_cast<std::int32_t>(answer.rows - 1));
  if (spec.beams) {
    const kernel::Tiling tiling(spec.width);
    across = (answer.pitch + tiling.across() - 1) / tiling.across();
    down = (answer.rows + tiling.down() - 1) / tiling.down();
  } else if (finds) {
    const std::size_t packets = spec.width == 1 ? 1 : std::clamp<std::size_t>(across * down / kLeastItems, 1, kMostPackets);
    args.emplace_back(static_cast<std::int32_t>(packets));
    across = (across + packets - 1) / packets;
  }
  device::Timing timing;
  answer.outcome = device.run(*kernel, args, across, down, options.control, &timing);
  answer.launch_seconds += timing.launch;
  answer.kernel_seconds += timing.kernel;
  answer.tally.reset();
  device.read(outputs);
}

namespace {

// How many of n pixels have each status, and how many brackets have the half asked for or less.
struct Counted {
  std::uint32_t hits = 0, touches = 0, open = 0, narrow = 0;
};

// Sums of comparisons, which compilers turn into vector code.
template <class Real>
[[gnu::always_inline]] inline Counted count(const unsigned char* status, const Real* half, std::size_t n, Real most) {
  Counted c;
  for (std::size_t i = 0; i < n; ++i) {
    c.hits += status[i] == 1;
    c.touches += status[i] == 2;
    c.open += status[i] == 3;
    c.narrow += static_cast<std::uint32_t>(status[i] == 1) & static_cast<std::uint32_t>(half[i] <= most);
  }
  return c;
}
IRT_WIDEST Counted counted(const unsigned char* status, const float* half, std::size_t n, float most) { return count(status, half, n, most); }
IRT_WIDEST Counted counted(const unsigned char* status, const double* half, std::size_t n, double most) { return count(status, half, n, most); }

bool is_wide(const Answer& answer, std::size_t i, const Options& options) {
  if (answer.status->as<unsigned char>()[i] != 1 || !options.outward) return false;
  return !(answer.uncertainty_at(i) <= 0.5 * options.eps);
}

bool is_undecided(const Answer& answer, std::size_t i, const Options& options) { return answer.status->as<unsigned char>()[i] >= 2 || is_wide(answer, i, options); }

// Counts what there is, row by row; `open` gets what undecided() tells. With fast rounding no bracket has a width.
void look(Answer& answer, const Options& options, std::vector<std::size_t>* open) {
  widen(answer);
  Tally& tally = answer.tally.emplace();
  const auto rows = [&](const auto* half, auto most) {
    for (std::size_t row = 0; row < answer.rows; ++row, half += answer.pitch) {
      const auto* status = answer.status->as<unsigned char>() + row * answer.pitch;
      Counted c = counted(status, half, answer.columns, most);
      if (!options.outward) c.narrow = c.hits;
      tally.counts[0] += answer.columns - c.hits - c.touches - c.open;
      tally.counts[1] += c.hits;
      tally.counts[2] += c.touches;
      tally.counts[3] += c.open;
      tally.wide_hits += c.hits - c.narrow;
      if (!open || c.touches + c.open + c.hits - c.narrow == 0) continue;  // as in most rows
      for (std::size_t i = 0; i < answer.columns; ++i)
        if (is_undecided(answer, row * answer.pitch + i, options)) open->push_back(row * answer.pitch + i);
    }
  };
  if (answer.wide) {
    rows(answer.uncertainty->as<double>(), 0.5 * options.eps);
  } else {
    rows(answer.uncertainty->as<float>(), float_below(0.5 * options.eps));
  }
}

}  // namespace

void tally(Answer& answer, const Options& options) {
  if (!answer.tally) look(answer, options, nullptr);
}

std::vector<std::size_t> undecided(Answer& answer, const Options& options) {
  std::vector<std::size_t> open;
  look(answer, options, &open);
  return open;
}

void widen(Answer& answer) {
  if (!answer.finer) return;
  const Finer finer = *std::exchange(answer.finer, std::nullopt);
  const std::size_t n = answer.pitch * answer.rows;
  for (auto [all, some] : {std::pair(&answer.depth, &finer.depth), std::pair(&answer.uncertainty, &finer.uncertainty)}) {
    Memory wider(n * sizeof(double));
    std::copy_n((*all)->as<float>(), n, wider.as<double>());
    for (std::size_t k = 0; k < finer.where.size(); ++k) wider.as<double>()[finer.where[k]] = some->as<double>()[k];
    *all = wider;
  }
  answer.wide = true;
}

std::vector<std::size_t> scatter(Answer& answer, Answer part, const std::vector<std::size_t>& where, const Options& options) {
  widen(part);
  widen(answer);
  const std::size_t n = answer.pitch * answer.rows;
  if (part.wide && !answer.wide) answer.finer = Finer{where, *part.depth, *part.uncertainty};
  const auto copy = [&](const Memory& to, std::size_t i, double v) {
    if (answer.wide) {
      to.as<double>()[i] = v;
    } else {
      to.as<float>()[i] = static_cast<float>(v);
    }
  };
  const std::size_t part_plane = part.pitch * part.rows;
  const auto count = [&](const Answer& from, std::size_t i, std::size_t by) {
    if (!answer.tally) return;
    answer.tally->counts[from.status->as<unsigned char>()[i]] += by;
    if (is_wide(from, i, options)) answer.tally->wide_hits += by;
  };
  std::vector<std::size_t> open;
  for (std::size_t k = 0; k < where.size(); ++k) {
    const std::size_t i = where[k];
    count(answer, i, -std::size_t{1});
    count(part, k, 1);
    if (is_undecided(part, k, options)) open.push_back(i);
    copy(*answer.depth, i, part.depth_at(k));
    copy(*answer.uncertainty, i, part.uncertainty_at(k));
    answer.status->as<unsigned char>()[i] = part.status->as<unsigned char>()[k];
    if (answer.normal)
      for (std::size_t axis = 0; axis < 3; ++axis)
        answer.normal->as<float>()[axis * n + i] = part.normal->as<float>()[axis * part_plane + k];
    if (answer.pieces && part.pieces) answer.pieces->as<std::uint32_t>()[i] += part.pieces->as<std::uint32_t>()[k];
    if (answer.rgba) answer.rgba->as<std::uint32_t>()[i] = part.rgba->as<std::uint32_t>()[k];
  }
  answer.escalated += where.size();
  answer.by_reference += part.by_reference;
  answer.add_work_of(part);
  answer.outcome = part.outcome;
  return open;
}

}  // namespace irt::render
