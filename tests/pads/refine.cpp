// Contracts of refine.cl, by affine forms: what slopes are asked of, how far a coordinate in double is off, and that the root stays in its bracket.
#define IRT_AFFINE 1
#include "refine.h"

#if VARIANT == 0
namespace {
CONTRACT(slopes_by_forms) { return asks_for_all(rng); }

CONTRACT(place_error) {
  const Bracket b(rng);
  const FW x = fma(b.root.at, b.ray.wdx, b.ray.wpx);
  // The place is a rounded one, too.
  const exact place = of(b.root.at) + exact(b.told.radius) * exact(0x1p-53) * rng.part();
  return at_most(magnitude(of(x) - b.told.coordinate_at(0, place)), of(place_error(&b.ray, b.told.q)));
}

CONTRACT(refine) {
  if (!error_mode) error_mode = 1;
  Told told(rng);
  told.set(3, 1, rng);
  told.terms[0][3] = 1, told.terms[1][3] = 0;
  told.set(6, 1, rng);
  const RAY ray = told.ray();
  ROOT root;
  root.status = HIT;
  const double known = told.radius * rng.size(-20, -1);
  root.half_width = rounded(known);
  root.at = rng.chance(0.5) ? 0 : told.radius * rng.between(-0.5, 0.5);
  line.root = of(root.at) + of(root.half_width) * (rng.chance(0.3) ? rng.sign() : rng.between(-1, 1));
  const double steep = rng.size(-10, 10), least = steep * (rng.chance(0.5) ? 1 - rng.size(-24, -1) : rng.size(-24, -1));
  line.lo = rounded(least), line.hi = rounded(steep);
  if (rng.chance(0.5)) std::swap(line.lo, line.hi), line.lo = -line.lo, line.hi = -line.hi;
  line.share = rng.chance(0.7) ? rng.below(2) : rng.unit();
  told.q[8] = rounded(known * rng.size(-24, 24));
  // As much as f rises within eps, or little.
  line.error = rounded(least * told.q[8] * (rng.chance(0.5) ? 0.45 * rng.between(0.9, 1) : rng.size(-30, -2)));
  line.part = rng.part();
  if (rng.chance(0.5)) {  // an eps that is only just reached
    const exact slope = (exact(line.lo) + line.hi) / 2, blur = (exact(line.hi) - line.lo) / 2, value = of(irt_fine(root.at, 0, 0));
    const exact doubt = magnitude(value / slope) * blur + 3 * exact(ULP) * magnitude(value) + line.error;
    told.q[8] = rounded(double(doubt / (magnitude(slope) - blur) / 0.45 * (1 + rng.between(0, 8) * ULP)));
  }
  const ROOT before = root;
  refine(&ray, &root, told.q);
  // No piece that slopes are asked of has lost it.
  if (!at_most(magnitude(line.root - of(asked[0].x)), magnitude(of(asked[0].y)) + exact(ULP) / 2 * magnitude(of(asked[0].x)))) return false;
  if (root.half_width == before.half_width) return root.at == before.at;
  const F reach = (F)(R(0.45) * told.q[8]) / NARROW(ray.length);
  return at_most(of(reach) * (1 + exact(0x1p-23)), of(root.half_width)) &&  // room for the rounding of a product (results.cl)
         at_most(magnitude(of(root.at) - line.root), of(reach) + exact(0x1p-50) * told.radius);
}
}  // namespace
#endif
