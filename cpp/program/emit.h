// Emitters: programs to OpenCL C functions, one emitter for each algebra.
//
// The functions use only the macros of kernels/packet.cl, so that one text serves all packet widths and precisions of
// one `real`. User text never reaches the source, not even comments: symbols are numbered.
#pragma once

#include <set>
#include <string>

#include "program/program.h"

namespace irt::program {

enum class Precision { Single, Double };

// What an affine function returns, FORM (emit_affine).
enum class Result { form, range, both };

// A generated function and the library files that it calls.
struct Emitted {
  std::string source;
  std::set<std::string> files;
  Result result = Result::form;
  std::set<std::string> functions{};  // that the source calls, each a definition; programs of one kernel may share them
};

// static inline IA irt_interval(IA x, IA y, IA z PARAMETERS, I* undefined, I* rough REGION_PARAMETERS), the last being
// I* outside, I* inside in programs with a region. outside: no zero of f counts on the piece, because the clip is proven above zero (or
// undefined) or the numerator of f proven not to be zero; this tells nothing of the sign of f. inside: the clip is proven not to be above zero.
Emitted emit_interval(const Program& program, Precision precision);

// static inline FORM irt_affine(RA x, RA y, RA z PARAMETERS, I* undefined, I* rough REGION_PARAMETERS); FORM is RA; IA where the result
// has forgotten where on the ray it is; and both, x, y, z, lo, hi, where the range knows of an end that the form has lost (overflow, poles).
// `infinite`: values may leave the range of reals (program::magnitude), so that exponentials may lose their upper end.
Emitted emit_affine(const Program& program, Precision precision, bool infinite);

// static inline F irt_slack(F x, F y, F z PARAMETERS): from bounds of the coordinates' magnitudes, how far either enclosure lies from the
// exact one if all its arithmetic is done without pads: each end of an interval, or x, y and z of a form together. Holds where nothing
// overflows. Empty for programs with operators whose rounding has no bound of this kind, and for those with a region.
std::string emit_slack(const Program& program, Precision precision, bool affine);

// static inline FW irt_fine(FW x, FW y, FW z PARAMETERS): the value in double, in kernels whose packets are floats; and static inline F irt_fine_error(F x, F y, F z,
// F place): how far from the exact one, from bounds of the coordinates' magnitudes, each of which is off by a part `place` of its own at most (kernels/refine.cl). Empty
// for programs with parameters, whose ends are floats there, and with operators whose error has no such bound.
std::string emit_fine(const Program& program);

// static inline F irt_value(F x, F y, F z PARAMETERS); and irt_region, the same for the clip formula, in programs with one.
Emitted emit_value(const Program& program, Precision precision);

// static inline F irt_slope(F x, F y, F z, F dx, F dy, F dz PARAMETERS, F* slope): the value, and the exact derivative along the
// direction by forward accumulation.
Emitted emit_slope(const Program& program, Precision precision);

// Of programs made by `along`, either algebra emits the range of the derivative, from coordinates and their changes:
// static inline IA irt_along(T x, T y, T z, T dx, T dy, T dz PARAMETERS, I* undefined, I* rough), T being IA or RA.

// static inline F irt_gradient(F x, F y, F z PARAMETERS, F* gx, F* gy, F* gz): the value, and the exact gradient by
// reverse accumulation.
Emitted emit_gradient(const Program& program, Precision precision);

// For polynomials of degree limits::kClosedDegree at most, the leaves, under Min, Max, - and factors that are numbers:
// static inline void irt_coefficients(F ox, F oy, F oz, F dx, F dy, F dz PARAMETERS, F c[][TERMS], F* error): the coefficients of each leaf
// along o + e d, |e| <= 1; static inline F irt_tree(const F* s): the sign of f from theirs; TERMS, LEAVES, and EACH_LEAF(DO), which is
// DO(leaf, degree) for each. Throws MethodError for other formulas, LimitError past limits::kLeaves.
Emitted emit_coefficients(const Program& program, Precision precision);

}  // namespace irt::program
