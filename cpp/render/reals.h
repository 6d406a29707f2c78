// Arrays of the kernel's reals, filled from the host's doubles.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "device/device.h"
#include "program/emit.h"
#include "render/call.h"

namespace irt::render {

inline std::size_t size_of(program::Precision p) { return p == program::Precision::Double ? 8 : 4; }

// The next real at or below (above) v.
inline float float_below(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafterf(f, -std::numeric_limits<float>::infinity()) : f;
}
inline float float_above(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

class Reals {
 public:
  // `rounding`: the precision to which set_below and set_above round, where it is another.
  Reals(program::Precision precision, std::size_t count, program::Precision rounding)
      : precision_(precision), rounding_(rounding), memory_(std::max<std::size_t>(count, 1) * size_of(precision)) {}

  Reals(program::Precision precision, std::size_t count) : Reals(precision, count, precision) {}

  void set(std::size_t i, double v) {
    if (precision_ == program::Precision::Double) {
      memory_.as<double>()[i] = v;
    } else {
      memory_.as<float>()[i] = static_cast<float>(v);
    }
  }
  void copy(std::size_t first, const double* from, std::size_t count) {
    if (precision_ == program::Precision::Double) {
      std::copy_n(from, count, memory_.as<double>() + first);
    } else {
      std::copy_n(from, count, memory_.as<float>() + first);
    }
  }
  // v known to about 1e-16 relative, rounded so that it stays on its side.
  void set_below(std::size_t i, double v) {
    v -= 4e-16 * std::fabs(v);
    set(i, rounding_ == program::Precision::Double ? v : static_cast<double>(float_below(v)));
  }
  void set_above(std::size_t i, double v) {
    v += 4e-16 * std::fabs(v);
    set(i, rounding_ == program::Precision::Double ? v : static_cast<double>(float_above(v)));
  }
  double get(std::size_t i) const {
    return precision_ == program::Precision::Double ? memory_.as<double>()[i] : static_cast<double>(memory_.as<float>()[i]);
  }
  std::unique_ptr<device::Buffer> buffer(device::Device& device, device::Access access = device::Access::read) const {
    return device.buffer(memory_.data(), memory_.bytes(), access);
  }

 private:
  program::Precision precision_, rounding_;
  Memory memory_;
};

}  // namespace irt::render
