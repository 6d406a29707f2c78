// One OpenCL device: programs and their cache, buffers, and runs in bands.
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <list>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <utility>

#include "caps.h"
#include "device/device.h"
#include "device/opencl.h"

namespace irt::device {
namespace {

// How long a band should take: short enough for Ctrl-C, long enough that launches cost nothing beside it.
constexpr double kBandSeconds = 0.05;

// Builds that run ahead side by side; one more waits for the first of them.
constexpr std::size_t kMostAhead = 3;

double since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class ClKernel : public Kernel {
 public:
  ClKernel(Program built, std::string entry) : program(std::move(built)), name(std::move(entry)) {}
  Program program;
  std::string name;
  std::atomic<bool> launched{false};
  std::atomic<double> seconds_per_item{0};  // from the last run: sizes the first band of the next
};

class ClBuffer : public Buffer {
 public:
  ClBuffer(Memory object, std::size_t size) : memory(std::move(object)), bytes(size) {}
  Memory memory;
  std::size_t bytes;
};

std::string numbered(const std::string& source) {
  std::string out;
  std::size_t line = 1, start = 0;
  while (start < source.size()) {
    const std::size_t end = std::min(source.find('\n', start), source.size());
    out += fmt::format("{:5} | {}\n", line++, source.substr(start, end - start));
    start = end + 1;
  }
  return out;
}

// Launches of one kernel object on one queue.
struct Bands {
  cl_command_queue queue;
  cl_kernel kernel;
  cl_uint arguments;  // set already

  // Local size (1, 1) and no global offset: drivers that compile for each of these compile once.
  double launch(std::size_t x, std::size_t y, std::size_t columns, std::size_t rows) const {
    const auto first_column = static_cast<cl_int>(x), first_row = static_cast<cl_int>(y);
    check(table(kernel).clSetKernelArg(kernel, arguments, sizeof first_column, &first_column), "clSetKernelArg");
    check(table(kernel).clSetKernelArg(kernel, arguments + 1, sizeof first_row, &first_row), "clSetKernelArg");
    const std::size_t global[] = {columns, rows}, local[] = {1, 1};
    const auto start = std::chrono::steady_clock::now();
    check(table(queue).clEnqueueNDRangeKernel(queue, kernel, 2, nullptr, global, local, 0, nullptr, nullptr), "clEnqueueNDRangeKernel");
    check(table(queue).clFinish(queue), "clFinish");
    return since(start);
  }
};

class ClDevice : public Device {
 public:
  ClDevice(cl_device_id device, Info info) : device_(device), info_(std::move(info)), process_(getpid()) {
    cl_int code;
    context_ = table(device_).clCreateContext(nullptr, 1, &device_, nullptr, nullptr, &code);
    check(code, "clCreateContext");
    queue_ = make_queue();
  }
  // The context is never released: at exit drivers may already be gone, and devices live as long as the process.

  const Info& info() const override { return info_; }
  std::uint64_t builds() const override { return builds_; }

  // Nothing is locked while a driver compiles: other kernels can be had, and who asks for the same one waits for it.
  std::shared_ptr<Kernel> kernel(const std::string& source, const std::string& entry, bool* built) override {
    check_process();
    Wanted wanted = reserve(source);
    if (built) *built = wanted.promise.has_value();
    if (wanted.promise) fulfil(*wanted.promise, source, entry);
    return wanted.kernel.get();
  }

  // Reserved before this returns: a frame that comes next waits for this build and does none of its own.
  bool prepare(const std::string& source, const std::string& entry) override {
    check_process();
    const std::lock_guard lock(ahead_mutex_);
    Wanted wanted = reserve(source);
    if (!wanted.promise) return is_there(wanted.kernel);
    std::erase_if(ahead_, [](Ahead& a) {
      const bool done = is_there(a.kernel);
      if (done) a.thread.join();
      return done;
    });
    if (ahead_.size() >= kMostAhead) {
      ahead_.front().thread.join();
      ahead_.pop_front();
    }
    const auto promise = std::make_shared<Promise>(std::move(*wanted.promise));
    // If the build fails, who needs it will be told.
    const auto work = [this, source, entry, promise] { fulfil(*promise, source, entry); };
    try {
      ahead_.push_back({std::thread(work), wanted.kernel});
    } catch (const std::system_error&) {  // no thread to be had
      work();
    }
    return false;
  }

