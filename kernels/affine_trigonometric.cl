// Trigonometric functions of affine forms (affine_smooth.cl).

// sin(x + d) lies within |d|^3 / 6 of S + C d - S d^2 / 2. Needs no range: past some two units it is [-1, 1].
static inline RA ra_wave(RA a, F value, F slope) {
  const F reach = ra_rad(a), bend = R(-0.5) * value * reach * reach, rest = R(0.1667) * reach * reach * reach;
  return ra_smooth(a, reach, value, slope, min(bend, (F)0) - rest, max(bend, (F)0) + rest, R(4.0), LE(fabs(a.x), (F)WAVE_REACH), ia((F)-1, (F)1));
}

static inline RA ra_sin(RA a) { return ra_wave(a, sin(WAVE_CLIP(a.x)), cos(WAVE_CLIP(a.x))); }
static inline RA ra_cos(RA a) { return ra_wave(a, cos(WAVE_CLIP(a.x)), -sin(WAVE_CLIP(a.x))); }

// g'' = 2 g (1 + g^2) rises; g' errs by 10.5 ulp.
static inline RA ra_tan(RA a, IA range, IA result) {
  const F reach = ra_rad(a), v = tan(WAVE_CLIP(a.x)), h = reach * reach, lo = result.lo, hi = result.hi;
  return ra_smooth(a, reach, v, fma(v, v, (F)1), min(h * lo * fma(lo, lo, (F)1), (F)0), max(h * hi * fma(hi, hi, (F)1), (F)0), R(5.0),
                   WITHIN(a, range) & GT(lo, -INF) & LT(hi, INF), result);
}

// g'' = x / (1 - x^2)^(3/2) rises. The slopes err by 6.25 ulp, the remainders by 10.25.
#define ARC_BEND(x) ((x) / ((R(1.0) - (x)) * (R(1.0) + (x)) * sqrt((R(1.0) - (x)) * (R(1.0) + (x)))))

static inline RA ra_asin(RA a, IA range, IA result) {
  const F reach = ra_rad(a), h = R(0.5) * reach * reach, x = clamp(a.x, (F)-1, (F)1);
  return ra_smooth(a, reach, asin(x), R(1.0) / sqrt((R(1.0) - x) * (R(1.0) + x)), min(h * ARC_BEND(range.lo), (F)0),
                   max(h * ARC_BEND(range.hi), (F)0), R(4.0), WITHIN(a, range) & GT(range.lo, (F)-1) & LT(range.hi, (F)1), result);
}

static inline RA ra_acos(RA a, IA range, IA result) {
  const F reach = ra_rad(a), h = R(0.5) * reach * reach, x = clamp(a.x, (F)-1, (F)1);
  return ra_smooth(a, reach, acos(x), R(-1.0) / sqrt((R(1.0) - x) * (R(1.0) + x)), min(-h * ARC_BEND(range.hi), (F)0),
                   max(-h * ARC_BEND(range.lo), (F)0), R(4.0), WITHIN(a, range) & GT(range.lo, (F)-1) & LT(range.hi, (F)1), result);
}

// g'' = -2 x g'^2, |g'''| <= 2. bend errs by 9 ulp.
static inline RA ra_atan(RA a, IA range, IA result) {
  const F reach = ra_rad(a), slope = R(1.0) / fma(a.x, a.x, (F)1), bend = -a.x * slope * slope * reach * reach;
  const F rest = R(0.3334) * reach * reach * reach;
  return ra_smooth(a, reach, atan(a.x), slope, min(bend, (F)0) - rest, max(bend, (F)0) + rest, R(5.0), ALL, result);
}

// The angle from the middle of the forms to (x, y) is atan of a quotient, where the whole of them lies within a quarter turn.
static inline RA ra_atan2(RA y, RA x, IA y_range, IA x_range, IA result) {
  const RA cx = ra(x.x, (F)0, (F)0), cy = ra(y.x, (F)0, (F)0);
  const RA across = ra_sub(ra_mul(cx, y), ra_mul(cy, x)), along = ra_add(ra_mul(cx, x), ra_mul(cy, y));
  const IA across_range = ra_range(across), along_range = ra_range(along);
  I undefined, rough;
  const RA quotient = ra_div(across, along, across_range, along_range, ia_div(across_range, along_range, &undefined, &rough));
  const IA quotient_range = ra_range(quotient);
  const RA turn = ra_atan(quotient, quotient_range, ia_atan(quotient_range));
  const F middle = atan2(y.x, x.x);
  const I cut = LE(y_range.lo, (F)TINY) & GE(y_range.hi, (F)-TINY) & LE(x_range.lo, (F)TINY);
  const I better = GT(along_range.lo, (F)TINY) & ~cut & LE(turn.z, R(0.5) * (result.hi - result.lo));
  const RA sum = ra_add(turn, ra(middle, (F)0, (F)(R(6.01) * ULP) * fabs(middle))), box = ra_from_range(result);
  return RA_PICK(better, sum, box);
}
