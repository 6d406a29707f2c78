// A libFuzzer target: text to formula, and everything that the core does with formulas before a device is asked.
//
// Whatever the text, only irt::Error comes out; what is printed parses back to the same tree. Built and run by scripts/fuzz.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/parse.h"
#include "expr/print.h"
#include "expr/tape.h"
#include "program/emit.h"

namespace {

// Runs f; an irt::Error is an answer, anything else ends the process.
template <class F>
void allowed(F f) {
  try {
    f();
  } catch (const irt::Error&) {
  }
}

void look_at(const irt::Expr& e) {
  allowed([&] {
    const std::string text = irt::to_string(e);
    if (irt::to_string(irt::parse(text)) != text) std::abort();
  });
  allowed([&] { irt::to_latex(e); });
  allowed([&] { irt::simplify(e); });
  allowed([&] { irt::expand(e); });
  allowed([&] { irt::differentiate(e, "x"); });
  allowed([&] { irt::degree(e); });
  allowed([&] { irt::substitute(e, {{irt::symbol("x"), irt::parse("y^2 - 1/3")}}); });
  allowed([&] {
    const irt::Tape tape(e);
    const double at[3] = {-0.5, 0, 1e300};
    double out[3];
    tape.run(std::vector<const double*>(tape.symbols().size(), at), out, 3);
  });
  allowed([&] {
    const irt::program::Program program = irt::program::lower(e, false);
    irt::program::emit_interval(program, irt::program::Precision::Single);
    irt::program::emit_affine(program, irt::program::Precision::Double, true);
    irt::program::emit_gradient(program, irt::program::Precision::Single);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  allowed([&] { look_at(irt::parse(std::string(reinterpret_cast<const char*>(data), size))); });
  return 0;
}
