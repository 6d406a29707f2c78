// Rays of a camera as terms per column and per row, in long double (kernels/ray_camera.cl).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "render/reals.h"

namespace irt::render {

// Rays of `view` relative to the plane through the middle of the bounds.
class CameraTerms {
  using vec = glm::vec<3, long double>;
  static constexpr int kTerms = 8;  // P, D, share of |D|^2, tau

 public:
  CameraTerms(const View& view, const Bounds& bounds, program::Precision wide, int width)
      : column_stride((view.columns + width - 1) / width * width),
        row_stride(view.rows),
        columns(wide, kTerms * column_stride),
        rows(wide, kTerms * row_stride) {
    const vec origin(view.origin), right(view.right), up(view.up), forward(view.forward);
    const long double distance = glm::dot(vec(bounds.center()) - origin, forward);
    tau = static_cast<double>(distance);
    const long double half = view.perspective ? view.tan_half_fov : 0.5 * view.height;
    const long double aspect = static_cast<long double>(view.columns) / view.rows;
    const vec middle = origin + distance * forward;
    const long double spread = view.perspective ? distance : 1;
    long double widest = 0;
    for (std::size_t i = 0; i < column_stride; ++i) {
      // Lanes past the last column repeat it.
      const std::size_t column = std::min<std::size_t>(i, view.columns - 1);
      const long double sx = (2 * (column + 0.5L + view.right_by) / view.columns - 1) * half * aspect;
      const vec p = spread * sx * right, d = view.perspective ? sx * right : vec(0);
      for (int k = 0; k < 3; ++k) {
        columns.set(k * column_stride + i, static_cast<double>(p[k]));
        columns.set((3 + k) * column_stride + i, static_cast<double>(d[k]));
      }
      columns.set(6 * column_stride + i, view.perspective ? static_cast<double>(sx * sx) : 0);
      widest = std::max(widest, std::fabs(sx));
    }
    for (std::size_t row = 0; row < row_stride; ++row) {
      const long double sy = (1 - 2 * (row + 0.5L + view.down_by) / view.rows) * half;
      const vec p = middle + spread * sy * up, d = view.perspective ? forward + sy * up : forward;
      for (int k = 0; k < 3; ++k) {
        rows.set(k * row_stride + row, static_cast<double>(p[k]));
        rows.set((3 + k) * row_stride + row, static_cast<double>(d[k]));
      }
      rows.set(6 * row_stride + row, view.perspective ? static_cast<double>(1 + sy * sy) : 1);
      rows.set(7 * row_stride + row, tau);
      widest = std::max(widest, std::fabs(sy));
    }
    const long double across = 2 * half * aspect / view.columns, down = -2 * half / view.rows;
    for (int k = 0; k < 3; ++k) {
      steps[k] = static_cast<double>(spread * across * right[k]);
      steps[3 + k] = view.perspective ? static_cast<double>(across * right[k]) : 0;
      steps[6 + k] = static_cast<double>(spread * down * up[k]);
      steps[9 + k] = view.perspective ? static_cast<double>(down * up[k]) : 0;
    }
    // The basis itself is known to about a double's precision.
    pad = static_cast<double>(4e-16L * (glm::length(origin) + std::fabs(distance) * (1 + 2 * widest) + 2 * widest));
  }

  std::size_t column_stride, row_stride;
  Reals columns, rows;
  double tau, pad;
  std::array<double, 12> steps{};  // what P and D gain from column to column and from row to row
};

// Columns and rows of the pixels of a list, lanes past the last repeating it.
inline Memory pixel_list(const std::vector<std::size_t>& pixels, std::size_t count, std::size_t pitch) {
  Memory list(2 * count * sizeof(std::int32_t));
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = pixels[std::min(k, pixels.size() - 1)];
    list.as<std::int32_t>()[2 * k] = static_cast<std::int32_t>(i % pitch);
    list.as<std::int32_t>()[2 * k + 1] = static_cast<std::int32_t>(i / pitch);
  }
  return list;
}

}  // namespace irt::render
