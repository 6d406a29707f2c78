// Expansion multiplies out, and changes neither the function nor where it is defined.
#include <gtest/gtest.h>

#include <string>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/parse.h"
#include "expr/print.h"

namespace irt {
namespace {

void expect_expanded(const char* formula, const char* expanded) {
  EXPECT_EQ(to_string(expand(parse(formula))), to_string(parse(expanded))) << formula;
}

TEST(Expand, MultipliesOut) {
  expect_expanded("(x + y)^2", "x^2 + 2 x y + y^2");
  expect_expanded("(x + 1/2)(x - 1/2)(x^2 + 1/4)", "x^4 - 1/16");
  expect_expanded("((x + 1)^2 - x^2 - 1) a", "2 a x");
  expect_expanded("sin((x + 1)^2) (y + 1)", "sin(x^2 + 2x + 1) y + sin(x^2 + 2x + 1)");
  expect_expanded("Piecewise((x (x + 1), x (y + 1) < 0), (0, True))", "Piecewise((x^2 + x, x y + x < 0), (0, True))");
  expect_expanded("(x + y)^2 - (x - y)^2 - 4 x y", "0");
  EXPECT_EQ(expand(parse("x (y + 1) < 1")), parse("x y + x < 1"));
}

TEST(Expand, KeepsDomains) {
  expect_expanded("(log(x) + 1)^2 - (log(x) - 1)^2 - 4 log(x)", "0 log(x)^2 + 0 log(x)");
  expect_expanded("(x - x) (y + log(x))", "0 log(x)");
  expect_expanded("0 log(x) (y + 1)", "0 log(x)");
  expect_expanded("(sqrt(x) + 1)(sqrt(x) - 1)", "sqrt(x)^2 + 0 sqrt(x) - 1");
  expect_expanded("(x + 1/x)^2", "x^2 + 2 x/x + x^(-2)");
  expect_expanded("(E + 1)(E - 1)", "E^2 - 1");
}

TEST(Expand, KeepsWhatIsUndefinedEverywhere) {
  expect_expanded("log(y - (y + 1) + 1)(x + 1)", "log(y - (y + 1) + 1) x + log(y - (y + 1) + 1)");
  expect_expanded("1/(y - (y + 1) + 1) + (x + 1)^2 - x^2", "1/(y - (y + 1) + 1) + 2 x + 1");
  EXPECT_EQ(degree(parse("(x + 1)^2 - (x - 1)^2 + log(a - (a + 1) + 1)")), 1);
}

TEST(Expand, CapsWhatGrows) {
  // (a^n - b^n)(a^n + b^n) = a^2n - b^2n, as often as it takes.
  Expr e = parse("x^1000000000 - y");
  const auto square = [&](int k) { return add(e, mul(Expr(2L), pow(symbol("y"), number(mpq_class(mpz_class(1) << k))))); };
  EXPECT_THROW(
      {
        for (int k = 0; k < 60; ++k) e = mul(e, square(k));
        expand(e);
      },
      LimitError);
  const std::string large = "2^" + std::to_string(limits::kNumberBits / 2 + 1);
  EXPECT_THROW(expand(parse("(" + large + " x + y)^2")), LimitError);
  EXPECT_THROW(expand(parse("(x + y + z + 1)^2000")), LimitError);
}

}  // namespace
}  // namespace irt
