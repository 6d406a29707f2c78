// The kernel of a call: ray, clip, root, normal, colour, for one packet of rays. Only what was asked for is compiled.
#if IRT_PIECES
#define PIECES_DECL __global uint *pieces,
#define PIECES_PASS pieces,
#else
#define PIECES_DECL
#define PIECES_PASS
#endif
#define TRACE_DECL \
  RAY_DECL, __global const real *q, const int pitch, const int max_pieces, NORMAL_DECL RGB_DECL PIECES_DECL __global real *depth, \
      __global real *uncertainty, __global uchar *status ARGUMENTS
#define TRACE_PASS RAY_PASS, q, pitch, max_pieces, NORMAL_PASS RGB_PASS PIECES_PASS depth, uncertainty, status ARGUMENTS_PASS

// Not inlined: PoCL makes three functions of every kernel, and would compile all of this in each. The hint tells drivers that
// packets are vectors already (Intel's would try to make wider ones, for seconds).
__attribute__((noinline)) void trace_packet(const size_t column, const size_t row, TRACE_DECL) {
  const size_t at = row * pitch + column * W;
  const RAY ray = make_ray(RAY_PASS, q, column, row);
  const RANGE range = clip_ray(&ray, q);
  const ROOT root = find_root(&ray, &range, q, max_pieces FINDER_PASS);
  const I found = EQ(root.status, HIT) | EQ(root.status, TOUCH);
  const F s = NARROW(root.at), t = max(NARROW((ray.tau + root.at) * ray.length), (F)0), length = NARROW(ray.length);
  // Half the width of the bracket, and the rounding of t.
#if IRT_SPLIT
  const F bracket = fma(root.half_width, length * (R(1.0) + R(4.0) * ULP), R(0.75) * ULP * t + (F)POSITION_PAD);
#else
  const F bracket = fma(root.half_width, length * (R(1.0) + R(4.0) * ULP), R(4.0) * ULP * (t + (F)POSITION_PAD));
#endif
  STORE(SELECT(EQ(root.status, MISS), INF, t), depth + at);
  STORE_BYTES(root.status, status + at);
#if IRT_PIECES
  STORE_UINT(TO_UINT(root.pieces), pieces + at);
#endif
#if IRT_OUTWARD
  STORE(SELECT(EQ(root.status, HIT), bracket, (F)NAN), uncertainty + at);
#else
  STORE((F)NAN, uncertainty + at);
#endif
#if IRT_NORMAL || IRT_RGB
  const F less = R(1.0) / length;
  const F vx = -ray.dx * less, vy = -ray.dy * less, vz = -ray.dz * less;
#if IRT_GRADIENT_FOUND
  const NORMAL n = normal_along(root.gx, root.gy, root.gz, found, vx, vy, vz);
#else
  const NORMAL n = normal_at(&ray, s, found, vx, vy, vz PARAMETERS_PASS);
#endif
#endif
#if IRT_NORMAL
  STORE_FLOAT(n.x, normal + at);
  STORE_FLOAT(n.y, normal + (size_t)plane + at);
  STORE_FLOAT(n.z, normal + 2 * (size_t)plane + at);
#endif
#if IRT_RGB
  STORE_UINT(shade(root.status, n.front, n.x, n.y, n.z, vx, vy, vz, background, q), rgba + at);
#endif
}

__kernel __attribute__((vec_type_hint(F))) void trace(TRACE_DECL, const int first_column, const int first_row) {
  trace_packet(first_column + get_global_id(0), first_row + get_global_id(1), TRACE_PASS);
}
