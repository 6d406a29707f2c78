// The settings of a call, one array of reals, in the order in which cpp/render/launch.cpp writes it (scene_settings).
#define BOX_LO(axis) q[axis]
#define BOX_HI(axis) q[3 + (axis)]
#define RADIUS q[6]        // |s| stays below it inside the bounds
#define POSITION_PAD q[7]  // what the host's own rounding may add to a coordinate
#define EPS q[8]
#define NEAR_OUT q[9]  // s of the nearest t that counts, rounded down and up
#define NEAR_IN q[10]
#define COLOR(channel) q[11 + (channel)]
#define BACK_COLOR(channel) q[14 + (channel)]
#define UNRESOLVED_COLOR(channel) q[17 + (channel)]
#define LIGHT(axis) q[20 + (axis)]
#define LIGHT_POWER q[23]
#define STEPS q[24]  // of root finders that sample
#define BOXED q[25]  // whether the box may cut what the other bounds and the picture leave; 0: no
#define FIRST_EPS q[26]  // of brackets of floats that are narrowed down to EPS in double; EPS where none are
#define SPHERE(i, k) q[27 + 4 * (i) + (k)]  // centre and radius
#define HALF_SPACE(i, k) q[27 + 4 * (IRT_SPHERES + (i)) + (k)]  // normal and offset

#define MISS ((I)0)
#define HIT ((I)1)
#define TOUCH ((I)2)
#define UNRESOLVED ((I)3)

// Of packets of doubles, by masks of lanes of floats.
#if W == 1
#define SELECT_WIDE(m, a, b) SELECT(m, a, b)
#else
#define SELECT_WIDE(m, a, b) select(b, a, TO_LONG(m))
#endif

// A ray in the coordinates of the bounds: position P + s D. P lies near the middle of the bounds, so that a far camera
// costs no digits; t = (tau + s) length.
typedef struct {
  F px, py, pz, dx, dy, dz;
  F ex, ey, ez;  // bounds of the error of any position on the ray inside the bounds, evaluation included
#if IRT_SPLIT
  FW wpx, wpy, wpz, wdx, wdy, wdz;  // position and direction to twice the digits
#endif
  FW tau, length;
  F near_out, near_in, far_out, far_in;
#if IRT_BEAMS
  F bx, by, bz, wx, wy, wz;  // how far apart the rays of a beam lie: b + (tau + s) w
#endif
} RAY;

#if IRT_BEAMS
// What a beam found out for its rays (beams.cl): f has one sign up to `from`, and `span` behind it is to be looked at closer. In units of s.
typedef struct {
  F from, span, sign;  // from = -infinity, sign = 0: nothing is known
} HEAD;
#endif

// The part of a ray that counts. Outside [out0, out1] nothing counts; all of [in0, in1] does.
typedef struct {
  F out0, out1, in0, in1;
} RANGE;

// What a root finder reports: a status, and s: the middle of the bracket and half its width, or the start of what is open.
typedef struct {
  I status;
  FW at;
  F half_width;
#if IRT_GRADIENT_FOUND  // by the root finder, along with the root
  F gx, gy, gz;
#endif
#if IRT_PIECES
  I pieces;  // that were looked at
#endif
} ROOT;

// How far rounding takes t from (tau + s) |D|, in ulp of t.
#if IRT_SPLIT
#define DEPTH_ERROR R(0.75)
#else
#define DEPTH_ERROR R(4.0)
#endif

// The root of v > 0 to within one ulp, whatever the device's own does: one Newton step.
static inline FW careful_sqrt(FW v) {
  const FW r = sqrt(v);
  return r + fma(-r, r, v) / (r + r);
}

// Outputs that a call may ask for, as arguments of its kernel.
#if IRT_NORMAL
#define NORMAL_DECL __global float *normal, const int plane,
#define NORMAL_PASS normal, plane,
#else
#define NORMAL_DECL
#define NORMAL_PASS
#endif
#if IRT_RGB
#define RGB_DECL __global uint *rgba, const uint background,
#define RGB_PASS rgba, background,
#else
#define RGB_DECL
#define RGB_PASS
#endif
