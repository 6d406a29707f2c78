// Values of f along a path, in units, for root finders that sample.

static inline F value_at(const PATH* path, F c PARAMETERS) { return irt_value(ALONG(path, x, c), ALONG(path, y, c), ALONG(path, z, c) PARAMETERS_PASS); }

// Whether a zero there counts.
static inline I counts_at(const PATH* path, F c PARAMETERS) {
#if IRT_CLIP
  return LE(irt_region(ALONG(path, x, c), ALONG(path, y, c), ALONG(path, z, c) PARAMETERS_PASS), (F)0);
#else
  return ALL;
#endif
}
