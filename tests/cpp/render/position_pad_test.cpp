// POSITION_PAD: what the host's own rounding may add to a coordinate or to t, against exact rationals; and that it is not much more than that.
#include <gtest/gtest.h>
#include <gmpxx.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/camera_terms.h"
#include "render/ray_terms.h"

namespace irt::render {
namespace {

mpq_class exact(long double v) {
  const double high = static_cast<double>(v);
  return mpq_class(high) + mpq_class(static_cast<double>(v - high));
}

Bounds cube() { return {glm::dvec3(-1), glm::dvec3(1), {}, {}}; }

// Of rays that begin far away the point nearest the middle of the bounds is a small difference of large numbers.
TEST(PositionPad, OfRaysGivenOneByOne) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  double largest = 0;  // share of the pad that is needed
  for (int i = 0; i < 2000; ++i) {
    const double far = std::exp2(20 * std::fabs(any(random)));
    double o[3], d[3];
    for (int k = 0; k < 3; ++k) d[k] = any(random);
    for (int k = 0; k < 3; ++k) o[k] = -far * d[k] + 1e-3 * any(random);
    const double near = 0, end = std::numeric_limits<double>::infinity();
    const RayTerms terms = make_terms({o, d, &near, &end, 1}, nullptr, 1, 1, cube(), program::Precision::Double, false);
    for (int k = 0; k < 3; ++k) {
      const double told = terms.terms.get(k);
      const mpq_class truth = mpq_class(o[k]) + exact(terms.nearest[0]) * mpq_class(terms.terms.get(3 + k)), off = abs(truth - mpq_class(told));
      const double beyond = off.get_d() - 0x1p-53 * std::fabs(told);  // the rounding of the term itself is the kernel's to cover
      EXPECT_LE(beyond, terms.pad);
      largest = std::max(largest, beyond / terms.pad);
    }
  }
  EXPECT_GT(largest, 0.01);
}

// The basis of a camera is orthonormal to the precision of doubles: |D| is off by as much, and t with it.
TEST(PositionPad, OfCameras) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  double largest = 0;
  for (int i = 0; i < 2000; ++i) {
    View view;
    const double far = std::exp2(10 * std::fabs(any(random)));
    view.forward = glm::normalize(glm::dvec3(any(random), any(random), any(random)));
    view.right = glm::normalize(glm::cross(view.forward, glm::dvec3(0, 0, 1)));
    view.up = glm::cross(view.right, view.forward);
    view.origin = -far * view.forward;
    view.columns = view.rows = 2;
    const CameraTerms terms(view, cube(), program::Precision::Double, 1);
    mpq_class square = 0;
    for (int k = 0; k < 3; ++k) {
      const mpq_class d = mpq_class(terms.columns.get((3 + k) * terms.column_stride)) + mpq_class(terms.rows.get((3 + k) * terms.row_stride));
      square += d * d;
    }
    const mpq_class told = mpq_class(terms.columns.get(6 * terms.column_stride)) + mpq_class(terms.rows.get(6 * terms.row_stride));
    // sqrt(a) - sqrt(b) = (a - b) / (sqrt(a) + sqrt(b)), times what s may be.
    const double off = std::fabs(mpq_class(square - told).get_d()) / (2 * std::sqrt(told.get_d())) * (std::fabs(terms.tau) + std::sqrt(3.0));
    EXPECT_LE(off, terms.pad);
    largest = std::max(largest, off / terms.pad);
  }
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace irt::render
