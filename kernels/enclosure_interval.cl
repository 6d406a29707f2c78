// Enclosures of f over a piece of ray by interval arithmetic: coordinates are intervals.

typedef IA FORM;

static inline IA coordinate(F at_from, F at_to, F e) {
#if IRT_OUTWARD
  return ia(min(at_from, at_to) - e, max(at_from, at_to) + e);
#else
  return ia(min(at_from, at_to), max(at_from, at_to));
#endif
}

// f over the piece from `from` to `to`, in units of the path.
static inline FORM enclose(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough) {
  return irt_interval(coordinate(fma(from, path->ux, path->ox), fma(to, path->ux, path->ox), path->ex),
                      coordinate(fma(from, path->uy, path->oy), fma(to, path->uy, path->oy), path->ey),
                      coordinate(fma(from, path->uz, path->oz), fma(to, path->uz, path->oz), path->ez)
                      PARAMETERS_PASS, undefined, rough);
}

static inline I positive(FORM f) { return GT(f.lo, (F)0); }
static inline I negative(FORM f) { return LT(f.hi, (F)0); }
static inline I unbounded(FORM f) { return ~(GT(f.lo, -INF) & LT(f.hi, INF)); }
