// The kernel of a camera whose rays are bounded by beams: one work-item has a tile of the picture. First a packet of beams, of
// BEAM x BEAM pixels each, marches as far as all their rays are proven free of zeros; then the tile's packets go on from there.
//
// Not in the papers. A beam is a ray whose coordinates err by so much that all rays of its pixels are one of it, so what is proven of the
// beam is proven of them. Beams run through the code of the rays (find_root is compiled once), a packet of them for sixteen packets of
// rays. The tables of the rays have the beams of a tile before its packets (cpp/render/camera_terms.h).
#define PACKET_COLUMNS (BEAMS_ACROSS * BEAM / PACKET_WIDTH)  // in a tile
#define PACKET_ROWS (BEAMS_DOWN * BEAM / PACKET_HEIGHT)

#define SPREAD(k) (NARROW(COLUMN_TERM(k) + ROW_TERM(k)) * (R(1.0) + R(4.0) * ULP))

// Not inlined, as in trace.cl.
__attribute__((noinline)) void trace_tile(const size_t tile_column, const size_t tile_row, TRACE_DECL) {
  real from[W], span[W], sign[W];
  for (int pass = 0; pass <= PACKET_COLUMNS * PACKET_ROWS; ++pass) {
    const int beam = pass == 0, c = beam ? 0 : (pass - 1) % PACKET_COLUMNS, r = beam ? 0 : (pass - 1) / PACKET_COLUMNS;
    const int in = c * PACKET_WIDTH / BEAM + BEAMS_ACROSS * (r * PACKET_HEIGHT / BEAM);
    const size_t first = (tile_column * PACKET_COLUMNS + c) * PACKET_WIDTH;
    if (first >= pitch) continue;
    const PLACE at = packet_at(first, (tile_row * PACKET_ROWS + r) * PACKET_HEIGHT, pitch, last_row);
    if (!beam && span[in] < 0) {
      write_misses(at, RESULTS_PASS);
      continue;
    }
    const size_t column = tile_column * (PACKET_COLUMNS + 1) + c + !beam, row = tile_row * (PACKET_ROWS + 1) + r + !beam;
    RAY ray = make_ray(RAY_PASS, q, column, row);
    HEAD head;
    ray.bx = ray.by = ray.bz = ray.wx = ray.wy = ray.wz = (F)0;
    head.from = -INF;
    if (beam) {
      ray.bx = SPREAD(8), ray.by = SPREAD(9), ray.bz = SPREAD(10);
      ray.wx = SPREAD(11), ray.wy = SPREAD(12), ray.wz = SPREAD(13);
    } else {
      head.from = (F)from[in], head.span = (F)span[in], head.sign = (F)sign[in];
    }
    // To the bounds all of a beam errs as much as it does where it is widest.
    RAY whole = ray;
    const F far = NARROW(ray.tau) + (F)RADIUS, reach = max(fma((F)(R(4.0) * ULP), fabs(NARROW(ray.tau)) + (F)RADIUS, far), (F)0);
    whole.ex += fma(reach, ray.wx, ray.bx), whole.ey += fma(reach, ray.wy, ray.by), whole.ez += fma(reach, ray.wz, ray.bz);
    const RANGE range = clip_ray(&whole, q);
    ROOT root = find_root(&ray, &range, q, beam ? BEAM_PIECES : max_pieces FINDER_PASS);
    if (beam) {
      STORE(head.from, from);
      STORE(SELECT(EQ(root.status, MISS), (F)-1, head.span), span);
      STORE(head.sign, sign);
    } else {
#if IRT_REFINES
      refine(&ray, &root, q);
#endif
      write_results(&ray, &root, at, q, RESULTS_PASS PARAMETERS_PASS);
    }
  }
}

__kernel __attribute__((vec_type_hint(F))) void trace(TRACE_DECL, const int first_column, const int first_row) {
  trace_tile(first_column + get_global_id(0), first_row + get_global_id(1), TRACE_PASS);
}
