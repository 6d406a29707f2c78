// Windows of a path with one root at most: where the enclosure of the derivative along the ray keeps one sign (S3, Mitchell's isolation),
// and the interval Newton step inside them. The step c - f(c) / slopes holds the root, if there is one; what it cuts away at either end has
// a proven sign, so that a window cut at both ends is a bracket without another evaluation. Where the derivative may change its sign, the
// mean value theorem still tells how far around c there is no root.
typedef struct {
  F lo, hi;          // units between which the root lies, if there is one
  I below, above;    // f is proven to be on the side of zero that it comes from at lo, and on the other one at hi
  F least, most;     // units in which f changes by one; least is 0 where nothing is known
  I steady, rising;  // f rises, or falls, all along
} WINDOW;

static inline WINDOW open_window(const PATH* path, F from, F to PARAMETERS) {
  I undefined, rough;
  const IA d = slope(path, from, to PARAMETERS_PASS, &undefined, &rough);
  WINDOW w;
  w.lo = from;
  w.hi = to;
  w.below = w.above = NONE;
  w.rising = GT(d.lo, (F)0);
  const F whole = TO_F(PATH_END), slowest = SELECT(w.rising, d.lo, -d.hi), fastest = max(d.hi, -d.lo);
#if IRT_OUTWARD
  w.least = whole / fastest * (F)(R(1.0) - R(4.0) * ULP);
  w.most = whole / slowest * (F)(R(1.0) + R(4.0) * ULP);
#else
  w.least = whole / fastest;
  w.most = whole / slowest;
#endif
  const I known = ~undefined & ~rough & LT(w.least, INF);
  w.least = SELECT(known, w.least, (F)0);
  w.steady = known & GT(slowest, (F)0) & LT(w.most, INF);
  return w;
}

// The units before c and behind it in which there is no root, less their rounding; below zero where f(c) may be one.
static inline F free_units(const WINDOW* w, F c, IA f) {
  const F off = max(f.lo, -f.hi) * w->least;
#if IRT_OUTWARD
  return off - (F)(R(4.0) * ULP) * (c + off);
#else
  return off;
#endif
}

// Cuts by what f is at c, for `lanes`.
static inline void newton_cut(WINDOW* w, F c, IA f, I lanes) {
  const F low = SELECT(w->rising, f.lo, -f.hi), high = SELECT(w->rising, f.hi, -f.lo);
  const F back = high * SELECT(GE(high, (F)0), w->most, w->least), ahead = low * SELECT(GE(low, (F)0), w->least, w->most);
#if IRT_OUTWARD
  const F lo = (c - back) - (F)(R(2.0) * ULP) * (c + fabs(back)), hi = (c - ahead) + (F)(R(2.0) * ULP) * (c + fabs(ahead));
#else
  const F lo = c - back, hi = c - ahead;
#endif
  const I rises = lanes & GT(lo, w->lo), falls = lanes & LT(hi, w->hi);
  w->lo = SELECT(rises, lo, w->lo);
  w->hi = SELECT(falls, hi, w->hi);
  w->below |= rises;
  w->above |= falls;
}
