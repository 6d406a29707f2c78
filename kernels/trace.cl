// The kernel of a call: ray, clip, root, normal, colour, for one packet of rays.
#define TRACE_DECL RAY_DECL, __global const real *q, const int pitch, const int max_pieces, RESULTS_DECL ARGUMENTS
#define TRACE_PASS RAY_PASS, q, pitch, max_pieces, RESULTS_PASS ARGUMENTS_PASS

// Not inlined: PoCL makes three functions of every kernel, and would compile all of this in each. The hint tells drivers that
// packets are vectors already (Intel's would try to make wider ones, for seconds).
__attribute__((noinline)) void trace_packet(const size_t column, const size_t row, TRACE_DECL) {
  const RAY ray = make_ray(RAY_PASS, q, column, row);
  const RANGE range = clip_ray(&ray, q);
  const ROOT root = find_root(&ray, &range, q, max_pieces FINDER_PASS);
  write_results(&ray, &root, row * pitch + column * W, q, RESULTS_PASS PARAMETERS_PASS);
}

// One work-item has `packets` of a row: drivers for CPUs spend as much on a work-item as a packet that misses takes.
__kernel __attribute__((vec_type_hint(F))) void trace(TRACE_DECL, const int packets, const int first_column, const int first_row) {
  const size_t first = (first_column + get_global_id(0)) * packets, end = min(first + packets, (size_t)(pitch / W));
  for (size_t column = first; column < end; ++column) trace_packet(column, first_row + get_global_id(1), TRACE_PASS);
}
