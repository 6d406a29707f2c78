// The kernel files that evaluate f along a ray of a camera, with beams, by affine forms or by intervals (IRT_AFFINE), round a formula that the sample chooses:
// it returns `answer`, and keeps what coordinates it was given.
#pragma once

#include "kernel_host.h"

#define IRT_BEAMS IRT_AFFINE
#define IRT_LEAD R(4.0)
#define IRT_SLACK 1
#define IRT_ALONG 1
#define IRT_GRADIENT_FOUND 0
#define IRT_SPHERES 0
#define IRT_HALF_SPACES 0
#define FORM_IS_RANGE (!IRT_AFFINE)
#define FORM_HAS_RANGE FORM_IS_RANGE
#if IRT_BEAMS
#define FINDER , HEAD *head, const int beam
#define FINDER_PASS , &head, beam
#else
#define FINDER
#define FINDER_PASS
#endif

namespace {
#include "packet.cl"
#include "interval.cl"
#include "affine.cl"
#if IRT_AFFINE
typedef RA FORM;
#define COORDINATE RA
#else
typedef IA FORM;
#define COORDINATE IA
#endif
FORM answer;
COORDINATE asked[3], directions[3];
IA slopes;
F slack;

FORM formula(COORDINATE x, COORDINATE y, COORDINATE z, I* undefined, I* rough) {
  asked[0] = x, asked[1] = y, asked[2] = z;
  *undefined = *rough = NONE;
  return answer;
}
IA irt_along(COORDINATE x, COORDINATE y, COORDINATE z, COORDINATE dx, COORDINATE dy, COORDINATE dz, I* undefined, I* rough) {
  formula(x, y, z, undefined, rough);
  directions[0] = dx, directions[1] = dy, directions[2] = dz;
  return slopes;
}
F irt_slack(F, F, F) { return slack; }
#define irt_affine formula
#define irt_interval formula
#define bare_irt_affine formula
#define bare_irt_interval formula
typedef RA bare_RA;
typedef IA bare_IA;
typedef FORM bare_FORM;
#define bare_ra ra
#define bare_ia ia
#define bare_ra_rad ra_rad
#include "scene.cl"
#if IRT_AFFINE
#include "ray_camera.cl"
#else
#include "ray_list.cl"
#endif
#include "clip.cl"
#include "path.cl"
#include "candidate.cl"
#include "form.cl"
#if IRT_AFFINE
#include "enclosure_affine.cl"
#else
#include "enclosure_interval.cl"
#endif
#include "isolate.cl"
#include "results.cl"

// A ray as the host tells it, and the true one: what is told is off by no more than POSITION_PAD.
struct Told {
  static constexpr int kTerms = 14;
  double radius, terms[2][kTerms] = {};  // of column and row, or all in the first
  wide tables[2][kTerms];
  real q[32] = {};
  exact host = 0;  // the error of the host's position

  explicit Told(Random& rng) : radius(rng.size(-6, 6)) { q[6] = rounded(radius), radius = q[6]; }
  // Position, direction along one axis; the same for all three where it does not matter.
  void set(int k, double v, Random& rng) {
    const double part = IRT_AFFINE ? (rng.chance(0.5) ? 0 : v * rng.between(-2, 2)) : 0;
    terms[1][k] = part, terms[0][k] = v - part;
  }
  void set_pad(double v, Random& rng) {
    q[7] = rounded(v);
    host = exact(q[7]) * (1 - 16 * exact(ULP)) * rng.part();  // sums with it round
  }
  RAY ray() {
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < kTerms; ++k) tables[i][k] = static_cast<wide>(terms[i][k]);
#if IRT_AFFINE
    RAY r = make_ray(tables[0], tables[1], 1, 1, q, 0, 0);
    r.bx = r.by = r.bz = r.wx = r.wy = r.wz = (F)0;
#else
    RAY r = make_ray(tables[0], 1, q, 0, 0);
#endif
    return r;
  }
  exact term(int k) const { return exact(terms[0][k]) + exact(terms[1][k]); }
  exact coordinate_at(int axis, exact s) const { return term(axis) + s * term(3 + axis) + host; }
};

// A part of the ray.
RANGE some_range(double radius, Random& rng) {
  double a = radius * rng.between(-1, 1), b = radius * rng.between(-1, 1);
  if (rng.chance(0.5)) a = -radius * (1 - std::exp2(-rng.between(1, 40))), b = radius * (1 - std::exp2(-rng.between(1, 40)));
  RANGE range;
  range.out0 = range.in0 = rounded(std::fmin(a, b)), range.out1 = range.in1 = rounded(std::fmax(a, b));
  return range;
}

// s after c units.
exact place(const PATH& path, exact c) { return of(path.start) + c * of(path.unit); }

const double kEnd = static_cast<double>(long(1) << PATH_LEVELS);
// Whole units; often the first or the last.
double some_unit(Random& rng) { return rng.chance(0.4) ? kEnd : std::floor(kEnd * (rng.chance(0.5) ? std::exp2(-rng.between(0, 20)) : rng.unit())); }
}  // namespace
