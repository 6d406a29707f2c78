// Enclosures of f over a piece of ray by reduced affine arithmetic: e runs along the piece (S1 section 4.3).

// A coordinate; the rounding of its slope is an error as well.
static inline RA coordinate(F middle, F slope, F e) {
#if IRT_OUTWARD
  return ra(middle, slope, fma((F)(R(1.5) * ULP), fabs(slope), e));
#else
  return ra(middle, slope, e);  // the width of a beam
#endif
}

// f over the piece from `from` to `to`, in units of the path, and where that lies in the clip region.
static inline FORM enclose(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough REGION_PARAMETERS) {
  const F middle = R(0.5) * (from + to), span = R(0.5) * (to - from);
  return irt_affine(coordinate(ALONG(path, x, middle), span * path->ux, ERROR_UNTIL(path, x, to)),
                    coordinate(ALONG(path, y, middle), span * path->uy, ERROR_UNTIL(path, y, to)),
                    coordinate(ALONG(path, z, middle), span * path->uz, ERROR_UNTIL(path, z, to))
                    PARAMETERS_PASS, undefined, rough REGION_PASS);
}
