// The kernel of a second pass over a frame, in double: a HIT of the first, in single precision, has proven that the first root of its ray lies in
// its bracket. So the ray is that piece and no more, and any root finder narrows it down to eps. Everything else stays what it was.
//
// first_depth, first_error, first_status: what the first pass has written, rows `first_pitch` apart.
#define FIRST_DECL __global const float *first_depth, __global const float *first_error, __global const uchar *first_status, const int first_pitch
#define TRACE_DECL RAY_DECL, __global const real *q, const int pitch, const int max_pieces, RESULTS_DECL, FIRST_DECL ARGUMENTS
#define TRACE_PASS RAY_PASS, q, pitch, max_pieces, RESULTS_PASS, first_depth, first_error, first_status, first_pitch ARGUMENTS_PASS

// Not inlined, as in trace.cl.
__attribute__((noinline)) void sharpen_packet(const size_t column, const size_t row, TRACE_DECL) {
  const size_t from = row * first_pitch + column * W, to = row * pitch + column * W;
  const I known = TO_I(LOAD(first_status + from));
  if (!ANY(known)) {
    write_misses(to, RESULTS_PASS);
    return;
  }
  const F t = TO_F(LOAD(first_depth + from)), error = TO_F(LOAD(first_error + from));
  RAY ray = make_ray(RAY_PASS, q, column, row);
  // In units of s; tau, the length and three steps here are rounded. The bracket has grown by the rounding of t since it was proven to lie inside
  // the bounds, so it is clipped again.
  const F less = R(1.0) / NARROW(ray.length), at = fma(t, less, -NARROW(ray.tau)), reach = error * less;
  const F off = (F)(R(8.0) * ULP) * (fabs(NARROW(ray.tau)) + (F)RADIUS);
  ray.near_out = max(ray.near_out, at - reach - off);
  ray.near_in = max(ray.near_in, at - reach + off);
  ray.far_out = SELECT(EQ(known, HIT), at + reach + off, -INF);
  ray.far_in = at + reach - off;
  const RANGE range = clip_ray(&ray, q);
  ROOT root = find_root(&ray, &range, q, max_pieces FINDER_PASS);
  const I kept = ~EQ(root.status, HIT);
  root.status = SELECT(kept, known, root.status);
  root.at = SELECT(kept, at, root.at);
  root.half_width = SELECT(kept, reach, root.half_width);
  write_results(&ray, &root, to, q, RESULTS_PASS PARAMETERS_PASS);
}

TRACE_KERNEL(sharpen_packet)
