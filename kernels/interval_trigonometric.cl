// Trigonometric functions over intervals.
//
// Extremes inside an interval are found by counting periods: q = x / period, and floor(q) of the two ends differ where
// a multiple of the period lies between. q carries a margin for its own rounding, so that an extreme is at worst
// reported where it lies just outside, which is sound. Beyond some 1e6 (float) the margin exceeds a period: [-1, 1].

// Arguments past WAVE_REACH, where `ia_meets` holds, are clipped: PoCL's sin, cos and tan of packets of floats spoil the small
// lanes where one lane is past 2^23 (sin(0.0014) became 0.0113).
#define WAVE_REACH (R(0.1) / ULP)
#define WAVE_CLIP(x) clamp(x, (F)(-WAVE_REACH), (F)WAVE_REACH)

// Of doubles in kernels of floats (refine.cl): where these are clipped their error exceeds all that a sine can be.
#define FINE_CLIP(x) clamp(x, (FW)-0x1p48, (FW)0x1p48)
#define FINE_SIN(x) sin(FINE_CLIP(x))
#define FINE_COS(x) cos(FINE_CLIP(x))

// Turns from `offset` to the ends, widened by the rounding of x / (2 pi): an ulp and a half of that in all. What rounding the offset adds
// is at most an ulp of a turn: missing an extreme by that changes the value by its square only, and at poles the ends have the wrong order.
#define TURN R(0.15915494309189533577)
#define TURNS_ERROR (R(0.25) * ULP)
#define TURNS_LO(x, offset) fma(x, (F)TURN, (F)(offset)) - fabs(x) * (F)TURNS_ERROR
#define TURNS_HI(x, offset) fma(x, (F)TURN, (F)(offset)) + fabs(x) * (F)TURNS_ERROR

// Whether a point with x / (2 pi) + offset an integer lies in [lo, hi]; true also for unbounded and huge arguments.
static inline I ia_meets(IA a, real offset) {
  const F l = floor(TURNS_LO(a.lo, offset)), h = floor(TURNS_HI(a.hi, offset));
  return ~EQ(l, h) | GT(fabs(l), (F)(R(0.01) / ULP)) | GT(fabs(h), (F)(R(0.01) / ULP));
}

static inline IA ia_wave(F at_lo, F at_hi, I peak, I trough) {
  const F lo = SELECT(trough, (F)-1, max(LOWER(min(at_lo, at_hi), R(4.0)), (F)-1));
  const F hi = SELECT(peak, (F)1, min(UPPER(max(at_lo, at_hi), R(4.0)), (F)1));
  return ia(lo, hi);
}

static inline IA ia_sin(IA a) { return ia_wave(sin(WAVE_CLIP(a.lo)), sin(WAVE_CLIP(a.hi)), ia_meets(a, R(-0.25)), ia_meets(a, R(0.25))); }

static inline IA ia_cos(IA a) { return ia_wave(cos(WAVE_CLIP(a.lo)), cos(WAVE_CLIP(a.hi)), ia_meets(a, R(0.0)), ia_meets(a, R(0.5))); }

// Poles lie a quarter turn after every half turn.
static inline IA ia_tan(IA a, I* undefined, I* rough) {
  const F l = tan(WAVE_CLIP(a.lo)), h = tan(WAVE_CLIP(a.hi));
  const I pole = ia_meets(a, R(-0.25)) | ia_meets(a, R(0.25)) | ~LE(l, h);
  *undefined = NONE;
  *rough = pole;
  return ia(SELECT(pole, -INF, LOWER(l, R(5.0))), SELECT(pole, INF, UPPER(h, R(5.0))));
}

#define OUTSIDE_UNIT(a) (LT((a).hi, (F)-1) | GT((a).lo, (F)1))
#define BEYOND_UNIT(a) (LT((a).lo, (F)-1) | GT((a).hi, (F)1))
#define UNIT_CLIP(v) clamp(v, (F)-1, (F)1)

static inline IA ia_asin(IA a, I* undefined, I* rough) {
  *undefined = OUTSIDE_UNIT(a);
  *rough = BEYOND_UNIT(a);
  return ia(max(LOWER(asin(UNIT_CLIP(a.lo)), R(4.0)), (F)(R(-0.5) * PI_HI)), min(UPPER(asin(UNIT_CLIP(a.hi)), R(4.0)), (F)(R(0.5) * PI_HI)));
}

static inline IA ia_acos(IA a, I* undefined, I* rough) {
  *undefined = OUTSIDE_UNIT(a);
  *rough = BEYOND_UNIT(a);
  return ia(max(LOWER(acos(UNIT_CLIP(a.hi)), R(4.0)), (F)0), min(UPPER(acos(UNIT_CLIP(a.lo)), R(4.0)), (F)PI_HI));
}

static inline IA ia_atan(IA a) {
  return ia(max(LOWER(atan(a.lo), R(5.0)), (F)(R(-0.5) * PI_HI)), min(UPPER(atan(a.hi), R(5.0)), (F)(R(0.5) * PI_HI)));
}

// On a box that avoids the cut (y = 0, x <= 0) the extremes are at corners; on the cut the angle jumps by a full turn.
static inline IA ia_atan2(IA y, IA x, I* undefined, I* rough) {
  const I cut = LE(y.lo, (F)TINY) & GE(y.hi, (F)-TINY) & LE(x.lo, (F)TINY);
  const F p = atan2(y.lo, x.lo), q = atan2(y.lo, x.hi), r = atan2(y.hi, x.lo), s = atan2(y.hi, x.hi);
  const F lo = LOWER(min(min(p, q), min(r, s)), R(6.0)), hi = UPPER(max(max(p, q), max(r, s)), R(6.0));
  *undefined = EQ(y.lo, (F)0) & EQ(y.hi, (F)0) & EQ(x.lo, (F)0) & EQ(x.hi, (F)0);
  *rough = cut;
  return ia(SELECT(cut, (F)-PI_HI, max(lo, (F)-PI_HI)), SELECT(cut, (F)PI_HI, min(hi, (F)PI_HI)));
}
