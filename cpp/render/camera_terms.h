// Rays of a camera as terms per column and per row, in long double (kernels/ray_camera.cl), and the beams round them (kernels/beams.cl).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "kernel/assemble.h"
#include "render/reals.h"

namespace irt::render {

// By what part of what they are made of Camera.rays and the basis of a view may be off: about a double's precision.
constexpr long double kRounding = 4e-16L;

// Rays of `view` relative to the plane through the middle of the bounds.
class CameraTerms {
  using vec = glm::vec<3, long double>;
  static constexpr int kTerms = 8, kBeamTerms = 14;  // P, D, share of |D|^2, tau; of beams also how wide they are

  // What a lane stands for: one line of pixels, or the lines between two of them.
  using Lanes = std::vector<std::pair<int, int>>;

  // Lanes past the last line repeat it.
  static Lanes side_by_side(int count, int whole) {
    Lanes lanes;
    for (int i = 0; i < (count + whole - 1) / whole * whole; ++i) lanes.emplace_back(std::min(i, count - 1), std::min(i, count - 1));
    return lanes;
  }

  // Tiles of `beams` beams in this direction, and packets of `size` lines: for each tile the lanes of the packet of beams, then those of
  // its packets. `index` gives the line, in this direction, of a lane of a packet or of a packet of beams.
  template <class Index>
  static Lanes tiled(int count, int lanes_of_packet, int beams, int size, const Index& index) {
    constexpr int kBeam = kernel::kBeam;
    const auto line = [&](int i) { return std::min(i, count - 1); };
    Lanes lanes;
    for (int first = 0; first < count; first += beams * kBeam) {
      for (int lane = 0; lane < lanes_of_packet; ++lane) {
        const int beam = first + kBeam * index(lane, true);
        lanes.emplace_back(line(beam), line(beam + kBeam - 1));
      }
      for (int packet = 0; packet < beams * kBeam; packet += size)
        for (int lane = 0; lane < lanes_of_packet; ++lane) {
          const int at = line(first + packet + index(lane, false));
          lanes.emplace_back(at, at);
        }
    }
    return lanes;
  }

 public:
  // Columns in whole `across`, rows in whole `down`.
  CameraTerms(const View& view, const Bounds& bounds, program::Precision wide, int across, int down = 1)
      : CameraTerms(view, bounds, wide, side_by_side(view.columns, across), side_by_side(view.rows, down), kTerms) {}

  // Packets in tiles, with their beams.
  CameraTerms(const View& view, const Bounds& bounds, program::Precision wide, const kernel::Shape& packet, const kernel::Tiling& tiling)
      : CameraTerms(view, bounds, wide,
                    tiled(view.columns, packet.lanes(), tiling.beams_across, packet.width,
                          [&](int lane, bool beam) { return beam ? lane % tiling.beams_across : lane % packet.width; }),
                    tiled(view.rows, packet.lanes(), tiling.beams_down, packet.height,
                          [&](int lane, bool beam) { return beam ? lane / tiling.beams_across : lane / packet.width; }),
                    kBeamTerms) {}

 private:
  CameraTerms(const View& view, const Bounds& bounds, program::Precision wide, const Lanes& column_lanes, const Lanes& row_lanes, int terms)
      : column_stride(column_lanes.size()), row_stride(row_lanes.size()), columns(wide, terms * column_stride), rows(wide, terms * row_stride) {
    const vec origin(view.origin), right(view.right), up(view.up), forward(view.forward);
    const long double distance = glm::dot(vec(bounds.center()) - origin, forward);
    tau = static_cast<double>(distance);
    const long double half = view.perspective ? view.tan_half_fov : 0.5 * view.height;
    const long double aspect = static_cast<long double>(view.columns) / view.rows;
    const long double across = 2 * half * aspect / view.columns, down = -2 * half / view.rows;
    const vec middle = origin + distance * forward;
    const long double spread = view.perspective ? distance : 1;
    long double widest = 0;
    // A beam's share of how wide it is: b in orthographic views, w in perspective.
    const auto widen = [&](Reals& table, std::size_t stride, std::size_t i, const std::pair<int, int>& lane, long double slope, const vec& axis) {
      const long double by = 0.5L * (lane.second - lane.first) * std::fabs(slope);
      for (int k = 0; k < 3; ++k) {
        table.set_above((8 + k) * stride + i, view.perspective ? 0 : static_cast<double>(by * std::fabs(axis[k])));
        table.set_above((11 + k) * stride + i, view.perspective ? static_cast<double>(by * std::fabs(axis[k])) : 0);
      }
    };
    for (std::size_t i = 0; i < column_stride; ++i) {
      const long double column = 0.5L * (column_lanes[i].first + column_lanes[i].second);
      const long double sx = (2 * (column + 0.5L + view.right_by) / view.columns - 1) * half * aspect;
      const vec p = spread * sx * right, d = view.perspective ? sx * right : vec(0);
      for (int k = 0; k < 3; ++k) {
        columns.set(k * column_stride + i, static_cast<double>(p[k]));
        columns.set((3 + k) * column_stride + i, static_cast<double>(d[k]));
      }
      columns.set(6 * column_stride + i, view.perspective ? static_cast<double>(sx * sx) : 0);
      if (terms == kBeamTerms) widen(columns, column_stride, i, column_lanes[i], across, right);
      widest = std::max(widest, std::fabs(sx));
    }
    for (std::size_t row = 0; row < row_stride; ++row) {
      const long double line = 0.5L * (row_lanes[row].first + row_lanes[row].second);
      const long double sy = (1 - 2 * (line + 0.5L + view.down_by) / view.rows) * half;
      const vec p = middle + spread * sy * up, d = view.perspective ? forward + sy * up : forward;
      for (int k = 0; k < 3; ++k) {
        rows.set(k * row_stride + row, static_cast<double>(p[k]));
        rows.set((3 + k) * row_stride + row, static_cast<double>(d[k]));
      }
      rows.set(6 * row_stride + row, view.perspective ? static_cast<double>(1 + sy * sy) : 1);
      rows.set(7 * row_stride + row, tau);
      if (terms == kBeamTerms) widen(rows, row_stride, row, row_lanes[row], down, up);
      widest = std::max(widest, std::fabs(sy));
    }
    for (int k = 0; k < 3; ++k) {
      steps[k] = static_cast<double>(spread * across * right[k]);
      steps[3 + k] = view.perspective ? static_cast<double>(across * right[k]) : 0;
      steps[6 + k] = static_cast<double>(spread * down * up[k]);
      steps[9 + k] = view.perspective ? static_cast<double>(down * up[k]) : 0;
    }
    pad = static_cast<double>(kRounding * (glm::length(origin) + std::fabs(distance) * (1 + 2 * widest) + 2 * widest));
  }

 public:
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
