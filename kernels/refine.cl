// Brackets of floats narrowed down by values in double: each holds the first root of its ray. Where f rises or falls all over it, a root r and the middle m have
// r - m = -f(m) / f'(c) for a c between them: interval Newton steps, whose slopes floats are good enough for. Only f(m) needs doubles.
//
// Not in the papers. It takes the place of a second pass in double (sharpen.cl) for formulas whose values in double have a bound of their error.
#define NARROWINGS 3

// Sizes of coordinates are larger than these by such a part of RADIUS: sizes are multiplied, and what coordinates are off by, far cameras by much, is a small part of them.
#define GRAIN R(0.0625)

// What a coordinate in double is off by: its two terms, the place, their product and sum are rounded, and the host has rounded as well.
static inline F place_error(const RAY* ray, __global const real* q) {
  return fma((F)R(0x1p-52), fma((F)(R(2.0) * RADIUS), NARROW(ray->length), fabs(ray->px) + fabs(ray->py) + fabs(ray->pz)), (F)POSITION_PAD);
}

// A coordinate within `reach` of a place, which was rounded to a float from what is off by `error`; and its change along the ray, which a 2 RADIUS long one errs by twice POSITION_PAD on.
#if IRT_AFFINE
static inline RA place_about(F place, F reach, F way, F error) {
  const F y = reach * way;
  return ra(place, y, fma((F)ULP, fabs(place) + fabs(y), error));
}

static inline RA way_about(F way, __global const real* q) { return ra(way, (F)0, fma((F)ULP, fabs(way), (F)(R(1.01) * POSITION_PAD / RADIUS))); }
#else
static inline IA place_about(F place, F reach, F way, F error) {
  const F r = fma(reach * (R(1.0) + R(2.0) * ULP), fabs(way), fma((F)(R(1.5) * ULP), fabs(place), error));
  return ia(place - r, place + r);
}

static inline IA way_about(F way, __global const real* q) {
  const F off = fma((F)(R(1.5) * ULP), fabs(way), (F)(R(1.01) * POSITION_PAD / RADIUS));
  return ia(way - off, way + off);
}
#endif

// Narrows HITs down to EPS where that can be proven; the others stay as they are, wide.
static inline void refine(const RAY* ray, ROOT* root, __global const real* q) {
  const F reach = (F)(R(0.45) * EPS) / NARROW(ray->length);  // half the width that is wanted, in s
  const F grain = (F)(GRAIN * RADIUS), off_by = place_error(ray, q), part = off_by * (F)(R(1.0) / (GRAIN * RADIUS));
  I left = EQ(root->status, HIT);
  FW at = root->at;
  F known = root->half_width;
  for (int k = 0; k < NARROWINGS && ANY(left); ++k) {
    const FW x = fma(at, ray->wdx, ray->wpx), y = fma(at, ray->wdy, ray->wpy), z = fma(at, ray->wdz, ray->wpz);
    const F px = NARROW(x), py = NARROW(y), pz = NARROW(z);
    I undefined, rough;
    const IA d = irt_along(place_about(px, known, ray->dx, off_by), place_about(py, known, ray->dy, off_by), place_about(pz, known, ray->dz, off_by),
                           way_about(ray->dx, q), way_about(ray->dy, q), way_about(ray->dz, q), &undefined, &rough);
    const F value = NARROW(irt_fine(x, y, z)), error = irt_fine_error(fabs(px) + grain, fabs(py) + grain, fabs(pz) + grain, part);
    // Slopes are within `blur` of this one, and the root within doubt / least of where it leads. Rounding of `value` and `off` is off by 3 ulp of their product with the
    // slope, that of the other steps and of the quotient below by 6.5.
    const F slope = R(0.5) * (d.lo + d.hi), off = -value / slope, blur = fma((F)(R(10.0) * ULP), fabs(slope), R(0.5) * (d.hi - d.lo));
    const F least = fabs(slope) - blur, doubt = fma(fabs(off), blur, error);
    const I steady = left & ~undefined & ~rough & GT(least, (F)0), good = steady & GT(least * reach, doubt);
    root->at = SELECT_WIDE(good, at + WIDEN(off), root->at);
    root->half_width = SELECT(good, reach * (R(1.0) + R(4.0) * ULP) + (F)(real)(0x1p-50 * RADIUS), root->half_width);
#if IRT_PIECES
    root->pieces -= left;
#endif
    const F narrower = doubt / least + (F)(real)(0x1p-50 * RADIUS);
    left = steady & ~good & LT(narrower, R(0.5) * known);
    at = SELECT_WIDE(left, at + WIDEN(off), at);
    known = narrower;
  }
}
