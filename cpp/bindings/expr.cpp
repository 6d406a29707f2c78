// Bindings of cpp/expr.
#include "bindings/bindings.h"

namespace irt::bindings {

void bind_expr(pybind11::module_&) {}

}  // namespace irt::bindings
