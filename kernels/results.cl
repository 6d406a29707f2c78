// What a kernel writes for a packet of rays: statuses, depths, and what else was asked for. Only that is compiled.
#if IRT_PIECES
#define PIECES_DECL __global uint *pieces,
#define PIECES_PASS pieces,
#else
#define PIECES_DECL
#define PIECES_PASS
#endif

// Depths and their uncertainties: reals; or doubles, where what packets of floats have found is narrowed down further.
#if IRT_FINE
typedef wide measure;
typedef FW M;
#define TO_M(v) WIDEN(v)
#define DEPTH_ROUNDING (R(4.0) * R(0x1p-52))
#else
typedef real measure;
typedef F M;
#define TO_M(v) (v)
#define DEPTH_ROUNDING (DEPTH_ERROR * ULP)
#endif
#define RESULTS_DECL NORMAL_DECL RGB_DECL PIECES_DECL __global measure *depth, __global measure *uncertainty, __global uchar *status
#define RESULTS_PASS NORMAL_PASS RGB_PASS PIECES_PASS depth, uncertainty, status

// Where the rows of a packet lie in what is written; rows past the last repeat it.
typedef struct {
  size_t row[PACKET_HEIGHT];
} PLACE;
static inline PLACE packet_at(size_t column, size_t row, const int pitch, const int last_row) {
  PLACE at;
  for (int i = 0; i < PACKET_HEIGHT; ++i) at.row[i] = min(row + i, (size_t)last_row) * pitch + column;
  return at;
}
#if PACKET_HEIGHT == 4
#define PUT(T, v, to) \
  do { \
    const T put = v; \
    vstore4(put.lo.lo, 0, (to) + at.row[0]); \
    vstore4(put.lo.hi, 0, (to) + at.row[1]); \
    vstore4(put.hi.lo, 0, (to) + at.row[2]); \
    vstore4(put.hi.hi, 0, (to) + at.row[3]); \
  } while (0)
#elif PACKET_HEIGHT == 2
#define PUT(T, v, to) \
  do { \
    const T put = v; \
    vstore4(put.lo, 0, (to) + at.row[0]); \
    vstore4(put.hi, 0, (to) + at.row[1]); \
  } while (0)
#else
#define PUT(T, v, to) STORE(v, (to) + at.row[0])
#endif

// What is seen where rays miss.
static inline void write_background(const PLACE at, RESULTS_DECL) {
#if IRT_NORMAL
  PUT(FLOATS, (FLOATS)NAN, normal);
  PUT(FLOATS, (FLOATS)NAN, normal + (size_t)plane);
  PUT(FLOATS, (FLOATS)NAN, normal + 2 * (size_t)plane);
#endif
#if IRT_RGB
  PUT(UINT, (UINT)background, rgba);
#endif
}

// All of it for rays that are known to miss.
static inline void write_misses(const PLACE at, RESULTS_DECL) {
  PUT(M, (M)INFINITY, depth);
  PUT(BYTES, (BYTES)0, status);
  PUT(M, (M)NAN, uncertainty);
#if IRT_PIECES
  PUT(UINT, (UINT)0, pieces);
#endif
  write_background(at, RESULTS_PASS);
}

static inline void write_results(const RAY* ray, const ROOT* root, const PLACE at, __global const real* q, RESULTS_DECL PARAMETERS) {
  const I found = EQ(root->status, HIT) | EQ(root->status, TOUCH);
  const F s = NARROW(root->at), t = max(NARROW((ray->tau + root->at) * ray->length), EARLIEST(ray)), length = NARROW(ray->length);
  // Half the width of the bracket, which has room for the rounding of this product, and the rounding of t.
  const F bracket = fma(root->half_width, length, DEPTH_ROUNDING * fabs(t) + (F)POSITION_PAD);
#if IRT_FINE
  PUT(M, max((ray->tau + root->at) * ray->length, WIDEN(EARLIEST(ray))) + WIDEN(SELECT(EQ(root->status, MISS), INF, (F)0)), depth);
#else
  PUT(F, SELECT(EQ(root->status, MISS), INF, t), depth);
#endif
  PUT(BYTES, TO_BYTES(root->status), status);
#if IRT_PIECES
  PUT(UINT, TO_UINT(root->pieces), pieces);
#endif
#if IRT_OUTWARD
  PUT(M, TO_M(SELECT(EQ(root->status, HIT), bracket, (F)NAN)), uncertainty);
#else
  PUT(M, (M)NAN, uncertainty);
#endif
#if IRT_NORMAL || IRT_RGB
  const F less = R(1.0) / length;
  const F vx = -ray->dx * less, vy = -ray->dy * less, vz = -ray->dz * less;
#if IRT_GRADIENT_FOUND
  const NORMAL n = normal_along(root->gx, root->gy, root->gz, found, vx, vy, vz);
#else
  const NORMAL n = normal_at(ray, s, found, vx, vy, vz PARAMETERS_PASS);
#endif
#endif
#if IRT_NORMAL
  PUT(FLOATS, TO_FLOATS(n.x), normal);
  PUT(FLOATS, TO_FLOATS(n.y), normal + (size_t)plane);
  PUT(FLOATS, TO_FLOATS(n.z), normal + 2 * (size_t)plane);
#endif
#if IRT_RGB
  PUT(UINT, shade(root->status, n.front, n.x, n.y, n.z, vx, vy, vz, background, q), rgba);
#endif
}

// What the packets of a work-item share (frustum_cells.cl).
#ifndef SHARED_DECL
#define SHARED_BEGIN
#define SHARED_DECL
#define SHARED_PASS
#endif

#define TRACE_DECL RAY_DECL, __global const real *q, const int pitch, const int max_pieces, RESULTS_DECL ARGUMENTS, const int last_row
#define TRACE_PASS RAY_PASS, q, pitch, max_pieces, RESULTS_PASS ARGUMENTS_PASS, last_row

// The kernel of a call, by what does one packet. A work-item has `packets` of a row: drivers for CPUs spend as much on a work-item as a packet
// that misses takes. The hint tells them that packets are vectors already (Intel's would try to make wider ones, for seconds).
#define TRACE_KERNEL(trace_one) \
  __kernel __attribute__((vec_type_hint(F))) void trace(TRACE_DECL, const int packets, const int first_column, const int first_row) { \
    const size_t first = (first_column + get_global_id(0)) * packets, end = min(first + packets, (size_t)(pitch / PACKET_WIDTH)); \
    SHARED_BEGIN \
    for (size_t column = first; column < end; ++column) trace_one(column, first_row + get_global_id(1), TRACE_PASS SHARED_PASS); \
  }
