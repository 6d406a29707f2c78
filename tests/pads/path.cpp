// Contracts of ray_camera.cl, path.cl, enclosure_affine.cl, results.cl and beams.cl: where on the true ray the units of a path lie, how far computed
// coordinates are off, what is reported of them, and that a beam's error holds all its rays.
#define IRT_AFFINE 1
#include "along.h"

namespace {
// Coordinates of the true ray lie within e of p + s d.
CONTRACT(ray_camera) {
  Told told(rng);
  const double scale = told.radius * rng.size(-4, 4);
  told.set(0, rng.sign() * scale * rng.size(-3, 1), rng);
  told.set(3, rng.sign() * rng.size(-3, 1), rng);
  told.set(6, 1, rng);
  if (rng.chance(0.5)) told.set_pad(scale * rng.size(-30, -15), rng);
  const RAY ray = told.ray();
  const exact s = told.radius * rng.part();
  return at_most(magnitude(of(ray.px) + s * of(ray.dx) - told.coordinate_at(0, s)), of(ray.ex));
}

// A path, a place on it, and bounds that it lies in, near a face.
struct Walk {
  Told told;
  RANGE range;
  RAY ray;
  PATH path;
  double c;  // units

  // `all` of the path lies inside, or the place alone.
  Walk(bool all, Random& rng) : told(rng), range(some_range(told.radius, rng)) {
    const double scale = told.radius * (rng.chance(0.5) ? 1 : rng.size(-3, 3));
    told.set(0, rng.chance(0.2) ? 0 : rng.sign() * scale * rng.size(-3, 1), rng);
    told.set(3, rng.chance(0.2) ? rng.sign() * std::exp2(-rng.between(4, 20)) : rng.sign() * rng.size(-3, 1), rng);
    told.set(6, 1, rng);
    if (rng.chance(0.4)) told.set_pad(scale * rng.size(-26, -15), rng);
    ray = told.ray();
    path = make_path(&ray, &range, told.q);
    c = some_unit(rng);
    exact there = magnitude(told.coordinate_at(0, place(path, c)));
    if (all) there = most(magnitude(told.coordinate_at(0, place(path, 0))), magnitude(told.coordinate_at(0, place(path, kEnd))));
    told.q[3] = std::nextafter(rounded(static_cast<double>(there)), real(INFINITY));
    told.q[0] = rng.chance(0.5) ? -told.q[3] : 0;
    path = make_path(&ray, &range, told.q);
  }
};

// The coordinate after c units, inside the bounds, lies within e of the true one.
CONTRACT(position) {
  const Walk w(false, rng);
  const double c = w.c - (w.c > 0 && rng.chance(0.3) ? 0.5 : 0);
  const exact there = w.told.coordinate_at(0, place(w.path, c));
  return magnitude(there) > w.told.q[3] || at_most(magnitude(of(ALONG((&w.path), x, c)) - there), of(w.path.ex));
}

// x + y e +- z holds the true coordinates of a piece.
bool holds(const Walk& w, const RA& form, double from, double to) {
  for (int end = -1; end <= 1; ++end) {
    const exact there = w.told.coordinate_at(0, place(w.path, (exact(from) + to + end * (exact(to) - from)) / 2));
    if (!at_most(magnitude(of(form.x) + end * of(form.y) - there), of(form.z))) return false;
  }
  return true;
}

double some_start(double c, Random& rng) { return rng.chance(0.4) ? 0 : std::floor(c * (1 - std::exp2(-rng.between(0, 20)))); }

CONTRACT(enclose) {
  const Walk w(true, rng);
  const double from = some_start(w.c, rng);
  I undefined, rough;
  enclose(&w.path, from, w.c, &undefined, &rough);
  return holds(w, asked[0], from, w.c);
}

CONTRACT(enclose_bare) {
  const Walk w(true, rng);
  const double from = some_start(w.c, rng);
  enclose_bare(&w.path, from, w.c);
  return holds(w, asked[0], from, w.c);
}

// Of a coordinate whose error is small beside its slope, the rounding of the slope is in the form.
CONTRACT(coordinate) {
  const F span = rounded(rng.size(0, 20)), u = rounded(rng.size(-40, 5)), slope = span * u, e = rng.chance(0.3) ? F(0) : F(rounded(rng.between(0, 1))) * slope;
  const RA x = coordinate((F)0, slope, e);
  return at_most(of(e) + magnitude(of(span) * of(u) - of(slope)), of(x.z));
}

// The slope of what lies within e of o + c u at either end of the path, u known to half an ulp.
CONTRACT(direction) {
  const F u = rounded(rng.sign() * rng.size(-40, 5)), e = rng.chance(0.3) ? F(0) : F(rounded(std::fabs(double(u.v)) * kEnd * rng.size(-30, 5)));
  const exact lost = of(u) * exact(ULP) / 4 * rng.part();
  const RA d = direction(u, e);
  return of(d.y) == 0 && at_most(magnitude((of(u) + lost) * kEnd + 2 * of(e) * rng.part() - of(d.x)), of(d.z));
}

// No end of the path lies before out1.
CONTRACT(path_end) {
  Told told(rng);
  const RAY ray = told.ray();
  const RANGE range = some_range(told.radius, rng);
  const PATH path = make_path(&ray, &range, told.q);
  return at_most(of(range.out1), place(path, kEnd));
}

// Units of [in0, in1] lie in the range where everything counts.
CONTRACT(inner_units) {
  Told told(rng);
  const RAY ray = told.ray();
  RANGE range = some_range(told.radius, rng);
  const double a = range.out0.v, b = range.out1.v;
  range.in0 = rounded(a + (b - a) * (rng.chance(0.5) ? std::exp2(-rng.between(1, 30)) : rng.unit()));
  range.in1 = rounded(b - (b - a) * (rng.chance(0.5) ? std::exp2(-rng.between(1, 30)) : rng.unit()));
  const PATH path = make_path(&ray, &range, told.q);
  return !(of(path.in0) <= of(path.in1)) || (at_most(of(range.in0), place(path, of(path.in0))) && at_most(place(path, of(path.in1)), of(range.in1)));
}

// The rays of a beam, b + (tau + s) w apart, lie within the error that a path has until c units. On this axis the middle ray is zero.
CONTRACT(beam) {
  Told told(rng);
  RAY ray;
  told.set(6, 1, rng);
  told.terms[1][7] = rng.chance(0.3) ? told.radius * rng.between(-1, 1) : told.radius * rng.size(0, 10);
  ray = told.ray();
  ray.bx = rng.chance(0.5) ? F(0) : F(rounded(told.radius * rng.size(-20, 3))), ray.wx = rng.chance(0.3) ? F(0) : F(rounded(rng.size(-20, 3)));
  RANGE range = some_range(told.radius, rng);
  if (rng.chance(0.4)) range.out0 = rounded(std::fmin(range.out1.v, std::fmax(-told.radius, -told.terms[1][7] * (1 + rng.sign() * std::exp2(-rng.between(8, 50))))));
  const PATH path = make_path(&ray, &range, told.q);
  const double c = rng.chance(0.4) ? 0 : some_unit(rng);
  const exact wide_there = of(ray.bx) + most(exact(told.terms[1][7]) + place(path, c), 0) * of(ray.wx);
  return at_most(wide_there, of(ERROR_UNTIL((&path), x, F(c))));
}

// A bracket as wide as wanted is told to be no wider than eps, where eps has room for the rounding of t.
CONTRACT(wanted_units) {
  Told told(rng);
  told.terms[1][6] = rng.size(0, 4);
  told.terms[1][7] = told.radius * (rng.chance(0.4) ? rng.between(-1, 1) : rng.size(0, 6));
  const double length = std::sqrt(told.terms[1][6]);
  if (rng.chance(0.3)) told.set_pad(told.radius * rng.size(-26, -15), rng);
  const double off = 2 * (double(REPORT_ERROR) * ULP * (std::fabs(told.terms[1][7]) + told.radius) * length + told.q[7]);
  told.q[8] = told.q[26] = rounded(off * rng.size(3.01, 20));
  const RAY ray = told.ray();
  RANGE range = some_range(told.radius, rng);
  if (rng.chance(0.6)) range.out0 = rounded(told.radius * (1 - rng.size(-12, -1))), range.out1 = rounded(told.radius);  // t is as large as it gets
  if (!(range.out0 < range.out1)) return true;
  const PATH path = make_path(&ray, &range, told.q);
  const F wanted = wanted_units(&ray, &path, told.q);
  const ROOT found = report(&path, told.q, HIT, 0, wanted);
  real depth, uncertainty;
  uchar status;
  write_results(&ray, &found, packet_at(0, 0, 1, 0), told.q, &depth, &uncertainty, &status);
  return wanted > F(kEnd) || at_most(2 * exact(uncertainty), told.q[8]);
}

// depth +- uncertainty holds every place of the bracket, t = (tau + s) |D| of the true ray.
CONTRACT(results) {
  Told told(rng);
  const RANGE range = some_range(told.radius, rng);
  RAY ray = told.ray();
  const PATH path = make_path(&ray, &range, told.q);
  double lo = some_unit(rng), hi = lo + (rng.chance(0.4) ? 0 : rng.chance(0.5) ? std::floor(rng.size(0, 20)) : rng.size(-2, 20));
  if (rng.chance(0.3)) lo = 0, hi = kEnd;
  if (hi > kEnd) hi = kEnd, lo = std::fmin(lo, hi);
  // The eye lies before the bounds, or inside, or in the middle of the bracket.
  told.set(6, rng.size(0, 4), rng);
  told.terms[1][7] = rng.chance(0.4) ? told.radius * rng.between(-1, 1) : rng.chance(0.3) ? static_cast<double>(-place(path, (lo + hi) / 2)) : told.radius * rng.size(0, 10);
  if (rng.chance(0.4)) told.set_pad(told.radius * rng.size(-26, -15), rng);
  ray = told.ray();
  const exact length = root_of(told.term(6));
  const F a = rounded(lo), b = rounded(hi);
  const ROOT found = report(&path, told.q, HIT, a, b);
  real depth, uncertainty;
  uchar status;
  write_results(&ray, &found, packet_at(0, 0, 1, 0), told.q, &depth, &uncertainty, &status);
  for (const F c : {a, b}) {
    const exact t = (exact(told.terms[1][7]) + place(path, of(c))) * length + told.host;
    if (t >= 0 && !at_most(magnitude(t - depth), uncertainty)) return false;
  }
  return true;
}

#if VARIANT == 0
// The same of depths in double, of roots that are refined (frustum_fine.cl); the half width has room for the rounding of a product.
namespace fine {
#undef IRT_FINE
#define IRT_FINE 1
#include "results.cl"
}  // namespace fine

CONTRACT(results_fine) {
  Told told(rng);
  told.set(6, rng.size(0, 4), rng);
  told.terms[1][7] = told.radius * (rng.chance(0.4) ? rng.between(-1, 1) : rng.sign() * rng.size(0, 10));
  if (rng.chance(0.4)) told.set_pad(told.radius * rng.size(-50, -15), rng);
  const RAY ray = told.ray();
  ROOT found;
  found.status = HIT;
  const double s = told.radius * rng.between(-1, 1);
  found.at = s;
  found.half_width = rounded(told.radius * rng.size(-60, 0));
  double depth, uncertainty;
  uchar status;
  fine::write_results(&ray, &found, fine::packet_at(0, 0, 1, 0), told.q, &depth, &uncertainty, &status);
  const exact length = root_of(told.term(6)), half = of(found.half_width) / (1 + exact(0x1p-22));
  for (const exact c : {exact(s) - half, exact(s) + half}) {
    const exact t = (exact(told.terms[1][7]) + c) * length + told.host;
    if (t >= 0 && !at_most(magnitude(t - depth), uncertainty)) return false;
  }
  // And no more than the rest of it.
  return at_most(uncertainty, (of(found.half_width) * length + exact(0x1p-50) * depth + told.q[7]) * (1 + exact(0x1.8p-22)));
}
#endif

// What `report` says of the units lo to hi, in s. What a sum of doubles loses, the ulp of t in results.cl has room for.
CONTRACT(report) {
  Told told(rng);
  const RAY ray = told.ray();
  const RANGE range = some_range(told.radius, rng);
  const PATH path = make_path(&ray, &range, told.q);
  const F lo = rounded(some_unit(rng) * 0.5), hi = lo + F(rounded(rng.chance(0.3) ? 1 : rng.chance(0.5) ? std::floor(rng.size(0, 20)) : rng.size(-2, 20)));
  const ROOT found = report(&path, told.q, HIT, lo, hi);
  for (const F c : {lo, hi})
    if (!at_most(magnitude(place(path, of(c)) - of(found.at)), of(found.half_width) + (IRT_SPLIT ? told.radius * exact(0x1p-52) : 0))) return false;
  // And of whole units hardly more: a part of what sharpen.cl takes off.
  return !IRT_SPLIT || std::floor(hi.v) != hi.v || at_most(of(found.half_width), (of(hi) - of(lo)) / 2 * of(path.unit) * (1 + exact(0x1.4p-21)));
}

// A beam is clipped by what its rays are apart at most, of the widths that the tables have. Its ray is given, clipping is looked at.
RAY given, clipped;
RAY given_ray(RAY_DECL, const real*, size_t, size_t) { return given; }
RANGE look_at(const RAY* ray, const real*) {
  clipped = *ray;
  return RANGE();
}
ROOT find_nothing(const RAY*, const RANGE*, const real*, const int FINDER) {
  ROOT root;
  root.status = MISS;
  return root;
}
#define make_ray given_ray
#define clip_ray look_at
#define find_root find_nothing
#define BEAM 1
#define BEAMS_ACROSS 1
#define BEAMS_DOWN 1
#define BEAM_PIECES 32
#include "beams.cl"
#undef make_ray

CONTRACT(beam_bounds) {
  Told told(rng);
  told.set(8, rng.chance(0.3) ? 0 : told.radius * rng.size(-20, 3), rng);
  for (int i = 0; i < 2; ++i) told.terms[i][8] = std::fabs(told.terms[i][8]);
  told.set(11, rng.chance(0.3) ? 0 : rng.size(-20, 3), rng);
  for (int i = 0; i < 2; ++i) told.terms[i][11] = std::fabs(told.terms[i][11]);
  const double tau = rng.chance(0.3) ? -told.radius * (1 - std::exp2(-rng.between(8, 40))) : told.radius * (rng.chance(0.5) ? rng.between(-1, 1) : rng.size(0, 10));
  given = told.ray();
  given.tau = tau;
  given.ex = rng.chance(0.5) ? F(0) : F(rounded(told.radius * rng.size(-26, -20)));
  real depth, uncertainty;
  uchar status;
  // The one packet of the tile is not made, as its beam misses.
  trace_tile(0, 0, told.tables[0], told.tables[1], 1, 1, told.q, 1, 1, &depth, &uncertainty, &status, 0);
  const exact b = exact(told.tables[0][8]) + exact(told.tables[1][8]), w = exact(told.tables[0][11]) + exact(told.tables[1][11]);
  return at_most(of(given.ex) + b + most(of(given.tau) + exact(told.radius), 0) * w, of(clipped.ex));
}
}  // namespace
