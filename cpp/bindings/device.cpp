// Bindings of cpp/device.
#include "bindings/bindings.h"

namespace irt::bindings {

void bind_device(pybind11::module_&) {}

}  // namespace irt::bindings
