// Results that were found elsewhere (the reference's way): depth and gradient are given, the kernel shades them.
//
// given: status, s, half the width of the bracket, the gradient, planar with the stride given.
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces FINDER) {
  ROOT root;
  root.status = TO_I(LOAD(given + W * packet));
  root.at = WIDEN(LOAD(given + stride + W * packet));
  root.half_width = LOAD(given + 2 * stride + W * packet);
#if IRT_GRADIENT_FOUND
  root.gx = LOAD(given + 3 * stride + W * packet);
  root.gy = LOAD(given + 4 * stride + W * packet);
  root.gz = LOAD(given + 5 * stride + W * packet);
#endif
#if IRT_PIECES
  root.pieces = NONE;
#endif
  return root;
}
