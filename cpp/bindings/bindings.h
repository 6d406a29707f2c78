// One function per layer, each defined in the file of the same name; module.cpp calls them all.
#pragma once

#include <pybind11/pybind11.h>

namespace irt::bindings {

void bind_errors(pybind11::module_& m);
void bind_expr(pybind11::module_& m);
void bind_numerics(pybind11::module_& m);
void bind_device(pybind11::module_& m);
void bind_render(pybind11::module_& m);

}  // namespace irt::bindings
