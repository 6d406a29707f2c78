// Enclosures of f over a piece of ray by interval arithmetic: coordinates are intervals.

static inline IA coordinate(F at_from, F at_to, F e) {
#if IRT_OUTWARD
  return ia(min(at_from, at_to) - e, max(at_from, at_to) + e);
#else
  return ia(min(at_from, at_to), max(at_from, at_to));
#endif
}

// f over the piece from `from` to `to`, in units of the path, and where that lies in the clip region.
static inline FORM enclose(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough REGION_PARAMETERS) {
  return irt_interval(coordinate(ALONG(path, x, from), ALONG(path, x, to), path->ex),
                      coordinate(ALONG(path, y, from), ALONG(path, y, to), path->ey),
                      coordinate(ALONG(path, z, from), ALONG(path, z, to), path->ez)
                      PARAMETERS_PASS, undefined, rough REGION_PASS);
}

#if IRT_ALONG
// How a coordinate changes along the whole path. The path of a coordinate errs by e at either end, so its slope by twice that.
static inline IA direction(F u, F e) {
  const F d = u * TO_F(PATH_END);
#if IRT_OUTWARD
  const F off = fma((F)(R(2.0) * ULP), fabs(d), R(2.5) * e);
#else
  const F off = (F)0;
#endif
  return ia(d - off, d + off);
}

// The derivative of f over the piece, in units of the whole path.
static inline IA slope(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough) {
  return irt_along(coordinate(ALONG(path, x, from), ALONG(path, x, to), path->ex),
                   coordinate(ALONG(path, y, from), ALONG(path, y, to), path->ey),
                   coordinate(ALONG(path, z, from), ALONG(path, z, to), path->ez),
                   direction(path->ux, path->ex), direction(path->uy, path->ey), direction(path->uz, path->ez)
                   PARAMETERS_PASS, undefined, rough);
}
#endif

#if IRT_SLACK
static inline bare_IA bare_coordinate(F at_from, F at_to, F e) { return bare_ia(min(at_from, at_to) - e, max(at_from, at_to) + e); }

// f without pads.
static inline BARE enclose_bare(const PATH* path, F from, F to PARAMETERS) {
  return bare(bare_coordinate(fma(from, path->ux, path->ox), fma(to, path->ux, path->ox), path->bx),
              bare_coordinate(fma(from, path->uy, path->oy), fma(to, path->uy, path->oy), path->by),
              bare_coordinate(fma(from, path->uz, path->oz), fma(to, path->uz, path->oz), path->bz) PARAMETERS_PASS);
}
#endif
