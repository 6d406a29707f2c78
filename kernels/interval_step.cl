// Functions that jump, over intervals. `rough` is where a jump may lie inside.


static inline IA ia_sign(IA a, I* undefined, I* rough) {
  *undefined = NONE;
  *rough = LE(a.lo, (F)0) & GE(a.hi, (F)0) & LT(a.lo, a.hi);
  const F one = (F)1;
  return ia(SELECT(LT(a.lo, (F)0), -one, SELECT(GT(a.lo, (F)0), one, (F)0)), SELECT(LT(a.hi, (F)0), -one, SELECT(GT(a.hi, (F)0), one, (F)0)));
}

static inline IA ia_floor(IA a, I* undefined, I* rough) {
  const F l = floor(a.lo), h = floor(a.hi);
  *undefined = NONE;
  *rough = ~EQ(l, h);
  return ia(l, h);
}

static inline IA ia_ceiling(IA a, I* undefined, I* rough) {
  const F l = ceil(a.lo), h = ceil(a.hi);
  *undefined = NONE;
  *rough = ~EQ(l, h);
  return ia(l, h);
}
