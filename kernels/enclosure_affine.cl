// Enclosures of f over a piece of ray by reduced affine arithmetic: e runs along the piece (S1 section 4.3).

typedef RA FORM;

#if IRT_OUTWARD
#define COORDINATE_ERROR(e) (e)
#define CERTAIN(v) ((v) * (R(1.0) - R(3.0) * ULP))  // covers the rounding of |y| + z
#else
#define COORDINATE_ERROR(e) ((F)0)
#define CERTAIN(v) (v)
#endif

// f over the piece from `from` to `to`, in units of the path.
static inline FORM enclose(const PATH* path, F from, F to PARAMETERS, I* undefined, I* rough) {
  const F middle = R(0.5) * (from + to), span = R(0.5) * (to - from);
  return irt_affine(ra(fma(middle, path->ux, path->ox), span * path->ux, COORDINATE_ERROR(path->ex)),
                    ra(fma(middle, path->uy, path->oy), span * path->uy, COORDINATE_ERROR(path->ey)),
                    ra(fma(middle, path->uz, path->oz), span * path->uz, COORDINATE_ERROR(path->ez))
                    PARAMETERS_PASS, undefined, rough);
}

static inline I positive(FORM f) { return GT(CERTAIN(f.x), ra_rad(f)); }
static inline I negative(FORM f) { return LT(CERTAIN(f.x), -ra_rad(f)); }
static inline I unbounded(FORM f) { return ~LT(fabs(f.x) + ra_rad(f), INF); }
