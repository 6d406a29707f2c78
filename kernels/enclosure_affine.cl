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
//
// The middle is not written as in contract.cl, which marches without pads and seldom asks for them: compilers would share parts of the two
// evaluations, and keep them in memory for the one that is seldom made.
static inline FORM enclose(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough REGION_PARAMETERS) {
  const F span = R(0.5) * (to - from), middle = from + span;
  return irt_affine(coordinate(ALONG(path, x, middle), span * path->ux, ERROR_UNTIL(path, x, to)),
                    coordinate(ALONG(path, y, middle), span * path->uy, ERROR_UNTIL(path, y, to)),
                    coordinate(ALONG(path, z, middle), span * path->uz, ERROR_UNTIL(path, z, to))
                    PARAMETERS_PASS, undefined, rough REGION_PASS);
}

#if IRT_ALONG
// How a coordinate changes along the whole path. The path of a coordinate errs by e at either end, so its slope by twice that.
static inline RA direction(F u, F e) {
  const F d = u * TO_F(PATH_END);
#if IRT_OUTWARD
  return ra(d, (F)0, fma((F)(R(2.0) * ULP), fabs(d), R(2.5) * e));
#else
  return ra(d, (F)0, (F)0);
#endif
}

// The derivative of f over the piece, in units of the whole path.
static inline IA slope(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough) {
  const F middle = R(0.5) * (from + to), span = R(0.5) * (to - from);
  return irt_along(coordinate(ALONG(path, x, middle), span * path->ux, ERROR_UNTIL(path, x, to)),
                   coordinate(ALONG(path, y, middle), span * path->uy, ERROR_UNTIL(path, y, to)),
                   coordinate(ALONG(path, z, middle), span * path->uz, ERROR_UNTIL(path, z, to)),
                   direction(path->ux, path->ex), direction(path->uy, path->ey), direction(path->uz, path->ez)
                   PARAMETERS_PASS, undefined, rough);
}
#endif

#if IRT_SLACK
// The same without pads.
static inline BARE enclose_bare(const PATH* path, F from, F to PARAMETERS) {
  const F middle = R(0.5) * (from + to), span = R(0.5) * (to - from);
  return bare(bare_ra(fma(middle, path->ux, path->ox), span * path->ux, path->bx), bare_ra(fma(middle, path->uy, path->oy), span * path->uy, path->by),
              bare_ra(fma(middle, path->uz, path->oz), span * path->uz, path->bz) PARAMETERS_PASS);
}
#endif
