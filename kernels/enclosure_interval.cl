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

