// Bindings of cpp/render.
#include "bindings/bindings.h"

namespace irt::bindings {

void bind_render(pybind11::module_&) {}

}  // namespace irt::bindings
