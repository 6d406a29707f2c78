// Packets: one work-item carries W rays, one per lane, of `real` (float or double).
//
// The generated header before this file defines W, the types real, F (W reals), I (W integers of the same size, used
// as masks: all bits set or none), and LOAD, STORE, TO_F, TO_I, TO_BYTES, INDEX, IRT_DOUBLE. Every other kernel file
// is written with the macros below and never for one width. A GPU runs the same source with W = 1.

#if W == 1
#define MASK(c) (-(I)(c))
#define SELECT(m, a, b) ((m) ? (a) : (b))
#define ANY(m) ((m) != 0)
#else
#define MASK(c) (c)
#define SELECT(m, a, b) select(b, a, m)
#define ANY(m) any_lane(m)
#endif

#if W > 1
#ifdef __has_builtin  // nested: a preprocessor without it could not read the condition
#if __has_builtin(__builtin_reduce_or)
#define any_lane(m) (__builtin_reduce_or(m) != 0)
#endif
#endif
#ifndef any_lane
// Of masks. Quarters and halves are joined; PoCL makes forty instructions and eight branches of `any`.
static inline int any_lane(I m) {
#if W == 16
#define FOUR(m) ((m.lo.lo | m.lo.hi) | (m.hi.lo | m.hi.hi))
#elif W == 8
#define FOUR(m) (m.lo | m.hi)
#else
#define FOUR(m) (m)
#endif
#if W == 2
  return (m.x | m.y) != 0;
#else
  return ((FOUR(m).x | FOUR(m).y) | (FOUR(m).z | FOUR(m).w)) != 0;
#endif
}
#endif
#endif

// The rays of a packet lie in PACKET_HEIGHT rows of PACKET_WIDTH pixels of the picture, lanes row by row. Square packets lie across fewer silhouettes than long ones do, and
// their lanes are done sooner after one another. What lanes share with their column, or with their row, from an array of one for each:
#if PACKET_HEIGHT == 4
#define OF_COLUMNS(from) (vload4(0, from).s0123012301230123)
#define OF_ROWS(T, from) (vload4(0, from).s0000111122223333)
#elif PACKET_HEIGHT == 2
#define OF_COLUMNS(from) (vload4(0, from).s01230123)
#define OF_ROWS(T, from) (vload2(0, from).s00001111)
#else
#define OF_COLUMNS(from) LOAD(from)
#define OF_ROWS(T, from) ((T)(*(from)))
#endif

#define LT(a, b) MASK((a) < (b))
#define LE(a, b) MASK((a) <= (b))
#define GT(a, b) MASK((a) > (b))
#define GE(a, b) MASK((a) >= (b))
#define EQ(a, b) MASK((a) == (b))
#define NONE ((I)0)
#define ALL ((I)-1)

#if IRT_DOUBLE
#define R(x) x
#define ULP 0x1p-52     // spacing of reals just above 1
#define TINY 0x1p-1022  // least normal real: what an operation can lose to underflow
#define HUGE_REAL 0x1.fffffffffffffp+1023
#define POWER_OF_TWO_BELOW(v) AS_F(AS_I(v) & (I)0x7ff0000000000000)  // of |v|; infinity for that and nan
#define MODEST 0x1p500  // squares of it and of its reciprocal are far from overflow and underflow
#define PI_LO 0x1.921fb54442d18p+1
#define PI_HI 0x1.921fb54442d19p+1
#else
#define R(x) x##f
#define ULP 0x1p-23f
#define TINY 0x1p-126f
#define HUGE_REAL 0x1.fffffep+127f
#define POWER_OF_TWO_BELOW(v) AS_F(AS_I(v) & (I)0x7f800000)
#define MODEST 0x1p60f
#define PI_LO 0x1.921fb4p+1f
#define PI_HI 0x1.921fb6p+1f
#endif
#define INF ((F)INFINITY)

// Outward rounding by multiplication: where the computed v lies within n ulp of the exact value, n a multiple of a half, LOWER(v, n) is
// below it and UPPER(v, n) above. The pad is more than n ulp by PAD_SLACK, so that v and pad, n steps of the grid apart or half
// a step more, are not rounded back. Errors that are no such multiple take n half an ulp larger. `nextafter` would compile four times slower.
#if IRT_OUTWARD
#define PAD_SLACK R(0.01)
#define LOWER(v, n) ((v) - fma(fabs(v), (F)(((n) + PAD_SLACK) * ULP), (F)TINY))
#define UPPER(v, n) ((v) + fma(fabs(v), (F)(((n) + PAD_SLACK) * ULP), (F)TINY))
#else
#define LOWER(v, n) (v)
#define UPPER(v, n) (v)
#endif
#define EXACT R(0.5)  // ulp by which correctly rounded operations err: + - * fma

// Where values can become infinite (IRT_INFINITE): a lower end is never +inf and an upper end never -inf, so that no
// sum is inf - inf; and the 0 * inf of a product, which min and max would drop at random, becomes the whole line.
#if IRT_INFINITE
#define CAP_LOWER(v) min(v, (F)HUGE_REAL)
#define CAP_UPPER(v) max(v, (F)-HUGE_REAL)
#define CAP_EARLY(v) min(v, (F)(R(0.5) * HUGE_REAL))  // a lower end by functions that may overflow a little early
#define NAN_TO(v, w) SELECT(EQ(v, v), v, w)
#else
#define CAP_LOWER(v) (v)
#define CAP_EARLY(v) (v)
#define CAP_UPPER(v) (v)
#define NAN_TO(v, w) (v)
#endif
