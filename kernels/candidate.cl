// Candidates: short pieces of ray at which a root is to be proven by the sign at the start, the opposite sign behind the end, f continuous
// between, and all of it inside the clip region where there is one. What the finders that march share of that.
#define MARGIN R(0.25)  // of a piece, beyond its end
// From the floor brackets widen a little at a time, so that they are hardly wider than they must be. Both ways lead to about a
// thousandth of the path; in double that is a long way, and formulas that cancel (expanded high degrees) need all of it.
#if IRT_DOUBLE
#define WIDENINGS 64
#define WIDER R(1.5)
#else
#define WIDENINGS 48
#define WIDER R(1.25)
#endif

#define LOWEST_BIT(v) ((v) & -(v))

// What comes of lanes that `tried`: signs first; then, where there is more to prove, the whole piece (`checking`).
#if IRT_PARTIAL || IRT_CLIP
#define JUDGE(tried) \
  const I opposite = (tried) & ~checking & ((above & is_below) | (below & is_above)); \
  const I proven = (tried) & checking & inside & ~rough, failed = (tried) & ~proven & ~opposite; \
  checking = opposite;
#else
#define JUDGE(tried) const I opposite = (tried) & ((above & is_below) | (below & is_above)), proven = opposite, failed = (tried) & ~opposite;
#endif

// And of those that failed: at the last length the bracket widens, `most` times, and is given up; before, the piece is halved.
#if IRT_OUTWARD
#define AFTER_FAILURE(failed, last, most) \
  const I widens = (failed) & (last) & LT(tries, (I)(most)) & LT(behind, path.in1), gives_up = (failed) & (last) & ~widens, halves = (failed) & ~(last);
#else
// As the papers do: the first piece that is short enough ends the search; HIT where the computed signs at its ends differ.
#define AFTER_FAILURE(failed, last, most) const I widens = NONE, gives_up = (failed), halves = NONE;
#endif
