// The error types of the public API, by who is to blame: the input, the machine, or us.
// The bindings turn each into the Python exception of the same name (python/implicitrt/errors.py).
#pragma once

#include <stdexcept>
#include <string>

namespace irt {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A formula cannot be read or used; says where, what was found and what is allowed.
struct ExpressionError : Error {
  using Error::Error;
};

// A camera, bounds, size, eps, shape or parameter is missing, unknown, degenerate or not finite.
struct ArgumentError : Error {
  using Error::Error;
};

// A cap (caps.h) is exceeded; names the cap and the value.
struct LimitError : Error {
  using Error::Error;
};

// The method cannot draw this formula; says which can.
struct MethodError : Error {
  using Error::Error;
};

// No driver works, or one failed; names what was tried and what to install.
struct DeviceError : Error {
  using Error::Error;
};

// The driver's compiler refused a kernel: carries the numbered source and the build log.
struct BuildError : Error {
  using Error::Error;
};

}  // namespace irt
