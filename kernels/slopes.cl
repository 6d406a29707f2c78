// Values of f along a path with their derivative, both by units, for root finders that sample.
static inline F slope_at(const PATH* path, F c PARAMETERS, F* slope) {
  return irt_slope(ALONG(path, x, c), ALONG(path, y, c), ALONG(path, z, c), path->ux, path->uy, path->uz PARAMETERS_PASS, slope);
}
