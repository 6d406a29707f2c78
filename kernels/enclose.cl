// Enclosures of f, W at a time: boxes or pieces of rays, whose coordinates the host rounded outward. With IRT_ALONG, of its derivative
// along the ray: tests read here what root finders go by.
//
// coordinates: planar with the stride given; three reals an axis: lo, hi, 0 (intervals) or x, y, z (affine forms); then those of directions.
#define TERM(k) LOAD(coordinates + (k) * (size_t)stride + at)

// Not inlined, as in trace.cl.
__attribute__((noinline)) void enclose_packet(const size_t at, __global const real* coordinates, const int stride, __global real* lower,
                                              __global real* upper PARAMETERS) {
  I undefined = NONE, rough;
#if IRT_AFFINE
  const RA x = ra(TERM(0), TERM(1), TERM(2)), y = ra(TERM(3), TERM(4), TERM(5)), z = ra(TERM(6), TERM(7), TERM(8));
#if IRT_ALONG
  const RA dx = ra(TERM(9), TERM(10), TERM(11)), dy = ra(TERM(12), TERM(13), TERM(14)), dz = ra(TERM(15), TERM(16), TERM(17));
#elif IRT_SLACK
  const IA f = bare_range(bare(bare_ra(x.x, x.y, x.z), bare_ra(y.x, y.y, y.z), bare_ra(z.x, z.y, z.z) PARAMETERS_PASS));
#elif FORM_HAS_RANGE
  const FORM both = irt_affine(x, y, z PARAMETERS_PASS, &undefined, &rough);
  const IA f = ia(both.lo, both.hi);
#else
  const IA f = ra_range(irt_affine(x, y, z PARAMETERS_PASS, &undefined, &rough));
#endif
#else
  const IA x = ia(TERM(0), TERM(1)), y = ia(TERM(3), TERM(4)), z = ia(TERM(6), TERM(7));
#if IRT_ALONG
  const IA dx = ia(TERM(9), TERM(10)), dy = ia(TERM(12), TERM(13)), dz = ia(TERM(15), TERM(16));
#elif IRT_SLACK
  const IA f = bare_range(bare(bare_ia(x.lo, x.hi), bare_ia(y.lo, y.hi), bare_ia(z.lo, z.hi) PARAMETERS_PASS));
#else
  const IA f = irt_interval(x, y, z PARAMETERS_PASS, &undefined, &rough);
#endif
#endif
#if IRT_ALONG
  const IA f = irt_along(x, y, z, dx, dy, dz PARAMETERS_PASS, &undefined, &rough);
  undefined |= rough;  // it tells nothing where f may jump
#endif
  STORE(SELECT(undefined, (F)NAN, f.lo), lower + at);
  STORE(SELECT(undefined, (F)NAN, f.hi), upper + at);
}

__kernel __attribute__((vec_type_hint(F))) void enclose_pieces(__global const real* coordinates, const int stride, __global real* lower,
                             __global real* upper PARAMETERS, const int first_column, const int first_row) {
  enclose_packet(W * (first_column + get_global_id(0)), coordinates, stride, lower, upper PARAMETERS_PASS);
}