  void finish() override {
    const bool forked = getpid() != process_;  // a child has none of these threads, nor may it wait for a lock of its parent's
    std::unique_lock lock(ahead_mutex_, std::defer_lock);
    if (!forked) lock.lock();
    for (Ahead& a : ahead_) forked ? a.thread.detach() : a.thread.join();
    ahead_.clear();
  }

  std::unique_ptr<Buffer> buffer(void* host, std::size_t bytes, Access access) override {
    check_process();
    const cl_mem_flags flags = access == Access::read ? CL_MEM_READ_ONLY : access == Access::write ? CL_MEM_WRITE_ONLY : CL_MEM_READ_WRITE;
    cl_int code;
    cl_mem object = table(context_).clCreateBuffer(context_, flags | CL_MEM_USE_HOST_PTR, bytes, host, &code);
    check(code, "clCreateBuffer");
    return std::make_unique<ClBuffer>(Memory(object), bytes);
  }

  void read(const std::vector<const Buffer*>& buffers) override {
    check_process();
    for (const Buffer* base : buffers) {
      const auto& buffer = static_cast<const ClBuffer&>(*base);
      cl_int code;
      void* p = table(queue_.get()).clEnqueueMapBuffer(queue_.get(), buffer.memory.get(), CL_FALSE, CL_MAP_READ, 0, buffer.bytes, 0, nullptr, nullptr, &code);
      check(code, "clEnqueueMapBuffer");
      check(table(queue_.get()).clEnqueueUnmapMemObject(queue_.get(), buffer.memory.get(), p, 0, nullptr, nullptr), "clEnqueueUnmapMemObject");
    }
    check(table(queue_.get()).clFinish(queue_.get()), "clFinish");
  }

  Outcome run(Kernel& base, std::span<const Arg> args, std::size_t columns, std::size_t rows, const Control& control,
              Timing* timing) override {
    check_process();
    auto& kernel = static_cast<ClKernel&>(base);
    cl_int code;
    // A kernel object holds its arguments, so each run has one of its own.
    const KernelObject object(table(kernel.program.get()).clCreateKernel(kernel.program.get(), kernel.name.c_str(), &code));
    check(code, "clCreateKernel");
    for (std::size_t i = 0; i < args.size(); ++i) set_argument(object.get(), static_cast<cl_uint>(i), args[i]);
    const Queue queue = make_queue();
    Timing spent;
    const Bands bands{queue.get(), object.get(), static_cast<cl_uint>(args.size())};
    if (!kernel.launched.exchange(true)) spent.launch = bands.launch(0, 0, 1, 1);
    // Bands of rows; of columns where there is one row.
    const bool by_rows = rows > 1;
    const std::size_t lines = by_rows ? rows : columns, across = by_rows ? columns : 1;
    Outcome outcome = Outcome::done;
    for (std::size_t done = 0; done < lines;) {
      if (control.cancelled && control.cancelled()) {
        outcome = Outcome::cancelled;
        break;
      }
      if (std::chrono::steady_clock::now() > control.deadline) {
        outcome = Outcome::late;
        break;
      }
      const double rate = kernel.seconds_per_item;
      const double wanted = rate > 0 ? kBandSeconds / (rate * static_cast<double>(across)) : static_cast<double>(lines) / 16;
      std::size_t band = std::clamp<std::size_t>(static_cast<std::size_t>(std::min(wanted, 1e9)), 1, lines - done);
      // No short band at the end: two of equal length instead.
      if (band < lines - done && lines - done < 2 * band) band = (lines - done + 1) / 2;
      const double seconds = by_rows ? bands.launch(0, done, columns, band) : bands.launch(done, 0, band, 1);
      spent.kernel += seconds;
      kernel.seconds_per_item = seconds / static_cast<double>(band * across);
      done += band;
      if (control.progress) control.progress(static_cast<double>(done) / static_cast<double>(lines));
    }
    if (timing) {
      timing->launch += spent.launch;
      timing->kernel += spent.kernel;
    }
    return outcome;
  }

