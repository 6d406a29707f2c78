// Integer powers above 4 of affine forms by one linear approximation, as Chebyshev forms of smooth functions are built.
//
// Where the range of the base keeps its sign, a ** n is convex or concave there: it lies on one side of its tangent at the
// middle, and farthest from it at an end. Where the range holds zero the slope says nothing, and the range is the form.

#define RA_POWER(a, power_n, power_below, n, even) \
  ra_power(a, power_n((a).x), power_below((a).x), power_n((a).x - ra_reach(a)), power_n((a).x + ra_reach(a)), n, even)

// How far from x the values of a form may lie.
static inline F ra_reach(RA a) {
#if IRT_OUTWARD
  return ra_rad(a) * (R(1.0) + R(4.0) * ULP) + (F)ULP * fabs(a.x);
#else
  return ra_rad(a);
#endif
}

// middle, low, high: the powers at x, x - reach, x + reach; below: x ** (n - 1).
static inline RA ra_power(RA a, F middle, F below, F low, F high, real n, I even) {
  const F reach = ra_reach(a), slope = n * below;
  const F at_low = (low - middle) + slope * reach, at_high = (high - middle) - slope * reach;
  const F least = min(min(at_low, at_high), (F)0), most = max(max(at_low, at_high), (F)0);
  const F spread = R(0.5) * (most - least);
  const I through = LE(a.x - reach, (F)0) & GE(a.x + reach, (F)0);
  const F bottom = SELECT(even, (F)0, low), top = max(low, high);
  const F flat = R(0.5) * (top - bottom);
  const F x = SELECT(through, R(0.5) * (bottom + top), middle + R(0.5) * (least + most));
  const F y = SELECT(through, (F)0, slope * a.y);
  const F z = SELECT(through, flat, fma(fabs(slope), a.z, spread));
#if IRT_OUTWARD
  // Each power is known to n / 2 + 1 ulp, the slope to as much.
  const F size = fabs(low) + fabs(high) + fabs(middle) + R(2.0) * fabs(slope) * reach;
  return ra(x, y, fma((F)((n + R(6.0)) * ULP), size + z, z + (F)TINY));
#else
  return ra(x, y, z);
#endif
}
