// Absolute values, minima, maxima, remainders and choices of affine forms.

// Where the sign is not known: on [lo, hi], lo < 0 < hi, the line of slope (hi + lo) / (hi - lo) that runs half way between |x|
// and its chord (the Chebyshev line).
static inline RA ra_abs(RA a, IA range, IA result) {
  const F lo = min(range.lo, (F)0), hi = max(range.hi, (F)0), width = max(hi - lo, (F)TINY);
  const F alpha = (hi + lo) / width, gap = -hi * (lo / width), x = fma(alpha, a.x, gap), y = alpha * a.y;
#if IRT_OUTWARD
  const F z = fma((F)(R(12.0) * ULP), fabs(a.x) + ra_rad(a) + gap, fma(fabs(alpha), a.z, gap)) + (F)TINY;
#else
  const F z = fma(fabs(alpha), a.z, gap);
#endif
  const I above = GE(range.lo, (F)0), below = LE(range.hi, (F)0), through = LT(width, INF) & LT(gap, INF) & LE(gap, result.hi);
  const RA line = ra(x, y, z), box = ra_from_range(result), unsure = RA_PICK(through, line, box), minus = ra_neg(a);
  const RA one = RA_PICK(below, minus, unsure);
  return RA_PICK(above, a, one);
}

// One of the two where one is always the smaller, else the range of both.
static inline RA ra_extreme(RA a, RA b, IA result, real sign) {
  const IA apart = ra_range(ra_sub(a, b));
  const I above = GE(apart.lo, (F)0), below = LE(apart.hi, (F)0);
  const RA box = ra_from_range(result), other = RA_PICK(sign < 0 ? above : below, b, box);
  return RA_PICK(sign < 0 ? below : above, a, other);
}

static inline RA ra_min(RA a, RA b, IA a_range, IA b_range, IA result) { return ra_extreme(a, b, result, R(-1.0)); }
static inline RA ra_max(RA a, RA b, IA a_range, IA b_range, IA result) { return ra_extreme(a, b, result, R(1.0)); }
