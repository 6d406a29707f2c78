// OpenCL devices without an OpenCL library: one driver is loaded by path and called through its own dispatch table.
// Which driver, and how wide its packets may be, python/implicitrt/devices.py finds out beforehand.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace irt::device {

struct Info {
  std::string name;     // CL_DEVICE_NAME
  std::string driver;   // which driver: "pocl (system)", "intel (pip)", ...
  std::string version;  // CL_DRIVER_VERSION
  int width = 1;        // floats per packet: 1, 4, 8 or 16; GPUs: 1
  bool fp64 = false;
  bool gpu = false;
};

// A built kernel. Belongs to its device; safe to share between threads.
class Kernel {
 public:
  virtual ~Kernel() = default;
};

// Device memory behind a host array. On CPU drivers it is the host array itself (no copy).
class Buffer {
 public:
  virtual ~Buffer() = default;
};

enum class Access { read, write, read_write };

// One kernel argument, by value or by buffer.
using Arg = std::variant<std::int32_t, float, double, const Buffer*>;

// What stops a run between bands.
struct Control {
  std::function<bool()> cancelled;  // asked between bands, on the calling thread; empty: never
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<void(double)> progress;  // fraction done, between bands; empty: not reported
};

enum class Outcome { done, cancelled, late };

struct Timing {
  double launch = 0;  // the first launch of a new kernel, at which drivers finish compiling
  double kernel = 0;
};

class Device : public std::enable_shared_from_this<Device> {
 public:
  virtual ~Device() = default;
  virtual const Info& info() const = 0;
  // The kernel `entry` of `source`, built now or found in the (bounded) cache. Throws BuildError with the numbered
  // source and the driver's log. Options are fixed by the library; none of them relaxes arithmetic.
  // `built`: whether this call built it.
  virtual std::shared_ptr<Kernel> kernel(const std::string& source, const std::string& entry, bool* built = nullptr) = 0;
  // Begins to build what a later call may need, on a thread of its own; finish() waits for all of these. Whether it is there already.
  virtual bool prepare(const std::string& source, const std::string& entry) = 0;
  virtual void finish() = 0;
  // How many programs this device has built so far (cache hits are not builds).
  virtual std::uint64_t builds() const = 0;
  // `host` must outlive the buffer. Alignment of 64 lets CPU drivers use it in place.
  virtual std::unique_ptr<Buffer> buffer(void* host, std::size_t bytes, Access access) = 0;
  // Makes what the kernels wrote visible in the host arrays. All at once: drivers spend more on waiting for a command than on the command.
  virtual void read(const std::vector<const Buffer*>& buffers) = 0;
  // Runs the kernel over columns x rows work-items in bands, each short enough that cancellation answers at once. The
  // kernel's last two arguments, not among `args`, are ints: the column and row at which the band begins (global
  // offsets would make drivers compile once more). Blocks; does not need the GIL.
  virtual Outcome run(Kernel& kernel, std::span<const Arg> args, std::size_t columns, std::size_t rows,
                      const Control& control, Timing* timing = nullptr) = 0;
};

// Loads the driver at `path` and opens its first device (a GPU before a CPU). Throws DeviceError.
std::shared_ptr<Device> load(const std::string& path, const std::string& driver, int width);

// Runs the probe kernel: every kind of builtin that kernels use, at the device's width, in single precision and, where
// there is, double. "" where all values are right; else which are wrong.
std::string probe(Device& device);

}  // namespace irt::device
