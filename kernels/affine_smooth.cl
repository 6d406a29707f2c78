// Affine forms of smooth functions, by Taylor's theorem about the middle of the form.
//
// Not in the papers, which fall back to intervals for everything but + - * and powers. g(x + d) is g(x) + g'(x) d + g''(c) d^2 / 2
// for some c between, and d^2 lies in [0, r^2]: with g'' of one sign the remainder is one-sided, and moving the line up or
// down by half of it leaves r^2 |g''| / 4, which is what the best linear approximation (Chebyshev) leaves, to leading order,
// without a division by the width, which cancels where pieces are short. Where the piece is wide the range of g is better.
//
// Helpers take the form, a range of the same values, and the range of the result: both ranges may be tighter than the forms.
// A form whose middle lies outside its range says nothing of g there, and the range is taken.

#define RA_PICK(m, a, b) ra(SELECT(m, (a).x, (b).x), SELECT(m, (a).y, (b).y), SELECT(m, (a).z, (b).z))
#define WITHIN(a, range) (GE((a).x, (range).lo) & LE((a).x, (range).hi))

// The form value + slope d + [low, high], |d| <= reach, low <= 0 <= high, where `allowed`; else the range. `reach` may be rounded down. The
// value is known to n ulp (the sum with half the remainder rounds it once more), and so near a root is the form. Slope, low and high are small
// where the piece is short: they are known to 19 ulp (square roots), the slope to TINY where it is smaller, and half an ulp for each of the
// steps in which they become y and z.
static inline RA ra_smooth(RA a, F reach, F value, F slope, F low, F high, real n, I allowed, IA range) {
  const F waste = fma((F)TINY, reach, R(0.5) * (high - low)), x = value + R(0.5) * (low + high);
#if IRT_OUTWARD
  const F z = fma((F)(R(22.0) * ULP), fma(fabs(slope), reach, high - low), fma((F)((n + ROUNDED) * ULP), fabs(value), fma(fabs(slope), a.z, waste))) + (F)TINY;
#else
  const F z = fma(fabs(slope), a.z, waste);
#endif
  const I better = allowed & LE(waste, R(0.5) * (range.hi - range.lo)) & LT(z, INF);
  const RA line = ra(x, slope * a.y, z), box = ra_from_range(range);
  return RA_PICK(better, line, box);
}
