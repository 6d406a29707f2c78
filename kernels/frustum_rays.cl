// Any batch of rays: the host has made the Bernstein coefficients of each (S2 section 4.1 without the frustum).
//
// rays_form: planar, coefficients and the bound of their error. s runs from -reach_s to reach_s.
static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces FINDER) {
  const real length = R(2.0) * reach_s, inverse = R(1.0) / length;
  const F slack = (F)(R(8.0) * ULP);
  CELL cell;
  for (int k = 0; k < N; ++k) cell.c[k] = LOAD(rays_form + k * stride + W * packet);
#if IRT_OUTWARD
  cell.error = LOAD(rays_form + N * stride + W * packet);
#else
  cell.error = (F)0;
#endif
  cell.size = largest_of(cell.c);
  cell.lo = clamp((range->out0 + reach_s) * inverse - slack, (F)0, (F)1);
  cell.hi = clamp((range->out1 + reach_s) * inverse + slack, (F)0, (F)1);
  cell.in_lo = (range->in0 + reach_s) * inverse + slack;
  cell.in_hi = (range->in1 + reach_s) * inverse - slack;
  cell.reach = REACH(ray, EPS) * inverse;
  FOUND found;
#if IRT_PIECES
  found.pieces = NONE;
#endif
  found.hits = found.touches = NONE;
  found.lo = cell.lo;
  found.hi = cell.hi;
  const I open = LE(range->out0, range->out1) & LT(cell.lo, cell.hi) & ~one_sign(cell.c, cell.error), lanes = open & LT(cell.error, INF);
  found.spent = open & ~lanes;  // coefficients beyond all reals
  if (ANY(lanes)) search_cell(&cell, lanes, max_pieces, &found);
  const F place = place_of(&found);
  ROOT root;
  root.status = status_of(&found);
  root.at = fma(WIDEN(place), (FW)length, (FW)(-reach_s));
  root.half_width = max(found.hi - place, place - found.lo) * length * (R(1.0) + R(4.0) * ULP);
#if !IRT_SPLIT
  root.half_width += ULP * (F)RADIUS;
#endif
#if IRT_GRADIENT_FOUND  // by the host, afterwards
  root.gx = root.gy = root.gz = (F)NAN;
#endif
#if IRT_PIECES
  root.pieces = found.pieces;
#endif
  return root;
}