 private:
  using Promise = std::promise<std::shared_ptr<ClKernel>>;
  using Future = std::shared_future<std::shared_ptr<ClKernel>>;
  struct Entry {
    std::string source;
    Future kernel;
  };
  struct Wanted {
    Future kernel;
    std::optional<Promise> promise;  // for the first who asks: to be fulfilled
  };
  cl_device_id device_;
  cl_context context_;
  Queue queue_;
  Info info_;
  pid_t process_;
  struct Ahead {
    std::thread thread;
    Future kernel;
  };
  std::mutex mutex_, ahead_mutex_;
  std::list<Ahead> ahead_;
  std::list<Entry> recent_;
  std::unordered_map<std::string, std::list<Entry>::iterator> index_;
  std::atomic<std::uint64_t> builds_{0};

  static bool is_there(const Future& kernel) { return kernel.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }

  // OpenCL does not survive fork: a child that used the parent's driver would hang.
  void check_process() const {
    if (getpid() != process_)
      throw DeviceError("this process was forked after it had opened an OpenCL device, which no driver survives; start "
                        "workers with multiprocessing.get_context(\"spawn\"), or fork before the first render");
  }

  Queue make_queue() const {
    cl_int code;
    Queue queue(table(context_).clCreateCommandQueue(context_, device_, 0, &code));
    check(code, "clCreateCommandQueue");
    return queue;
  }

  Wanted reserve(const std::string& source) {
    const std::lock_guard lock(mutex_);
    if (const auto it = index_.find(source); it != index_.end()) {
      recent_.splice(recent_.begin(), recent_, it->second);
      return {it->second->kernel, {}};
    }
    Promise promise;
    recent_.push_front({source, promise.get_future().share()});
    index_[source] = recent_.begin();
    if (recent_.size() > limits::kPrograms) {
      index_.erase(recent_.back().source);
      recent_.pop_back();
    }
    return {recent_.front().kernel, std::move(promise)};
  }

  void fulfil(Promise& promise, const std::string& source, const std::string& entry) {
    try {
      promise.set_value(std::make_shared<ClKernel>(build(source), entry));
    } catch (...) {
      // Forgotten, so that the next who asks tries again.
      const std::lock_guard lock(mutex_);
      if (const auto it = index_.find(source); it != index_.end()) {
        recent_.erase(it->second);
        index_.erase(it);
      }
      promise.set_exception(std::current_exception());
    }
  }

  static void set_argument(cl_kernel kernel, cl_uint index, const Arg& arg) {
    const auto set = [&](std::size_t size, const void* value) { check(table(kernel).clSetKernelArg(kernel, index, size, value), "clSetKernelArg"); };
    if (const auto* buffer = std::get_if<const Buffer*>(&arg)) {
      cl_mem memory = static_cast<const ClBuffer*>(*buffer)->memory.get();
      set(sizeof memory, &memory);
    } else if (const auto* i = std::get_if<std::int32_t>(&arg)) {
      set(sizeof *i, i);
    } else if (const auto* f = std::get_if<float>(&arg)) {
      set(sizeof *f, f);
    } else {
      set(sizeof(double), &std::get<double>(arg));
    }
  }

