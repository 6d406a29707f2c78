// Integer powers above 4 of affine forms, each by one linear approximation of the whole power.
//
// For a base that keeps its sign let a = |x|, r the radius, M = a + r. |base|^n is convex, lies above its tangent at a, and
// farthest from it at M: by G = M^n - a^n - n a^(n-1) r, and by Taylor's theorem G <= n (n - 1) / 2 M^(n-2) r^2, which does
// not cancel where r is small. The form is the tangent moved up by G / 2. Where the base may be zero, it is the range.

// The largest size of the base, no less than it is.
#define RA_MOST(a) ((fabs((a).x) + ra_rad(a)) * (R(1.0) + R(2.0) * ULP))

// power_below(a) = a^(n-1), power_twice(M) = M^(n-2); even: whether n is.
#define RA_POWER(a, power_below, power_twice, n, even) \
  ra_power(a, RA_MOST(a), power_below(fabs((a).x)), power_twice(RA_MOST(a)), n, even)

// The range of an even power of a base, by the least and the largest size of it. power(a) = a^n; compilers take the upper end from RA_POWER.
#define RA_EVEN_POWER_RANGE(a, power, power_twice, k) ia_power_even(power(ra_least(a)), power_twice(RA_MOST(a)) * RA_MOST(a) * RA_MOST(a), k)

static inline F ra_least(RA a) { return max(LOWER(fabs(a.x) - ra_rad(a) * (R(1.0) + R(1.0) * ULP), EXACT), (F)0); }

static inline RA ra_power(RA a, F most, F below, F twice, real n, I even) {
  const F size = fabs(a.x), reach = ra_rad(a);
  const F power = below * size, top = twice * most * most, steep = n * below;
  const F rise = fma(steep, reach, power);  // the tangent at the far end
#if IRT_OUTWARD
  const real k = (R(0.5) * n + R(3.0)) * ULP;  // a power of n factors errs by n / 2 ulp
  const F gap = min((top - rise) + k * (top + rise), R(0.5) * n * (n - R(1.0)) * twice * reach * reach * (R(1.0) + R(2.0) * k));
#else
  const F gap = top - rise;
#endif
  const I through = LE(size, reach), minus = LT(a.x, (F)0) & ~even;
  const F x = fma((F)R(0.5), gap, power), y = SELECT(LT(a.x, (F)0) & even, -steep, steep) * a.y;
  const F z = fma(steep, a.z, R(0.5) * gap);
  const F middle = SELECT(through, SELECT(even, R(0.5) * top, (F)0), SELECT(minus, -x, x));
  const F radius = SELECT(through, SELECT(even, R(0.5) * top, top), z);
#if IRT_OUTWARD
  return ra(middle, SELECT(through, (F)0, y), fma((F)k, SELECT(through, top, rise + gap), radius) + (F)TINY);
#else
  return ra(middle, SELECT(through, (F)0, y), radius);
#endif
}
