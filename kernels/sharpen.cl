// The kernel of a second pass over a frame, in double: a HIT of the first, in single precision, has proven that the first root of its ray lies in
// its bracket. So the ray is that piece and no more, and any root finder narrows it down to eps. Everything else stays what it was: results are read
// where they are written.
#define GROWN R(0x1p-20)  // of a bracket's width: more than rounding outward, in floats, has added since it was proven (path.cl, results.cl)

// Not inlined, as in trace.cl.
__attribute__((noinline)) void sharpen_packet(const size_t column, const size_t row, TRACE_DECL) {
  const PLACE place = packet_at(column * W, row, pitch, last_row);
  const size_t here = place.row[0];
  const I known = TO_I(LOAD(status + here));
  if (!ANY(known)) {
    write_background(place, RESULTS_PASS);
    return;
  }
  const F t = LOAD(depth + here), error = LOAD(uncertainty + here);
  const RAY ray = make_ray(RAY_PASS, q, column, row);
  // In units of s; tau, the length and three steps here are rounded. Only the bracket as it was proven lies inside the bounds: what has been added since
  // may hold a root outside.
  const F less = R(1.0) / NARROW(ray.length), at = fma(t, less, -NARROW(ray.tau)), reach = error * less;
  const F off = (F)(R(8.0) * ULP) * (fabs(NARROW(ray.tau)) + (F)RADIUS), added = fma((F)GROWN, reach, fma((F)POSITION_PAD, less, off));
  RANGE range;
  range.out0 = max(ray.near_out, at - reach - off);
  range.in0 = max(ray.near_in, at - reach + added);
  range.out1 = SELECT(EQ(known, HIT), at + reach + off, -INF);
  range.in1 = at + reach - added;
  ROOT root = find_root(&ray, &range, q, max_pieces FINDER_PASS);
  const I kept = ~EQ(root.status, HIT);
  root.status = SELECT(kept, known, root.status);
  root.at = SELECT(kept, at, root.at);
  root.half_width = SELECT(kept, reach, root.half_width);
#if IRT_PIECES
  root.pieces += TO_I(LOAD(pieces + here));
#endif
  write_results(&ray, &root, place, q, RESULTS_PASS PARAMETERS_PASS);
}

TRACE_KERNEL(sharpen_packet)
