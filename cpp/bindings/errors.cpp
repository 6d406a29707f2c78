// C++ errors become the Python exceptions of the same name in implicitrt.errors.
#include "error.h"

#include "bindings/bindings.h"

namespace py = pybind11;

namespace irt::bindings {

void bind_errors(py::module_&) {
  py::register_exception_translator([](std::exception_ptr p) {
    const char* name = nullptr;
    std::string what;
    try {
      if (p) std::rethrow_exception(p);
    } catch (const ExpressionError& e) {
      name = "ExpressionError", what = e.what();
    } catch (const ArgumentError& e) {
      name = "ArgumentError", what = e.what();
    } catch (const LimitError& e) {
      name = "LimitError", what = e.what();
    } catch (const MethodError& e) {
      name = "MethodError", what = e.what();
    } catch (const DeviceError& e) {
      name = "DeviceError", what = e.what();
    } catch (const BuildError& e) {
      name = "BuildError", what = e.what();
    } catch (const Error& e) {
      name = "Error", what = e.what();
    }
    if (name) {
      py::object type = py::module_::import("implicitrt.errors").attr(name);
      PyErr_SetString(type.ptr(), what.c_str());
    }
  });
}

}  // namespace irt::bindings
