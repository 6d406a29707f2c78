// OpenCL devices without an OpenCL library: drivers are found, tried in a child process before they are trusted,
// loaded one at a time, and called through their own dispatch tables.
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

// One device as `irt.devices()` lists it.
struct Info {
  std::string name;     // CL_DEVICE_NAME; the driver's path where it never came so far
  std::string driver;   // which driver: "pocl (system)", "pocl (pip)", "intel (pip)", ...
  std::string version;  // CL_DRIVER_VERSION
  int width = 1;        // widest float packet that the probe found right: 1, 4, 8 or 16; GPUs: 1
  bool fp64 = false;
  bool gpu = false;
  bool ok = false;
  std::string reason;   // why it is not ok, or why a width is not used; what to install
};

class Buffer;

// A built kernel. Belongs to its device; immutable, safe to share between threads.
class Kernel {
 public:
  virtual ~Kernel() = default;
};

// Device memory behind a host array. On CPU drivers it is the host array itself (no copy).
class Buffer {
 public:
  virtual ~Buffer() = default;
  // Makes what the kernels wrote visible in the host array. No cost where memory is shared.
  virtual void read() = 0;
};

enum class Access { read, write, read_write };

// One kernel argument, by value or by buffer.
using Arg = std::variant<std::int32_t, float, double, const Buffer*>;

// What stops a run between tiles.
struct Control {
  std::function<bool()> cancelled;  // asked between tiles, on the calling thread; empty: never
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<void(double)> progress;  // fraction done, between tiles; empty: not reported
};

enum class Outcome { done, cancelled, late };

class Device : public std::enable_shared_from_this<Device> {
 public:
  virtual ~Device() = default;
  virtual const Info& info() const = 0;
  // The kernel `entry` of `source`, built now or found in the (bounded) cache. Throws BuildError with the numbered
  // source and the driver's log. Options are fixed by the library; none of them relaxes arithmetic.
  virtual std::shared_ptr<Kernel> kernel(const std::string& source, const std::string& entry) = 0;
  // How many programs this device has built so far (cache hits are not builds).
  virtual std::uint64_t builds() const = 0;
  // `host` must outlive the buffer. Alignment of 64 lets CPU drivers use it in place.
  virtual std::unique_ptr<Buffer> buffer(void* host, std::size_t bytes, Access access) = 0;
  // Runs the kernel over columns x rows work-items in bands of rows (get_global_id(0), get_global_id(1) count over
  // the whole grid), each band short enough that cancellation answers at once. Blocks; does not need the GIL.
  // `seconds`, where given, receives the time that the kernels took.
  virtual Outcome run(Kernel& kernel, std::span<const Arg> args, std::size_t columns, std::size_t rows,
                      const Control& control, double* seconds = nullptr) = 0;
};

// Every device of every driver found, those that failed included. Probes drivers that it sees for the first time.
std::vector<Info> list();

// The device that `choice` names (a substring of name or driver; "": IMPLICITRT_DEVICE, else the best: a GPU, a
// system driver, Intel's where `ld` is missing). Loads only that driver. Throws DeviceError.
std::shared_ptr<Device> open(const std::string& choice = "");

}  // namespace irt::device
