// Constants are bounded by adjacent doubles, or refused.
#include "numerics/constant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "error.h"
#include "expr/parse.h"

namespace irt::numerics {
namespace {

struct Known {
  const char* text;
  double value;  // correctly rounded
};
class Constants : public testing::TestWithParam<Known> {};
TEST_P(Constants, AreBoundedTightly) {
  const Bounds b = enclose_constant(parse(GetParam().text));
  EXPECT_LE(b.lo, GetParam().value);
  EXPECT_GE(b.hi, GetParam().value);
  EXPECT_LE(b.hi, std::nextafter(b.lo, HUGE_VAL));
}
INSTANTIATE_TEST_SUITE_P(Some, Constants,
                         testing::Values(Known{"sqrt(2)", 1.4142135623730951}, Known{"pi", 3.141592653589793}, Known{"E", 2.718281828459045},
                                         Known{"1/3", 1.0 / 3}, Known{"(1+sqrt(5))/2", 1.618033988749895}, Known{"sin(1)", 0.8414709848078965},
                                         Known{"cos(10)", -0.8390715290764524}, Known{"atan2(1, -1)", 2.356194490192345},
                                         Known{"cbrt(-8)", -2}, Known{"log(2)", 0.6931471805599453}, Known{"2^(1/3)", 1.2599210498948732},
                                         Known{"tanh(1/2)", 0.46211715726000973}, Known{"Mod(-7/2, 2)", 0.5}, Known{"asin(1/2)", 0.5235987755982989}));

TEST(Constants, ExactOnesArePoints) {
  const Bounds b = enclose_constant(parse("3/4 + sqrt(4)"));
  EXPECT_EQ(b.lo, 2.75);
  EXPECT_EQ(b.hi, 2.75);
}

TEST(Constants, OneThatIsANumberButDoesNotLookItLiesBetweenItsNeighbours) {
  const Bounds five = enclose_constant(parse("sqrt(5)*sqrt(5)"));
  EXPECT_LE(five.lo, 5);
  EXPECT_GE(five.hi, 5);
  EXPECT_LE(five.hi - five.lo, 2e-15);
  const Bounds zero = enclose_constant(parse("(sqrt(2) + sqrt(3))^2 - 5 - 2*sqrt(6)"));
  EXPECT_LE(zero.lo, 0);
  EXPECT_GE(zero.hi, 0);
  EXPECT_LE(zero.hi - zero.lo, 1e-300);
}

TEST(Constants, WithoutAValueAreRefused) {
  EXPECT_THROW(enclose_constant(parse("log(sin(0) - cos(1))")), ExpressionError);
  EXPECT_THROW(enclose_constant(parse("asin(pi)")), ExpressionError);
  EXPECT_THROW(enclose_constant(parse("x")), ExpressionError);
}

}  // namespace
}  // namespace irt::numerics
