// Values of f along a path with their derivative, by units, and the length of the gradient, for root finders that sample.
static inline F gradient_at(const PATH* path, F c PARAMETERS, F* slope, F* steepest) {
  F gx, gy, gz;
  const F f = irt_gradient(ALONG(path, x, c), ALONG(path, y, c), ALONG(path, z, c) PARAMETERS_PASS, &gx, &gy, &gz);
  *slope = fma(gx, path->ux, fma(gy, path->uy, gz * path->uz));
  *steepest = sqrt(fma(gx, gx, fma(gy, gy, gz * gz)));
  return f;
}
