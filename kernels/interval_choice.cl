// Conditions over intervals, and choices between branches.

// A condition over an interval: true everywhere, false everywhere, or neither.
typedef struct {
  I yes, no;
} TRI;

static inline TRI tri(I yes, I no) {
  TRI r;
  r.yes = yes;
  r.no = no;
  return r;
}

static inline TRI tri_less(IA a, IA b) { return tri(LT(a.hi, b.lo), GE(a.lo, b.hi)); }
static inline TRI tri_less_equal(IA a, IA b) { return tri(LE(a.hi, b.lo), GT(a.lo, b.hi)); }
static inline TRI tri_equal(IA a, IA b) {
  return tri(EQ(a.lo, b.hi) & EQ(a.hi, b.lo), LT(a.hi, b.lo) | GT(a.lo, b.hi));
}
// Where `unsure`, the condition decides nothing.
static inline TRI tri_unless(TRI a, I unsure) { return tri(a.yes & ~unsure, a.no & ~unsure); }
static inline TRI tri_not(TRI a) { return tri(a.no, a.yes); }
static inline TRI tri_and(TRI a, TRI b) { return tri(a.yes & b.yes, a.no | b.no); }
static inline TRI tri_or(TRI a, TRI b) { return tri(a.yes | b.yes, a.no & b.no); }

// a where the condition holds, else b; their hull where it may do either, except for a branch that is undefined there.
static inline IA ia_select(TRI c, IA a, IA b, I a_undefined, I b_undefined) {
  const I only_a = c.yes | (~c.no & b_undefined), only_b = c.no | (~c.yes & a_undefined);
  return ia(SELECT(only_a, a.lo, SELECT(only_b, b.lo, min(a.lo, b.lo))), SELECT(only_a, a.hi, SELECT(only_b, b.hi, max(a.hi, b.hi))));
}
