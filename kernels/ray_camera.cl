// Rays of a camera: sums of a term per column and a term per row, which the host computed in double.
//
// columns, rows: for each, P (3), D (3), its share of |D|^2 and (rows) tau, planar with the strides given.

#if IRT_LIST  // the pixels of a list: column and row of each
#define RAY_DECL \
  __global const wide *columns, __global const wide *rows, const int column_stride, const int row_stride, \
      __global const int *list
#define RAY_PASS columns, rows, column_stride, row_stride, list
static inline FW gather(__global const wide* from, __global const int* index) {
#if W == 1
  return from[index[0]];
#else
  wide lanes[W];
  for (int i = 0; i < W; ++i) lanes[i] = from[index[2 * i]];
  return LOAD_WIDE(lanes);
#endif
}
#define COLUMN_TERM(k) gather(columns + (k) * column_stride, list + 2 * W * column)
#define ROW_TERM(k) gather(rows + (k) * row_stride, list + 2 * W * column + 1)
#else
#define RAY_DECL __global const wide *columns, __global const wide *rows, const int column_stride, const int row_stride
#define RAY_PASS columns, rows, column_stride, row_stride
#if IRT_BEAMS  // packets are in tiles (beams.cl)
#define COLUMN_TERM(k) LOAD_WIDE(columns + (k) * column_stride + W * column)
#define ROW_TERM(k) LOAD_WIDE(rows + (k) * row_stride + W * row)
#else
#define COLUMN_TERM(k) OF_COLUMNS(columns + (k) * column_stride + PACKET_WIDTH * column)
#define ROW_TERM(k) OF_ROWS(FW, rows + (k) * row_stride + PACKET_HEIGHT * row)
#endif
#endif

// One axis: position, direction, and the error of any coordinate on the ray: the rounding of both terms, of their sum,
// of the entry point, of the steps along the ray, and of the evaluation: eight half-ulps of the magnitudes' sum.
#if IRT_SPLIT
#define AXIS(p, d, e, wp, wd, k) \
  { \
    wp = COLUMN_TERM(k) + ROW_TERM(k); \
    wd = COLUMN_TERM(3 + k) + ROW_TERM(3 + k); \
    p = NARROW(wp); \
    d = NARROW(wd); \
    e = fma((F)(R(4.0) * ULP), fma((F)RADIUS, fabs(d), fabs(p)), (F)POSITION_PAD); \
  }
#else
#define AXIS(p, d, e, wp, wd, k) \
  { \
    const F pc = COLUMN_TERM(k), pr = ROW_TERM(k), dc = COLUMN_TERM(3 + k), dr = ROW_TERM(3 + k); \
    p = pc + pr; \
    d = dc + dr; \
    e = fma((F)(R(4.0) * ULP), fma((F)RADIUS, fabs(dc) + fabs(dr), fabs(pc) + fabs(pr)), (F)POSITION_PAD); \
  }
#endif

#define EARLIEST(ray) ((F)0)  // no depth is reported before it

static inline RAY make_ray(RAY_DECL, __global const real* q, size_t column, size_t row) {
  RAY r;
  AXIS(r.px, r.dx, r.ex, r.wpx, r.wdx, 0)
  AXIS(r.py, r.dy, r.ey, r.wpy, r.wdy, 1)
  AXIS(r.pz, r.dz, r.ez, r.wpz, r.wdz, 2)
  r.tau = ROW_TERM(7);
  r.length = careful_sqrt(COLUMN_TERM(6) + ROW_TERM(6));
  r.near_out = (F)NEAR_OUT;
  r.near_in = (F)NEAR_IN;
  r.far_out = r.far_in = INF;
  return r;
}
