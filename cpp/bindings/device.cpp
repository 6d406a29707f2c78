// Bindings of cpp/device. Which driver to load is decided in python/implicitrt/devices.py.
#include "device/device.h"

#include <pybind11/stl.h>

#include "bindings/bindings.h"

namespace py = pybind11;

namespace irt::bindings {

void bind_device(py::module_& m) {
  using device::Device;
  py::class_<Device, std::shared_ptr<Device>>(m, "Device", "An opened OpenCL device.")
      .def_property_readonly("name", [](const Device& d) { return d.info().name; })
      .def_property_readonly("driver", [](const Device& d) { return d.info().driver; })
      .def_property_readonly("version", [](const Device& d) { return d.info().version; })
      .def_property_readonly("width", [](const Device& d) { return d.info().width; })
      .def_property_readonly("fp64", [](const Device& d) { return d.info().fp64; })
      .def_property_readonly("gpu", [](const Device& d) { return d.info().gpu; })
      .def("finish", &Device::finish, py::call_guard<py::gil_scoped_release>(), "Waits for kernels that are built ahead.")
      .def_property_readonly("builds", [](const Device& d) { return d.builds(); });
  m.def("load_device", &device::load, py::arg("path"), py::arg("driver"), py::arg("width"), py::call_guard<py::gil_scoped_release>(),
        "Loads the driver at `path` into this process and opens its first device.");
  m.def("probe_device", &device::probe, py::arg("device"), py::call_guard<py::gil_scoped_release>(),
        "Runs the probe kernel; \"\" where every value is right.");
  m.def("build_kernel", [](Device& d, const std::string& source, const std::string& entry) { d.kernel(source, entry); }, py::arg("device"),
        py::arg("source"), py::arg("entry"), py::call_guard<py::gil_scoped_release>(), "Builds a kernel, for tests of build errors.");
}

}  // namespace irt::bindings
