// The frustum form (S2 section 3): the polynomial over a tile of the screen and a slab of depth, contracted to the rays of a packet.
//
// A tile's cells come front to back; what lies between them is proven free of zeros (cpp/numerics/frustum_form.h). The method's own
// file finds the first root within a cell. Coefficients of a cell are scaled to lie within [-2, 2], with one bound of their error.
//
// tiles: where each tile's cells begin. slabs: for each cell s at its near end, its length, its error. form: [depth][down][across],
// lines across padded to packets. basis: the view (VIEW), then B_i and its derivative at the centres of a tile's pixels.
#define LINE ((N + W - 1) / W * W)
#define VIEW(k) basis[k]  // right, up, forward, a tile across and down, perspective, distance
#define ACROSS(i) (basis + 16 + (i) * IRT_TILE)
#define SLOPE(i) (basis + 16 + (N + (i)) * IRT_TILE)

// Coefficients along the rays of a packet: lines across are contracted with the row, once for all lanes, then with the columns.
static inline void contract_form(__global const real* form, __global const real* basis, int column, int row, __global const real* across,
                                 __global const real* down, F* c) {
  for (int k = 0; k < N; ++k) {
    real line[LINE];
    for (int b = 0; b < LINE; b += W) {
      F sum = (F)0;
      for (int j = 0; j < N; ++j) sum = fma(LOAD(form + (k * N + j) * LINE + b), (F)down[j * IRT_TILE + row], sum);
      STORE(sum, line + b);
    }
    F sum = (F)0;
    for (int i = 0; i < N; ++i) sum = fma((F)line[i], LOAD(across + i * IRT_TILE + column), sum);
    c[k] = sum;
  }
}

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces FINDER) {
  ROOT root;
  root.status = MISS;
  root.half_width = (F)0;
  F at = (F)0, at_near = (F)0, at_length = (F)0;
#if IRT_GRADIENT_FOUND
  root.gx = root.gy = root.gz = (F)0;
#endif
  I active = LE(range->out0, range->out1);
  FOUND found;
#if IRT_PIECES
  found.pieces = NONE;
#endif
  const int first = W * (int)packet, tile_x = first / IRT_TILE - tile_x0, tile_y = (int)pixel_row / IRT_TILE - tile_y0;
  const bool on_screen = tile_x >= 0 && tile_y >= 0 && tile_x < tile_columns && tile_y < tile_rows;
  const int tile = on_screen ? tile_y * tile_columns + tile_x : 0, column = first % IRT_TILE, row = (int)pixel_row % IRT_TILE;
  const int end = on_screen ? tiles[tile + 1] : 0;
  for (int k = on_screen ? tiles[tile] : 0; k < end && ANY(active); ++k) {
    const real near = slabs[4 * k], length = slabs[4 * k + 1], inverse = R(1.0) / length;
    const F slack = (F)(R(8.0) * ULP * RADIUS * inverse);
    CELL cell;
    cell.lo = clamp((range->out0 - near) * inverse - slack, (F)0, (F)1);
    cell.hi = clamp((range->out1 - near) * inverse + slack, (F)0, (F)1);
    const I lanes = active & LT(cell.lo, cell.hi);
    if (!ANY(lanes)) continue;
    __global const real* here = form + (size_t)k * (N * N * LINE);
    contract_form(here, basis, column, row, ACROSS(0), ACROSS(0), cell.c);
#if IRT_OUTWARD
    cell.error = (F)slabs[4 * k + 2];
#else
    cell.error = (F)0;
#endif
    const I open = lanes & ~one_sign(cell.c, cell.error);
    if (!ANY(open)) continue;
    cell.size = largest_of(cell.c);
    cell.in_lo = (range->in0 - near) * inverse + slack;
    cell.in_hi = (range->in1 - near) * inverse - slack;
    cell.reach = R(0.45) * (F)EPS / NARROW(ray->length) * inverse;
    found.hits = found.open = NONE;
    found.lo = found.hi = (F)0;
    search_cell(&cell, open, max_pieces, &found);
    if (!ANY(found.hits | found.open)) continue;
    const I ended = found.hits | found.open;
    const F middle = place_of(&found), s = fma(middle, (F)length, (F)near);
    root.status = SELECT(ended, status_of(&found), root.status);
    at = SELECT(ended, middle, at);
    at_near = SELECT(ended, (F)near, at_near);
    at_length = SELECT(ended, (F)length, at_length);
    root.half_width = SELECT(ended, max(found.hi - middle, middle - found.lo) * length * (R(1.0) + R(4.0) * ULP), root.half_width);
#if IRT_GRADIENT_FOUND
    if (ANY(found.hits)) {
      F slopes[N];
      contract_form(here, basis, column, row, SLOPE(0), ACROSS(0), slopes);
      const F along_x = value_at(slopes, IRT_DEGREE, middle);
      contract_form(here, basis, column, row, ACROSS(0), SLOPE(0), slopes);
      const F along_y = value_at(slopes, IRT_DEGREE, middle);
      for (int i = 0; i < IRT_DEGREE; ++i) slopes[i] = IRT_DEGREE * (cell.c[i + 1] - cell.c[i]);
      const F along_s = value_at(slopes, IRT_DEGREE - 1, middle) * inverse;
      // S2 (7): the gradient of the form is that of f times the Jacobian of the view.
      const F spread = fma((F)VIEW(11), s + (F)VIEW(12) - R(1.0), (F)1);
      const F right = along_x / (VIEW(9) * spread), up = along_y / (VIEW(10) * spread);
      const F sx = VIEW(11) * (ray->dx * VIEW(0) + ray->dy * VIEW(1) + ray->dz * VIEW(2)),
              sy = VIEW(11) * (ray->dx * VIEW(3) + ray->dy * VIEW(4) + ray->dz * VIEW(5));
      const F forward = along_s - sx * right - sy * up;
      root.gx = SELECT(found.hits, right * VIEW(0) + up * VIEW(3) + forward * VIEW(6), root.gx);
      root.gy = SELECT(found.hits, right * VIEW(1) + up * VIEW(4) + forward * VIEW(7), root.gy);
      root.gz = SELECT(found.hits, right * VIEW(2) + up * VIEW(5) + forward * VIEW(8), root.gz);
    }
#endif
    active &= ~ended;
  }
  // The ends of slabs are exact.
  root.at = fma(WIDEN(at), WIDEN(at_length), WIDEN(at_near));
#if !IRT_SPLIT
  root.half_width += ULP * (F)RADIUS;
#endif
#if IRT_PIECES
  root.pieces = found.pieces;
#endif
  return root;
}
