// Bindings of cpp/expr: the handle, its parts and what builds new ones. Operators are Python's (expression.py).
#include <pybind11/numpy.h>
#include <pybind11/operators.h>
#include <pybind11/stl.h>

#include "bindings/bindings.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/parse.h"
#include "expr/print.h"
#include "expr/tape.h"

namespace py = pybind11;

namespace irt::bindings {
namespace {

const char* op_name(Op op) {
  if (const char* name = function_name(op)) return name;
  switch (op) {
    case Op::Number: return "Number";
    case Op::Pi: return "pi";
    case Op::E: return "E";
    case Op::Symbol: return "Symbol";
    case Op::Add: return "Add";
    case Op::Mul: return "Mul";
    case Op::Pow: return "Pow";
    case Op::Less: return "Lt";
    case Op::LessEqual: return "Le";
    case Op::True: return "True";
    default: return "False";
  }
}

Op op_of(const std::string& name) {
  for (int i = 0; i <= static_cast<int>(Op::False); ++i)
    if (name == op_name(static_cast<Op>(i))) return static_cast<Op>(i);
  throw ExpressionError("unknown operator '" + name + "'");
}

py::int_ python_int(const mpz_class& v) { return py::reinterpret_steal<py::int_>(PyLong_FromString(v.get_str(16).c_str(), nullptr, 16)); }

mpz_class integer(const py::int_& v) {
  const std::string text = py::str(py::module_::import("builtins").attr("hex")(v));
  return mpz_class(text, 0);
}

Expr rational(const py::int_& numerator, const py::int_& denominator) {
  const mpz_class d = integer(denominator);
  if (d == 0) throw ExpressionError("a rational number with denominator zero");
  return number(mpq_class(integer(numerator), d));
}

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Inputs of equal size, one for each symbol of the tape.
py::array evaluate(const Expr& e, const py::dict& values, const std::vector<py::ssize_t>& shape) {
  const Tape tape(e);
  std::vector<Doubles> held;
  std::vector<const double*> inputs;
  py::array_t<double> result(shape);
  for (const std::string& name : tape.symbols()) {
    held.push_back(values[name.c_str()].cast<Doubles>());
    if (held.back().size() != result.size()) throw ArgumentError("the arrays have different sizes");
    inputs.push_back(held.back().data());
  }
  double* out = result.mutable_data();
  const auto n = static_cast<std::size_t>(result.size());
  {
    const py::gil_scoped_release release;
    tape.run(inputs, out, n);
  }
  return result;
}

}  // namespace

void bind_expr(py::module_& m) {
  py::class_<Expr>(m, "Node", "An immutable expression tree.")
      .def_property_readonly("op", [](const Expr& e) { return op_name(e.op()); })
      .def_property_readonly("args", [](const Expr& e) { return std::vector<Expr>(e.args().begin(), e.args().end()); })
      .def_property_readonly("name", [](const Expr& e) { return e.op() == Op::Symbol ? e.name() : ""; })
      .def_property_readonly("is_condition", &Expr::is_condition)
      .def("ratio", [](const Expr& e) { return py::make_tuple(python_int(e.number().get_num()), python_int(e.number().get_den())); },
           "Numerator and denominator of a number.")
      .def("__eq__", [](const Expr& a, const Expr& b) { return a == b; })
      .def("__hash__", [](const Expr& e) { return static_cast<py::ssize_t>(e.hash() >> 2); })
      .def("__str__", &to_string)
      .def("latex", &to_latex);
  const auto free = py::call_guard<py::gil_scoped_release>();
  m.def("rational", &rational, py::arg("numerator"), py::arg("denominator"), "An exact rational number.");
  m.def("from_double", &from_double, py::arg("value"), "The number that a float is, exactly.");
  m.def("symbol", &symbol, py::arg("name"), "The symbol of that name.");
  m.def("call", [](const std::string& op, const std::vector<Expr>& args) { return call(op_of(op), args); }, py::arg("op"), py::arg("args"),
        "An operator from its arguments, in canonical form.");
  m.def("parse", &parse, py::arg("text"), free, "The formula that a text is.");
  m.def("postorder", &postorder, py::arg("node"), free, "Every distinct part once, arguments before their users.");
  m.def("free_symbols", &free_symbols, py::arg("node"), free, "The names of the symbols.");
  m.def("substitute", &substitute, py::arg("node"), py::arg("pairs"), free, "Replaces sub-trees, all at once.");
  m.def("differentiate", &differentiate, py::arg("node"), py::arg("symbol"), free, "The derivative.");
  m.def("expand", &expand, py::arg("node"), free, "Products and powers of sums multiplied out.");
  m.def("simplify", &simplify, py::arg("node"), free, "Smaller where that is sound.");
  m.def("degree", &degree, py::arg("node"), free, "Total degree in x, y, z, or None.");
  m.def("count_nodes", &count_nodes, py::arg("node"), free, "Distinct parts; LimitError past the cap.");
  m.def("evaluate", &evaluate, py::arg("node"), py::arg("values"), py::arg("shape"), "The values at arrays of points.");
}

}  // namespace irt::bindings
