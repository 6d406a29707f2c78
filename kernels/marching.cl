// Marching points and adaptive marching points (S3, Singh and Narayanan): steps along the ray until f has opposite signs at the ends of
// one, then Newton-bisection in it. Sampled-newton (S4 section 3.1.3) is the same with another guard in the refinement.
//
// TAYLOR: a step may hold a zero as well where f, taken along its tangent from one of the ends to the middle, changes sign (S3's p, q, r
// and s, of which the slides give no formulas). ADAPTIVE: a step is the distance |f| / |grad f| to the surface, down to half of it
// where the ray runs along a level set, as it does towards silhouettes (the slides name both and give no formulas). FALSI: Newton begins
// at the point of regula falsi, which also comes before halving where Newton leaves the step (S4 names both for the refinement).
//
// Deviations: S3 takes a step that passes the Taylor test for a hit, which gives false roots at cusps. Here it is halved; what is no
// longer than eps, still passes and dips towards zero is a TOUCH. So is a zero that was met between equal signs. A sign change from which f comes
// back (a pole) is no root, one across which it does not close up (a jump) is a TOUCH. Roots outside the clip region are passed by.
// Where f is undefined it has no sign.
#ifdef ADAPTIVE
#define LONGEST R(4.0)  // steps, in steps of the fixed march
#define SHORTEST R(0.125)
#endif
#define CLOSES R(8.0)  // where f is continuous, it changes over a short bracket by no more than this times what its slope says

typedef struct {
  F at, value, slope;
  F advised;  // the step from here
} SAMPLE;

static inline SAMPLE sample(const PATH* path, F at, F step PARAMETERS) {
  SAMPLE s;
  s.at = at;
  s.slope = (F)0;
  s.advised = step;
#ifdef ADAPTIVE
  F steepest;
  s.value = gradient_at(path, at PARAMETERS_PASS, &s.slope, &steepest);
  const F change = steepest * sqrt(fma(path->ux, path->ux, fma(path->uy, path->uy, path->uz * path->uz)));  // of f, by units, at most
  const F distance = fabs(s.value) / change * fma((F)R(0.5), fabs(s.slope) / change, (F)R(0.5));
  s.advised = SELECT(LT(distance, INF), clamp(distance, SHORTEST * step, LONGEST * step), step);
#elif defined(TAYLOR)
  s.value = slope_at(path, at PARAMETERS_PASS, &s.slope);
#else
  s.value = value_at(path, at PARAMETERS_PASS);
#endif
  return s;
}

static inline SAMPLE chosen(I where, SAMPLE a, SAMPLE b) {
  SAMPLE s;
  s.at = SELECT(where, a.at, b.at);
  s.value = SELECT(where, a.value, b.value);
  s.slope = SELECT(where, a.slope, b.slope);
  s.advised = SELECT(where, a.advised, b.advised);
  return s;
}

static inline I opposite(F a, F b) { return (GT(a, (F)0) & LT(b, (F)0)) | (LT(a, (F)0) & GT(b, (F)0)); }

// Whether the tangent from an end leads through zero before the middle.
static inline I suspicious(SAMPLE a, SAMPLE b) {
#ifdef TAYLOR
  const F reach = R(0.5) * (b.at - a.at);
  return opposite(a.value, fma(a.slope, reach, a.value)) | opposite(b.value, fma(-b.slope, reach, b.value));
#else
  return NONE;
#endif
}

// Whether |f| falls into a step from both ends: at a pole it does from one only.
static inline I dips(SAMPLE a, SAMPLE b) { return ~opposite(a.value, -a.slope) & ~opposite(b.value, b.slope); }

static inline F middle(SAMPLE a, SAMPLE b) { return R(0.5) * (a.at + b.at); }

