// The frustum form (S2 section 3): the polynomial over a tile of the screen and a slab of depth, contracted to the rays of a packet.
//
// A tile's cells come front to back; what lies between them is proven free of zeros (cpp/numerics/frustum_form.h). The method's own
// file finds the first root within a cell. Coefficients of a cell are scaled to lie within [-2, 2], with one bound of their error.
//
// tiles: where each tile's cells begin. shapes: for each cell how many lines down and coefficients across it has, and where they begin; then the same of
// frustum_fine.cl. slabs: s at its near end, its length, its error and that of frustum_fine.cl. form: [down][depth][across], and some vectors more behind the last. basis: the view (VIEW), then
// `terms` polynomials and their slopes at the centres of a tile's pixels.
#define VIEW(k) basis[k]  // right, up, forward, a tile across and down, perspective, distance, that of the frame before
#define ACROSS (basis + 16)
#define SLOPE (basis + 16 + terms * IRT_TILE)

// The packets of a work-item lie side by side in a row: those in one tile share what its first cells become by contraction with the row. PLANE takes that from
// `planes`, by whose bits in `known` it is there already, or makes it, elsewhere for later cells.
#if W > 1 && IRT_TILE > W && !IRT_LIST
#define MOST_SHARED (N <= 13 ? 8 : 2)
typedef struct {
  int tile, known;
  real planes[MOST_SHARED][N * IRT_MOST_TERMS + W];
#if IRT_FINE
  int fine_known;
  wide fine_planes[MOST_SHARED][FINE_TERMS * IRT_MOST_TERMS + W];
#endif
} SHARED;
#define SHARED_BEGIN SHARED shared[1]; shared->tile = -1;
#define SHARED_DECL , SHARED *shared
#define SHARED_PASS , shared
#define PLANE(plane, planes, known, own, contraction) \
  const bool shares##plane = k - tiles[tile] < MOST_SHARED; \
  plane = shares##plane ? shared->planes[k - tiles[tile]] : own; \
  if (!shares##plane || !(shared->known >> (k - tiles[tile]) & 1)) contraction(plane); \
  if (shares##plane) shared->known |= 1 << (k - tiles[tile]);
#else
#define SHARED_BEGIN
#define SHARED_DECL
#define SHARED_PASS
#define PLANE(plane, planes, known, own, contraction) \
  plane = own; \
  contraction(plane);
#endif

#define CONTRACTED(plane) contract_row(here, row, ACROSS, down, N * across, plane)
#define FINE_CONTRACTED(plane) contract_fine_row(fine_form + (size_t)shapes[6 * k + 5] * CELL_STEP, row, FINE_ACROSS, shapes[6 * k + 3], FINE_TERMS * shapes[6 * k + 4], plane)

static inline ROOT find_root(const RAY* ray, const RANGE* range, __global const real* q, const int max_pieces FINDER SHARED_DECL) {
  ROOT root;
  root.status = MISS;
  root.half_width = (F)0;
#if IRT_FINE
  root.at = (FW)0;
#else
  F at = (F)0, at_near = (F)0, at_length = (F)0;
#endif
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
#if IRT_PREVIOUS
  // Where the frame before had its root: depths as then, from a plane through the middle of the bounds.
  const F before = TO_F(LOAD(previous + pixel_row * previous_pitch + first)) / NARROW(ray->length) - (F)VIEW(13);
#endif
#ifdef MOST_SHARED
  if (shared->tile != tile) {
    shared->tile = tile;
    shared->known = 0;
#if IRT_FINE
    shared->fine_known = 0;
#endif
  }
#endif
  for (int k = on_screen ? tiles[tile] : 0; k < end && ANY(active); ++k) {
    const real near = slabs[4 * k], length = slabs[4 * k + 1], inverse = R(1.0) / length;
    const F slack = (F)(R(8.0) * ULP * max(RADIUS * inverse, R(1.0)));
    CELL cell;
    cell.lo = clamp((range->out0 - near) * inverse - slack, (F)0, (F)1);
    cell.hi = clamp((range->out1 - near) * inverse + slack, (F)0, (F)1);
    const I lanes = active & LT(cell.lo, cell.hi);
    if (!ANY(lanes)) continue;
    const int down = shapes[6 * k], across = shapes[6 * k + 1];
    __global const real* here = form + (size_t)shapes[6 * k + 2] * CELL_STEP;
    real own[N * IRT_MOST_TERMS + W];
    real* plane;
    PLANE(plane, planes, known, own, CONTRACTED)
    contract_columns(plane, column, ACROSS, across, cell.c);
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
#if IRT_PREVIOUS
    cell.guess = (before - near) * inverse;
#endif
    cell.reach = REACH(ray, FIRST_EPS) * inverse;
    found.hits = found.touches = found.spent = NONE;
    found.lo = found.hi = (F)0;
    search_cell(&cell, open, max_pieces, &found);
    const I ended = found.hits | found.touches | found.spent, shown = found.hits | found.touches;
    if (!ANY(ended)) continue;
    const F middle = place_of(&found), s = fma(middle, (F)length, (F)near);
    root.status = SELECT(ended, status_of(&found), root.status);
    root.half_width = SELECT(ended, max(found.hi - middle, middle - found.lo) * length * (R(1.0) + R(4.0) * ULP), root.half_width);
#if IRT_FINE
    root.at = SELECT_WIDE(ended, fma(WIDEN(middle), (FW)length, (FW)near), root.at);
    if (ANY(found.hits)) {
      wide fine_own[FINE_TERMS * IRT_MOST_TERMS + W], *fine_plane;
      PLANE(fine_plane, fine_planes, fine_known, fine_own, FINE_CONTRACTED)
      refine(ray, &root, found.hits, q, near, length, slabs[4 * k + 3], column, fine_plane, shapes[6 * k + 4], fine_basis);
    }
#else
    at = SELECT(ended, middle, at);
    at_near = SELECT(ended, (F)near, at_near);
    at_length = SELECT(ended, (F)length, at_length);
#endif
#if IRT_GRADIENT_FOUND
    if (ANY(shown)) {
      F slopes[N];
      contract_columns(plane, column, SLOPE, across, slopes);
      const F along_x = value_at(slopes, IRT_DEGREE, middle);
      contract_row(here, row, SLOPE, down, N * across, own);
      contract_columns(own, column, ACROSS, across, slopes);
      const F along_y = value_at(slopes, IRT_DEGREE, middle);
      for (int i = 0; i < IRT_DEGREE; ++i) slopes[i] = IRT_DEGREE * (cell.c[i + 1] - cell.c[i]);
      const F along_s = value_at(slopes, IRT_DEGREE - 1, middle) * inverse;
      // S2 (7): the gradient of the form is that of f times the Jacobian of the view.
      const F spread = fma((F)VIEW(11), s + (F)VIEW(12) - R(1.0), (F)1);
      const F right = along_x / (VIEW(9) * spread), up = along_y / (VIEW(10) * spread);
      const F sx = VIEW(11) * (ray->dx * VIEW(0) + ray->dy * VIEW(1) + ray->dz * VIEW(2)),
              sy = VIEW(11) * (ray->dx * VIEW(3) + ray->dy * VIEW(4) + ray->dz * VIEW(5));
      const F forward = along_s - sx * right - sy * up;
      root.gx = SELECT(shown, right * VIEW(0) + up * VIEW(3) + forward * VIEW(6), root.gx);
      root.gy = SELECT(shown, right * VIEW(1) + up * VIEW(4) + forward * VIEW(7), root.gy);
      root.gz = SELECT(shown, right * VIEW(2) + up * VIEW(5) + forward * VIEW(8), root.gz);
    }
#endif
    active &= ~ended;
  }
#if !IRT_FINE
  // The ends of slabs are exact.
  root.at = fma(WIDEN(at), WIDEN(at_length), WIDEN(at_near));
#endif
#if !IRT_SPLIT
  root.half_width += ULP * (F)RADIUS;
#endif
#if IRT_PIECES
  root.pieces = found.pieces;
#endif
  return root;
}
