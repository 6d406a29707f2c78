// Anti-aliasing: means over samples within a pixel, everywhere or only next to silhouettes (S2 section 4.4).
//
// Deviation from S2, which seeks the silhouette between two pixels by Newton's method on the polynomial and blends the two
// colours: samples need no polynomial, and find corners, thin parts and the rims of clip regions too.
#include <algorithm>
#include <array>
#include <cmath>

#include "render/passes.h"

namespace irt::render {
namespace {

// Linear light for each sRGB byte.
const std::array<float, 256>& linear_light() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double c = static_cast<double>(i) / 255;
      t[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return t;
  }();
  return table;
}

// Light times alpha, and alpha, summed over samples.
struct Sum {
  std::array<float, 3> light{};
  float alpha = 0;

  void add(std::uint32_t pixel) {
    const float a = static_cast<float>(pixel >> 24) / 255;
    alpha += a;
    for (int k = 0; k < 3; ++k) light[k] += a * linear_light()[(pixel >> (8 * k)) & 255];
  }

  std::uint32_t mean(std::size_t samples) const {
    if (alpha == 0) return 0;
    return pixel_of({light[0] / alpha, light[1] / alpha, light[2] / alpha, alpha / static_cast<float>(samples)});
  }
};

}  // namespace

std::vector<std::size_t> silhouettes(const Answer& answer, const View& view) {
  std::vector<unsigned char> next(answer.pitch * answer.rows, 0);
  const auto* status = answer.status->as<unsigned char>();
  // How far apart neighbouring rays are, per unit of depth (perspective) or everywhere.
  const double apart = 2 * (view.perspective ? view.tan_half_fov : 0.5 * view.height) / view.rows;
  const auto compare = [&](std::size_t i, std::size_t j) {
    const auto kind = [](unsigned char s) { return s == 2 ? 1 : s; };  // HIT and TOUCH are surface
    bool differ = kind(status[i]) != kind(status[j]);
    if (!differ && kind(status[i]) == 1) {
      const double a = answer.depth_at(i), b = answer.depth_at(j);
      differ = std::fabs(a - b) > kernel::kJump * apart * (view.perspective ? std::min(a, b) : 1);
    }
    if (differ) next[i] = next[j] = 1;
  };
  for (std::size_t row = 0; row < answer.rows; ++row)
    for (std::size_t column = 0; column < answer.columns; ++column) {
      const std::size_t i = row * answer.pitch + column;
      const bool right = column + 1 < answer.columns, below = row + 1 < answer.rows;
      if (right) compare(i, i + 1);
      if (below) compare(i, i + answer.pitch);
      if (below && right) compare(i, i + answer.pitch + 1);
      if (below && column > 0) compare(i, i + answer.pitch - 1);
    }
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < next.size(); ++i)
    if (next[i]) pixels.push_back(i);
  return pixels;
}

void antialias(Answer& answer, const Finder& find, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds,
               const Options& options, device::Device& device) {
  widen(answer);
  std::vector<std::size_t> pixels;
  if (!options.everywhere) {
    pixels = silhouettes(answer, view);
    if (pixels.empty()) return;
  }
  const int n = options.samples;
  const auto passes = static_cast<double>(n * n);
  Options colours = options;
  colours.normal = colours.pieces = false;
  if (options.by_frustum() && !options.everywhere) colours.finder = "contract";  // frustum forms have no lists of pixels
  std::vector<Sum> sums(options.everywhere ? answer.pitch * answer.rows : pixels.size());
  for (int k = 0; k < n * n; ++k) {
    View shifted = view;
    shifted.right_by = (k % n + 0.5) / n - 0.5;
    shifted.down_by = (k / n + 0.5) / n - 0.5;
    if (options.control.progress)
      colours.control.progress = [&, k](double done) { options.control.progress((k + done) / passes); };
    const Answer part = options.everywhere ? shaded(find, program, shifted, bounds, colours, device)
                                           : camera_passes(program, formulas, shifted, bounds, colours, device, &pixels, answer.pitch);
    answer.add_work_of(part);
    answer.outcome = part.outcome;
    if (part.outcome != device::Outcome::done) return;  // the colours of the pixels' centres stay
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i].add(part.rgba->as<std::uint32_t>()[i]);
  }
  const auto samples = static_cast<std::size_t>(n * n);
  for (std::size_t i = 0; i < sums.size(); ++i)
    answer.rgba->as<std::uint32_t>()[options.everywhere ? i : pixels[i]] = sums[i].mean(samples);
}

}  // namespace irt::render
