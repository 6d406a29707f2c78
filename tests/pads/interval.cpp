// Contracts of enclosure_interval.cl, ray_list.cl, sharpen.cl and closed_form.cl: coordinates as intervals, and the part of a ray in which the first pass
// has proven a root.
#define IRT_AFFINE 0
#include "along.h"

namespace {
// A path of a list's ray, all of it inside the bounds and near a face of them, and a piece of it.
struct Walk {
  Told told;
  PATH path;
  double from, to;

  explicit Walk(Random& rng) : told(rng), to(some_unit(rng)) {
    const double scale = told.radius * (rng.chance(0.5) ? 1 : rng.size(-3, 3));
    told.set(0, rng.chance(0.2) ? 0 : rng.sign() * scale * rng.size(-3, 1), rng);
    told.set(3, rng.chance(0.2) ? rng.sign() * std::exp2(-rng.between(4, 20)) : rng.sign() * rng.size(-3, 1), rng);
    if (rng.chance(0.4)) told.set_pad(scale * rng.size(-26, -15), rng);
    const RAY ray = told.ray();
    const RANGE range = some_range(told.radius, rng);
    path = make_path(&ray, &range, told.q);
    const exact there = most(magnitude(told.coordinate_at(0, place(path, 0))), magnitude(told.coordinate_at(0, place(path, kEnd))));
    told.q[3] = std::nextafter(rounded(static_cast<double>(there)), real(INFINITY));
    told.q[0] = rng.chance(0.5) ? -told.q[3] : 0;
    path = make_path(&ray, &range, told.q);
    from = rng.chance(0.4) ? to : std::floor(to * (1 - std::exp2(-rng.between(0, 20))));
  }

  bool holds(const IA& x) const {
    for (const double c : {from, to}) {
      const exact there = told.coordinate_at(0, place(path, c));
      if (!at_most(of(x.lo), there) || !at_most(there, of(x.hi))) return false;
    }
    return true;
  }
};

CONTRACT(interval) {
  const Walk w(rng);
  I undefined, rough;
  enclose(&w.path, w.from, w.to, &undefined, &rough);
  return w.holds(asked[0]);
}

CONTRACT(interval_bare) {
  const Walk w(rng);
  enclose_bare(&w.path, w.from, w.to);
  return w.holds(asked[0]);
}

// The slope of what lies within e of o + c u at either end of the path, u known to half an ulp.
CONTRACT(interval_direction) {
  const F u = rounded(rng.sign() * rng.size(-40, 5)), e = rng.chance(0.3) ? F(0) : F(rounded(std::fabs(double(u.v)) * kEnd * rng.size(-30, 5)));
  const exact lost = of(u) * exact(ULP) / 4 * rng.part(), slope = (of(u) + lost) * kEnd + 2 * of(e) * (1 - 16 * exact(ULP)) * rng.part();
  const IA d = direction(u, e);
  return at_most(of(d.lo), slope) && at_most(slope, of(d.hi));
}

#if IRT_DOUBLE
// The second pass, in double, begins with what the first has proven of t: [near, far] holds it, and none of what counts lies outside.
RAY given;
RANGE looked_at;
RAY given_ray(RAY_DECL, const real*, size_t, size_t) { return given; }
ROOT look_at(const RAY*, const RANGE* range, const real*, const int FINDER) {
  looked_at = *range;
  ROOT root;
  root.status = MISS;
  root.at = root.half_width = (F)0;
  return root;
}
#define make_ray given_ray
#define find_root look_at
#include "sharpen.cl"
#undef make_ray

CONTRACT(sharpen) {
  Told told(rng);
  if (rng.chance(0.4)) told.set_pad(told.radius * rng.size(-50, -15), rng);
  given = told.ray();
  const double before = rng.chance(0.4) ? told.radius * rng.between(-1, 1) : told.radius * rng.size(0, 10);
  given.tau = before;
  const double square = rng.size(0, 4);
  given.length = careful_sqrt(square);
  given.near_out = given.near_in = -INF;
  const exact length = root_of(square);
  const double s = told.radius * rng.between(-1, 1);
  // The bracket s +- half, and the least and the most that is said of it: contracts `report` and `results_fine`.
  const exact half = told.radius * rng.size(-26, -2), wide = half * length;
  real depth = ((F(before) + F(s)) * careful_sqrt(square)).v;
  if (depth < 0) return true;
  const exact off = magnitude(exact(depth) - (exact(before) + s) * length), least = wide + off, most = (wide + 0x1p-50 * exact(depth) + told.q[7]) * (1 + exact(0x1p-20));
  const auto error = static_cast<float>(least + (most - least) * (rng.chance(0.5) ? rng.between(0, 1) : rng.chance(0.5)));
  real uncertainty = error;
  uchar status = 1;
  if (!at_most(least, error) || !at_most(error, most)) return true;
  sharpen_packet(0, 0, told.tables[0], 1, told.q, 1, 1, &depth, &uncertainty, &status, 0);
  const exact low = s - half, high = s + half;
  return at_most(of(looked_at.out0), low) && at_most(high, of(looked_at.out1)) && at_most(low, of(looked_at.in0)) && at_most(of(looked_at.in1), high);
}
#endif

#define TERMS 5
#include "closed_form.cl"

// The place that a closed form reports, at e of a piece round its middle.
CONTRACT(closed_root) {
  const F middle = rounded(rng.sign() * rng.size(-20, 2)), reach = rounded(rng.size(-10, 2)), e = rounded(rng.between(-1, 1));
  RANGE range;
  range.out0 = range.in0 = -INF;
  range.out1 = range.in1 = INF;
  const ROOT found = closed_root(&range, middle, reach, e, ALL, NONE, NONE);
  return at_most(magnitude(of(middle) + of(reach) * of(e) - of(found.at)), of(found.half_width));
}
}  // namespace
