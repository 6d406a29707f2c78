// Exponential, logarithm and hyperbolic functions over intervals.

// A range of what is never positive.
static inline IA ia_nonpositive(IA a) { return ia(min(a.lo, (F)0), min(a.hi, (F)0)); }

static inline IA ia_exp(IA a) {
  return ia(max(LOWER(CAP_EARLY(exp(a.lo)), R(3.0)), (F)0), UPPER(exp(a.hi), R(3.0)));
}

// Ends below TINY count as zero: devices may flush them.
static inline IA ia_log(IA a, I* undefined, I* rough) {
  *undefined = LE(a.hi, (F)0);
  *rough = LE(a.lo, (F)0);
  const F lo = LOWER(CAP_LOWER(log(max(a.lo, (F)TINY))), R(3.0)), hi = UPPER(log(max(a.hi, (F)TINY)), R(3.0));
  return ia(SELECT(LE(a.lo, (F)TINY), -INF, lo), hi);
}

static inline IA ia_sinh(IA a) { return IA_OUT(CAP_EARLY(sinh(a.lo)), -CAP_EARLY(-sinh(a.hi)), R(4.0)); }

static inline IA ia_cosh(IA a) {
  const IA m = ia_abs(a);
  return ia(max(LOWER(CAP_EARLY(cosh(m.lo)), R(4.0)), (F)1), UPPER(cosh(m.hi), R(4.0)));
}

static inline IA ia_tanh(IA a) {
  return ia(max(LOWER(tanh(a.lo), R(5.0)), (F)-1), min(UPPER(tanh(a.hi), R(5.0)), (F)1));
}