// Where to look between opposite signs when Newton does not say.
static inline F guess(SAMPLE a, SAMPLE b, I halving) {
#ifdef FALSI
  const F at = a.at + (b.at - a.at) * (a.value / (a.value - b.value));
  return SELECT(~halving & GT(at, a.at) & LT(at, b.at), at, middle(a, b));
#else
  return middle(a, b);
#endif
}

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces PARAMETERS) {
  const PATH path = make_path(ray, range, q);
  // A root at an end counts, and one beyond it does not: what rounding leaves open of both are steps of their own, and no HITs.
  const F last = TO_F(PATH_END), in0 = clamp(path.in0, (F)0, last), in1 = clamp(path.in1, in0, last), fixed = last / (F)STEPS;
  const F wanted = max((F)EPS / (NARROW(ray->length) * path.unit), (F)1);  // a unit is about what the precision resolves
  I active = LE(range->out0, range->out1), hits = NONE, touches = NONE;
  SAMPLE from = sample(&path, (F)0, fixed PARAMETERS_PASS), sign = from;  // where the march is; and what had a sign last
  F step = from.advised, lo = (F)0, hi = (F)0;
  F zero = (F)-1;  // where f has been zero since then
  zero = SELECT(EQ(from.value, (F)0) & counts_at(&path, (F)0 PARAMETERS_PASS), (F)0, zero);
  int pieces = 0;
  COUNT_FROM_HERE
  while (ANY(active) && pieces < max_pieces) {
    I marches = active, crosses = NONE;
    for (; pieces < max_pieces && ANY(marches); ++pieces) {
      COUNT(marches)
      const F next = min(from.at + step, SELECT(LT(from.at, in0), in0, SELECT(LT(from.at, in1), in1, last)));
      const SAMPLE to = sample(&path, next, fixed PARAMETERS_PASS);
      const I is_zero = EQ(to.value, (F)0), ends = GE(to.at, last), crossing = marches & opposite(sign.value, to.value);
      const I suspect = marches & suspicious(from, to) & ~crossing & ~is_zero, stays = suspect & GT(to.at - from.at, wanted);
      I counts = ALL;
#if IRT_CLIP
      if (ANY(marches & (is_zero | suspect))) counts = counts_at(&path, to.at PARAMETERS_PASS);
#endif
      const I moves = marches & ~stays;
      zero = SELECT(moves & is_zero & counts & LT(zero, (F)0), to.at, zero);
      const I met = moves & GE(zero, (F)0) & ~crossing & (~is_zero | ends), touching = met | (suspect & ~stays & counts & dips(from, to));
      lo = SELECT(touching, SELECT(met, zero, from.at), lo);
      hi = SELECT(touching, SELECT(met, zero, to.at), hi);
      touches |= touching;
      crosses |= crossing & ~touching;
      active &= ~(touching | (moves & ends & ~crossing));
      marches &= active & ~crossing;
      step = SELECT(stays, R(0.5) * (to.at - from.at), SELECT(moves, min(to.advised, R(2.0) * step), step));
      zero = SELECT(moves & ~is_zero, (F)-1, zero);
      sign = chosen(moves & ~crossing & ~is_zero, to, sign);
      from = chosen(moves, to, from);
    }
    SAMPLE a = sign, b = from, c;
    I refines = crosses & active, halving = NONE;
    F before = b.at - a.at, at = guess(a, b, NONE);
#if IRT_PARTIAL
    const F way = SELECT(LT(a.value, (F)0), (F)1, (F)-1);
#if !defined(TAYLOR) && !defined(ADAPTIVE)
    a.slope = b.slope = (F)NAN;  // not known yet
#endif
#endif
    for (; pieces < max_pieces && ANY(refines); ++pieces) {
      COUNT(refines)
      c.at = at;
      c.value = slope_at(&path, at PARAMETERS_PASS, &c.slope);
      c.advised = fixed;
      const I lies_before = (GT(a.value, (F)0) & GT(c.value, (F)0)) | (LT(a.value, (F)0) & LT(c.value, (F)0));
      a = chosen(refines & lies_before, c, a);
      b = chosen(refines & ~lies_before, c, b);
      const F width = b.at - a.at;
      const I undefined = ~EQ(c.value, c.value), close = LE(width, wanted);
#if IRT_PARTIAL
      const F rise = way * (b.value - a.value), reach = CLOSES * width;
      const I closes = close & LE(rise, reach * fmax(way * a.slope, way * b.slope)), fails = ~closes & LE(width, (F)1);
      const I jumps = fails & ~LE(rise, -reach * fmin(way * a.slope, way * b.slope)) & LT(rise, INF);
#else
      const I closes = close, fails = NONE, jumps = NONE;
#endif
      const I done = refines & (closes | fails | undefined);
      I found = done & (closes | jumps) & ~undefined;
#if IRT_CLIP
      if (ANY(found)) found &= counts_at(&path, middle(a, b) PARAMETERS_PASS);
#endif
      const I lies_inside = GE(a.at, in0) & LE(b.at, in1);
      hits |= found & closes & lies_inside;
      touches |= found & ~(closes & lies_inside);
      lo = SELECT(found, a.at, lo);
      hi = SELECT(found, b.at, hi);
      active &= ~(found | (done & GE(from.at, last)));
      refines &= ~done;
      // Newton, while its steps shrink; its last one goes a little past the root, so that the bracket closes from both sides.
      const F move = -c.value / c.slope, root = c.at + move, length = fabs(move);
      const F past = root + SELECT(LT(R(2.0) * length, wanted), SELECT(lies_before, R(0.45) * wanted, R(-0.45) * wanted), (F)0);
      const I newton = GT(past, a.at) & LT(past, b.at) & LE(R(2.0) * length, before) & ~close;
      at = SELECT(newton, past, guess(a, b, halving));
      before = SELECT(newton, length, R(0.5) * width);
      halving = ~newton & ~halving;
    }
    // Where nothing was found behind the crossing the march goes on.
    sign = chosen(crosses, from, sign);
  }
  const I status = SELECT(hits, HIT, SELECT(touches, TOUCH, SELECT(active, UNRESOLVED, MISS)));
  ROOT root = report(&path, q, status, SELECT(active, from.at, lo), SELECT(active, from.at, hi));
  REPORT_COUNT
  return root;
}
