// Roots of rays set up in double, narrowed down in double, and what was asked of f for that.
#pragma once

#include "along.h"

#if VARIANT == 0
namespace {
// f at s is its slope somewhere between s and the root, which is any of those that are told, times how far the root is; in double, and off by as much as is told or a
// part of that.
struct Line {
  exact root;
  real lo, hi, error;
  double share, part;
} line;

FW irt_fine(FW x, FW, FW) {
  const exact slope = exact(line.lo) + (exact(line.hi) - exact(line.lo)) * line.share;
  return static_cast<double>((of(x) - line.root) * slope + exact(line.error) * (1 - exact(0x1p-40)) * line.part);
}
F irt_fine_error(F, F, F, F) { return line.error; }
IA slopes_of(COORDINATE x, COORDINATE y, COORDINATE z, COORDINATE dx, COORDINATE dy, COORDINATE dz, I* undefined, I* rough) {
  irt_along(x, y, z, dx, dy, dz, undefined, rough);
  return ia(line.lo, line.hi);
}
#define irt_along slopes_of
#include "refine.cl"
#undef irt_along

// A bracket on a ray; coordinates that nearly vanish are where doubles err most for their size.
struct Bracket {
  Told told;
  ROOT root;
  RAY ray;

  explicit Bracket(Random& rng) : told(rng) {
    const double scale = told.radius * (rng.chance(0.5) ? 1 : rng.size(-3, 3));
    told.set(0, rng.chance(0.2) ? 0 : rng.sign() * scale * rng.size(-3, 1), rng);
    told.set(3, rng.sign() * rng.size(rng.chance(0.5) ? -3 : -30, 1), rng);
    told.set(6, 1, rng);
    if (rng.chance(0.5)) told.set_pad(scale * rng.size(-56, -20), rng);
    ray = told.ray();
    root.status = HIT;
    const double vanishing = static_cast<double>(-told.term(0) / told.term(3));
    root.at = rng.chance(0.5) && std::fabs(vanishing) < told.radius ? vanishing : told.radius * rng.between(-1, 1);
    root.half_width = rounded(told.radius * (rng.chance(0.5) ? rng.size(-70, -40) : rng.size(-30, -1)));
    line = {of(root.at), 1, 1, rounded(told.radius), 0, 0};  // no second step
  }
};

// What is asked of the slopes holds all of the bracket, and the direction of the true ray.
bool asks_for_all(Random& rng) {
  Bracket b(rng);
  const exact at = of(b.root.at), known = of(b.root.half_width), way = b.told.term(3) + b.told.host / exact(b.told.radius);
  b.told.q[8] = 0;
  refine(&b.ray, &b.root, b.told.q);
  for (int end = -1; end <= 1; ++end) {
    const exact there = b.told.coordinate_at(0, at + end * known);
#if IRT_AFFINE
    if (!at_most(magnitude(of(asked[0].x) + end * of(asked[0].y) - there), of(asked[0].z))) return false;
  }
  return at_most(magnitude(of(directions[0].x) - way), of(directions[0].z));
#else
    if (!at_most(of(asked[0].lo), there) || !at_most(there, of(asked[0].hi))) return false;
  }
  return at_most(of(directions[0].lo), way) && at_most(way, of(directions[0].hi));
#endif
}
}  // namespace
#endif
