// Calls through a driver's dispatch table: every OpenCL object begins with a pointer to it.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl.h>
#include <CL/cl_icd.h>

#include <fmt/format.h>

#include <string>
#include <utility>

#include "error.h"

namespace irt::device {

template <class Object>
const cl_icd_dispatch& table(Object object) {
  return **reinterpret_cast<cl_icd_dispatch* const*>(object);
}

inline void check(cl_int code, const char* call) {
  if (code == CL_SUCCESS) return;
  const char* hint = code == CL_OUT_OF_HOST_MEMORY || code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_RESOURCES
                         ? "; the device has too little memory: ask for a smaller frame"
                     : code == CL_INVALID_PROGRAM ? "; the driver's cache folder may be unwritable or full (POCL_CACHE_DIR)"
                                                  : "";
  throw DeviceError(fmt::format("the OpenCL driver failed: {} returned {}{}", call, code, hint));
}

// An OpenCL object and the call that releases it.
template <class Object, auto Release>
class Owned {
 public:
  Owned() = default;
  explicit Owned(Object object) : object_(object) {}
  Owned(Owned&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Owned() {
    if (object_) (table(object_).*Release)(object_);
  }
  Object get() const { return object_; }

 private:
  Object object_ = nullptr;
};

using Program = Owned<cl_program, &cl_icd_dispatch::clReleaseProgram>;
using KernelObject = Owned<cl_kernel, &cl_icd_dispatch::clReleaseKernel>;
using Memory = Owned<cl_mem, &cl_icd_dispatch::clReleaseMemObject>;
using Queue = Owned<cl_command_queue, &cl_icd_dispatch::clReleaseCommandQueue>;

}  // namespace irt::device
