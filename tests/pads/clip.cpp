// Contracts of clip.cl and ray_list.cl. A ray's coordinate is p + s d to within e, for every |s| up to the radius; so clip finds, of all s that rays
// with such coordinates have inside the bounds, a range that holds them all (out0, out1), and one that every such ray has inside (in0, in1).
#include "kernel_host.h"

#define IRT_BEAMS 0
#define IRT_SLACK 0
#define IRT_GRADIENT_FOUND 0
#define IRT_SPHERES 1
#define IRT_HALF_SPACES 1

namespace {
#include "packet.cl"
#include "scene.cl"
#include "ray_list.cl"
#include "clip.cl"

RANGE everything() {
  RANGE range;
  range.out0 = range.in0 = -INF;
  range.out1 = range.in1 = INF;
  return range;
}

// What rays are off by at most, where the kernel has e: products with e round, and no error comes so near to its bound.
exact nearly(real e) { return exact(e) * (1 - 16 * exact(ULP)); }

// Whether all s of [low, high] are in [out0, out1].
bool held(const RANGE& range, exact low, exact high) { return low > high || (at_most(of(range.out0), low) && at_most(high, of(range.out1))); }

// The s of [in0, in1] that count, |s| <= radius; false where there are none.
bool inner(const RANGE& range, exact radius, exact* low, exact* high) {
  *low = most(of(range.in0), -radius);
  *high = least(of(range.in1), radius);
  return *low <= *high;
}

// low <= a + b s <= high, |s| <= radius, as an interval of s; empty: from 1 to -1.
void solve(exact a, exact b, exact low, exact high, exact radius, exact* from, exact* to) {
  *from = -radius;
  *to = radius;
  if (b == 0) {
    if (a < low || a > high) *from = 1, *to = -1;
    return;
  }
  const exact x = (low - a) / b, y = (high - a) / b;
  *from = most(*from, least(x, y));
  *to = least(*to, most(x, y));
}

// Slabs that are thick or thin, rays that are steep or nearly parallel, errors that are none, small or large.
CONTRACT(clip_axis) {
  const double scale = rng.size(-8, 8), radius = rounded(scale * rng.size(-1, 2));
  double a = rng.sign() * scale * rng.size(-3, 0), b = a + scale * rng.size(rng.chance(0.5) ? -26 : -3, 1);
  if (rng.chance(0.3)) b = scale * rng.size(-20, -10), a = -b * rng.unit();
  if (rng.chance(0.3)) std::swap(a, b), a = -a, b = -b;
  if (a > b) std::swap(a, b);
  const real lo = rounded(a), hi = rounded(b);
  const real near = rng.chance(0.5) ? lo : hi;
  const real p = rounded(rng.chance(0.4) ? static_cast<double>(near) : rng.chance(0.5) ? near + rng.sign() * scale * rng.size(-28, -18) : scale * rng.between(-2, 2));
  const real d = rng.chance(0.1) ? real(0) : rounded(rng.sign() * rng.size(rng.chance(0.3) ? -30 : -3, 1));
  real e = rng.chance(0.4) ? real(0) : rounded(scale * rng.size(-40, -15));
  if (rng.chance(0.3)) e = rounded(std::fabs(d) * radius * rng.between(0.9, 1.3));
  const exact off = nearly(e);
  RANGE range = everything();
  clip_axis(&range, p, d, e, lo, hi, rounded(radius));
  exact from, to;
  solve(p, d, exact(a) - off, exact(b) + off, radius, &from, &to);
  if (!held(range, from, to)) return false;
  if (!inner(range, radius, &from, &to)) return true;
  for (const exact s : {from, to})
    if (!at_most(exact(a) + off, p + s * d) || !at_most(p + s * d, exact(b) - off)) return false;
  return true;
}

// Balls before the ray, off it, round its start, touched by it.
CONTRACT(clip_sphere) {
  const double scale = rng.size(-8, 8), distance = rng.chance(0.5) ? 0 : scale * rng.size(-3, 8);
  double center[3], off[3];
  real d[3], p[3];
  double along = 0, square = 0;
  const bool upright = rng.chance(0.3);
  for (int k = 0; k < 3; ++k) d[k] = rounded(upright ? double(k == 0) * rng.size(0, 1) : rng.sign() * rng.size(-2, 1));
  for (int k = 0; k < 3; ++k) off[k] = rng.sign() * scale * rng.size(-12, 0), along += off[k] * d[k], square += double(d[k]) * d[k];
  for (int k = 0; k < 3; ++k) off[k] -= along / square * d[k];
  const double away = std::sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
  for (int k = 0; k < 3; ++k) center[k] = rng.chance(0.5) ? 0 : rng.sign() * scale * rng.size(-3, 6);
  for (int k = 0; k < 3; ++k) p[k] = rounded(center[k] + off[k] + distance * rng.sign() / std::sqrt(square) * d[k]);
  const double r = rng.chance(0.4) ? away * (1 + rng.sign() * std::exp2(-rng.between(1, IRT_DOUBLE ? 55 : 27))) : scale * rng.size(-4, 2);
  const real e = rng.chance(0.5) ? real(0) : rounded(scale * rng.size(-40, -15));
  RAY ray;
  ray.px = p[0], ray.py = p[1], ray.pz = p[2], ray.dx = d[0], ray.dy = d[1], ray.dz = d[2];
  ray.ex = ray.ey = ray.ez = e;
  RANGE range = everything();
  clip_sphere(&range, &ray, rounded(center[0]), rounded(center[1]), rounded(center[2]), rounded(r));
  // The square of the distance of the nearest, and of the farthest, point that the ray may have at s.
  const auto square_at = [&](exact s, int side) {
    exact sum = 0;
    for (int k = 0; k < 3; ++k) {
      const exact v = most(magnitude(p[k] + s * d[k] - exact(center[k])) + side * nearly(e), 0);
      sum += v * v;
    }
    return sum;
  };
  exact a = 0, b = 0;
  for (int k = 0; k < 3; ++k) a += exact(d[k]) * d[k], b += exact(d[k]) * (p[k] - exact(center[k]));
  const exact middle = -b / a, rr = exact(r) * r;
  if (square_at(middle, -1) < rr) {
    if (of(range.out0) > middle || of(range.out1) < middle) return false;
    if (!at_most(rr, square_at(of(range.out0), -1)) || !at_most(rr, square_at(of(range.out1), -1))) return false;
  }
  return of(range.in0) > of(range.in1) || (at_most(square_at(of(range.in0), 1), rr) && at_most(square_at(of(range.in1), 1), rr));
}

// e is as make_ray has it, at least: four ulp of what the coordinate is made of.
CONTRACT(clip_half_space) {
  const double scale = rng.size(-8, 8), radius = rounded(scale * rng.size(-1, 2));
  double n[3];
  real p[3], d[3], e[3];
  exact at = 0, along = 0, off = 0;
  for (int k = 0; k < 3; ++k) {
    n[k] = rng.chance(0.3) ? 0 : rng.sign() * rng.size(-3, 0);
    p[k] = rng.chance(0.4) ? real(0) : rounded(rng.sign() * scale * rng.size(-6, 0));
    d[k] = rng.chance(0.3) ? real(0) : rounded(rng.sign() * rng.size(-3, 1));
  }
  if (rng.chance(0.4)) {  // nearly parallel
    const int k = rng.below(3);
    if (n[k] != 0) d[k] = rounded((double(d[k]) * n[k] - (n[0] * d[0] + n[1] * d[1] + n[2] * d[2])) / n[k] + (rng.chance(0.5) ? rng.sign() * rng.size(-40, -10) : 0));
  }
  for (int k = 0; k < 3; ++k) {
    e[k] = rounded(4.0000001 * ULP * (std::fabs(double(p[k])) + radius * std::fabs(double(d[k]))) + (rng.chance(0.2) ? scale * rng.size(-24, -10) : 0));
    at += exact(n[k]) * p[k], along += exact(n[k]) * d[k], off += magnitude(n[k]) * nearly(e[k]);
  }
  // The plane is met within the radius, more often than not near its end.
  const double s = radius * (rng.chance(0.6) ? rng.sign() * (1 - std::exp2(-rng.between(1, 20))) : rng.between(-1.1, 1.1));
  const double offset = static_cast<double>(at + s * along) + (rng.chance(0.5) ? rng.sign() * 2 * static_cast<double>(off) * rng.unit() : 0);
  RAY ray;
  ray.px = p[0], ray.py = p[1], ray.pz = p[2], ray.dx = d[0], ray.dy = d[1], ray.dz = d[2];
  ray.ex = e[0], ray.ey = e[1], ray.ez = e[2];
  RANGE range = everything();
  clip_half_space(&range, &ray, rounded(n[0]), rounded(n[1]), rounded(n[2]), rounded(offset), rounded(radius));
  exact from, to;
  solve(at, along, -static_cast<exact>(1e300), exact(offset) + off, radius, &from, &to);
  if (!held(range, from, to)) return false;
  if (!inner(range, radius, &from, &to)) return true;
  return at_most(at + from * along, exact(offset) - off) && at_most(at + to * along, exact(offset) - off);
}

// A ray of a list: coordinates of the true ray, which the host's terms tell to within POSITION_PAD, lie within e of p + s d.
CONTRACT(ray_list) {
  const double radius = rng.size(-8, 8), scale = radius * rng.size(-4, 4), pad = rng.chance(0.5) ? 0 : scale * rng.size(-30, -15);
  double terms[12] = {};
  wide rays[12];
  for (int k = 0; k < 6; ++k) terms[k] = rng.sign() * (k < 3 ? scale : 1) * rng.size(-3, 1);
  for (int k = 0; k < 12; ++k) rays[k] = static_cast<wide>(terms[k]);
  real q[32] = {};
  q[6] = rounded(radius), q[7] = rounded(pad);
  const RAY ray = make_ray(rays, 1, q, 0, 0);
  const exact s = radius * rng.part() * (q[6] < radius ? 0.5 : 1), host = nearly(q[7]) * rng.part();
  return at_most(magnitude(of(ray.px) + s * of(ray.dx) - (exact(terms[0]) + s * exact(terms[3]) + host)), of(ray.ex));
}
}  // namespace
