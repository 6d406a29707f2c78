// The remainder of a division over intervals.

// a - b floor(a / b): the sign of the divisor (Python's and SymPy's Mod).
static inline IA ia_mod(IA a, IA b, I* undefined, I* rough) {
  I jumps, none;
  const IA k = ia_floor(ia_div(a, b, undefined, rough), &none, &jumps);
  const IA same = ia_sub(a, ia_mul(b, k));
  *rough |= jumps;
  const F least = min(b.lo, (F)0), most = max(b.hi, (F)0);
  return ia(SELECT(*rough, least, max(same.lo, least)), SELECT(*rough, most, min(same.hi, most)));
}
