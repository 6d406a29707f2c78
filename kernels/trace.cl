// The kernel of a call: ray, clip, root, normal, colour, for one packet of rays.
// Not inlined: PoCL makes three functions of every kernel, and would compile all of this in each.
__attribute__((noinline)) void trace_packet(const size_t column, const size_t row, TRACE_DECL SHARED_DECL) {
  const RAY ray = make_ray(RAY_PASS, q, column, row);
  const RANGE range = clip_ray(&ray, q);
  ROOT root = find_root(&ray, &range, q, max_pieces FINDER_PASS SHARED_PASS);
#if IRT_REFINES
  refine(&ray, &root, q);
#endif
  write_results(&ray, &root, packet_at(column * PACKET_WIDTH, row * PACKET_HEIGHT, pitch, last_row), q, RESULTS_PASS PARAMETERS_PASS);
}

TRACE_KERNEL(trace_packet)