  Program build(const std::string& source) {
    // Processes that fill one cache folder together can get a false failure: it is tried twice.
    for (int attempt = 0;; ++attempt) {
      const char* text = source.c_str();
      const std::size_t length = source.size();
      cl_int code;
      Program program(table(context_).clCreateProgramWithSource(context_, 1, &text, &length, &code));
      check(code, "clCreateProgramWithSource");
      code = table(context_).clBuildProgram(program.get(), 1, &device_, "-cl-std=CL1.2", nullptr, nullptr);
      if (code == CL_SUCCESS) {
        ++builds_;
        return program;
      }
      if (code == CL_BUILD_PROGRAM_FAILURE && attempt == 0) continue;
      std::string log;
      std::size_t size = 0;
      if (table(context_).clGetProgramBuildInfo(program.get(), device_, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size) == CL_SUCCESS && size > 1) {
        log.resize(size);
        table(context_).clGetProgramBuildInfo(program.get(), device_, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
        log.resize(size - 1);
      }
      throw BuildError(fmt::format("{} ({}) refused the kernel with error {}.{}\nIts log:\n{}\nThe source:\n{}", info_.name, info_.driver, code,
                                   log.empty() ? " An empty log can mean that the driver's cache folder is unwritable or full "
                                                 "(POCL_CACHE_DIR chooses another)."
                                               : "",
                                   log, numbered(source)));
    }
  }
};

std::string text_of(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  check(table(device).clGetDeviceInfo(device, what, 0, nullptr, &size), "clGetDeviceInfo");
  std::string text(size, '\0');
  check(table(device).clGetDeviceInfo(device, what, size, text.data(), nullptr), "clGetDeviceInfo");
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

}  // namespace

std::shared_ptr<Device> load(const std::string& path, const std::string& driver, int width) {
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw DeviceError(fmt::format("the OpenCL driver {} cannot be loaded: {}", path, dlerror()));
  using Address = void* (*)(const char*);
  using Platforms = cl_int (*)(cl_uint, cl_platform_id*, cl_uint*);
  const auto address = reinterpret_cast<Address>(dlsym(library, "clGetExtensionFunctionAddress"));
  auto platforms_of = reinterpret_cast<Platforms>(dlsym(library, "clIcdGetPlatformIDsKHR"));
  if (!platforms_of && address) platforms_of = reinterpret_cast<Platforms>(address("clIcdGetPlatformIDsKHR"));
  if (!platforms_of) throw DeviceError(fmt::format("{} is not an OpenCL driver: it has no clIcdGetPlatformIDsKHR", path));
  cl_uint count = 0;
  if (platforms_of(0, nullptr, &count) != CL_SUCCESS || count == 0) throw DeviceError(fmt::format("the OpenCL driver {} has no platform", path));
  std::vector<cl_platform_id> platforms(count);
  check(platforms_of(count, platforms.data(), nullptr), "clIcdGetPlatformIDsKHR");
  for (const cl_device_type type : {cl_device_type{CL_DEVICE_TYPE_GPU}, cl_device_type{CL_DEVICE_TYPE_ALL}})
    for (cl_platform_id platform : platforms) {
      cl_device_id device;
      if (table(platform).clGetDeviceIDs(platform, type, 1, &device, nullptr) != CL_SUCCESS) continue;
      Info info;
      info.name = text_of(device, CL_DEVICE_NAME);
      info.version = text_of(device, CL_DRIVER_VERSION);
      info.driver = driver;
      cl_device_type kind = 0;
      table(device).clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof kind, &kind, nullptr);
      info.gpu = (kind & CL_DEVICE_TYPE_GPU) != 0;
      info.fp64 = text_of(device, CL_DEVICE_EXTENSIONS).find("cl_khr_fp64") != std::string::npos;
      info.width = info.gpu ? 1 : width;
      return std::make_shared<ClDevice>(device, std::move(info));
    }
  throw DeviceError(fmt::format("the OpenCL driver {} has no device", path));
}

}  // namespace irt::device
