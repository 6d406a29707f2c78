// Bindings of cpp/numerics.
#include "bindings/bindings.h"

namespace irt::bindings {

void bind_numerics(pybind11::module_&) {}

}  // namespace irt::bindings
