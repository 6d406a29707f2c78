// The Python extension implicitrt._core: thin bindings, one file per layer.
#include "bindings/bindings.h"
#include "caps.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "C++ core of implicitrt; use the package, not this module.";
  m.attr("MAX_PIXELS") = irt::limits::kPixels;
  m.attr("MAX_SIDE") = irt::limits::kSide;
  m.attr("NUMBER_BITS") = irt::limits::kNumberBits;
  m.attr("CLOSED_DEGREE") = irt::limits::kClosedDegree;
  irt::bindings::bind_errors(m);
  irt::bindings::bind_expr(m);
  irt::bindings::bind_numerics(m);
  irt::bindings::bind_device(m);
  irt::bindings::bind_render(m);
}
