// Fractions are the formula wherever it is defined, and there only where a divisor may vanish.
#include "expr/fraction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "expr/build.h"
#include "expr/parse.h"
#include "expr/tape.h"

namespace irt {
namespace {

double value(const Expr& e, double x, double y, double z) {
  const Tape tape(e);
  std::vector<const double*> inputs;
  for (const std::string& name : tape.symbols()) inputs.push_back(name == "x" ? &x : name == "y" ? &y : &z);
  double result = 0;
  tape.run(inputs, &result, 1);
  return result;
}

TEST(Fraction, IsTheFormula) {
  for (const char* text : {"1/x + y", "y - tan(3x)/2", "(x + 1/(y - z))^3 - 2/(y - z)", "x/(y^2 - 1/4) + z/(x - y) + 1", "(1/x)^(-2) + 1/y", "x*y/(z*(x + 1/y)) - tan(z)^2",
                           "sin(x)/(x - y) + 1/(y - x)^2"}) {
    const Expr f = parse(text);
    const auto whole = fraction(f);
    ASSERT_TRUE(whole) << text;
    for (int k = 1; k < 40; ++k) {
      const double x = std::sin(1.7 * k), y = std::cos(2.3 * k), z = std::sin(0.9 * k + 1);
      const double n = value(whole->numerator, x, y, z), d = value(whole->denominator, x, y, z), v = value(f, x, y, z);
      EXPECT_NEAR(n / d, v, 1e-9 * (1 + std::fabs(v))) << text;
    }
  }
}

TEST(Fraction, IsNotThereWithoutPoles) {
  for (const char* text : {"x^2 + y^2 - 1", "x/3 + y", "x/a", "1/(x^2 + y^2 + 1)", "z - sin(x)/sqrt(x^2 + 1/100)", "x/(2 + Abs(y))", "exp(-x)/cosh(y)", "log(x) + y"})
    EXPECT_FALSE(fraction(parse(text))) << text;
  EXPECT_TRUE(fraction(parse("1/(x^2 + y^2)"))) << "it vanishes at one point";
}

TEST(Fraction, LeavesWhatWouldGrow) {
  Expr f(0L);
  for (long k = 1; k < 200; ++k) f = add(f, div(symbol("y"), sub(symbol("x"), Expr(k))));
  EXPECT_FALSE(fraction(f));
}

}  // namespace
}  // namespace irt
