// The grammar, canonical forms, and printing that parses back.
#include "expr/parse.h"

#include <gtest/gtest.h>

#include "caps.h"
#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/print.h"

namespace irt {
namespace {

struct Pair {
  const char *text, *same;
};

class Equal : public testing::TestWithParam<Pair> {};
TEST_P(Equal, MeanTheSame) { EXPECT_EQ(to_string(parse(GetParam().text)), to_string(parse(GetParam().same))); }
INSTANTIATE_TEST_SUITE_P(Grammar, Equal,
                         testing::Values(Pair{"-x^2", "-(x^2)"}, Pair{"2^3^2", "2^(3^2)"}, Pair{"1/2x", "(1/2)*x"}, Pair{"2x y", "2*x*y"},
                                         Pair{"x^2+y^2=1", "x**2+y**2-1"}, Pair{"x²·y³", "x^2*y^3"}, Pair{"√(x)−π", "sqrt(x)-pi"},
                                         Pair{"0.1", "1/10"}, Pair{"1.5e-3", "3/2000"}, Pair{"x*x", "x**2"}, Pair{"x+x", "2*x"},
                                         Pair{"2(x+1)", "2*(x+1)"}, Pair{"(x)(y)", "x*y"}, Pair{"sin (x)", "sin(x)"}, Pair{"2^-1", "1/2"},
                                         Pair{"(x^2)^3", "x^6"}, Pair{"x - x", "0"}, Pair{"x^0", "1"}, Pair{"sqrt(4)", "2"},
                                         Pair{"exp(1)", "E"}, Pair{"sqrt(x) sqrt(x)", "sqrt(x)^2"}, Pair{"x^y x^y", "(x^y)^2"}, Pair{"1/sqrt(x)/sqrt(x)", "1/sqrt(x)^2"}, Pair{"sqrt(x)/sqrt(x) y", "y sqrt(x)/sqrt(x)"},
                                         Pair{"sqrt(x) sqrt(x) sqrt(x) x^(3/2)", "(x^(3/2))^2"}, Pair{"x^(1/3) x^(1/3)", "x^(2/3)"}, Pair{"E E exp(2)", "exp(2)^2"}, Pair{"4^(1/4)*4^(1/4)", "2"},
                                         Pair{"Min(x, x)", "x"}, Pair{"2(x + y) - (x + y) + z", "x + y + z"}, Pair{"2(x + 1) - (x + 1) - 1", "x"}, Pair{"a > b", "b < a"}));

class Kept : public testing::TestWithParam<const char*> {};
TEST_P(Kept, IsNotFolded) { EXPECT_EQ(to_string(parse(GetParam())), GetParam()); }
INSTANTIATE_TEST_SUITE_P(Domains, Kept, testing::Values("x/x", "sqrt(x)**2", "0*log(x)", "1/(1/x)", "(x + y)**2", "2*(x + y)"));

struct Wrong {
  const char *text, *part;
};
class Errors : public testing::TestWithParam<Wrong> {};
TEST_P(Errors, NameThePlaceAndTheWayOut) {
  try {
    parse(GetParam().text);
    FAIL() << GetParam().text << " was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam().part), std::string::npos) << error.what();
  }
}
INSTANTIATE_TEST_SUITE_P(Grammar, Errors,
                         testing::Values(Wrong{"x + sen(y)", "unknown function 'sen' at column 5; did you mean 'sin'?"}, Wrong{"x(y+1)", "x*(...)"},
                                         Wrong{"x = y = z", "at column 7"}, Wrong{"", "empty"}, Wrong{"(x", "')'"}, Wrong{"x)", "column 2"}, Wrong{"x²³", "a superscript after a superscript at column 3"},
                                         Wrong{"x ++", "ends too early"}, Wrong{"a < b < c", "And(a < b, b < c)"}, Wrong{"x $ y", "'$'"},
                                         Wrong{"sin", "write sin(x)"}, Wrong{"sin(x, y)", "takes 1 argument"}, Wrong{"1/0", "division by zero"},
                                         Wrong{"Piecewise(x, y)", "pairs"}, Wrong{"(-8)^(1/3)", "cbrt"}));

TEST(Parse, DepthAndLengthAreCapped) {
  const std::string deep = std::string(100000, '(') + "x" + std::string(100000, ')');
  EXPECT_THROW(parse(deep), LimitError);
  EXPECT_THROW(parse(std::string(limits::kFormulaLength + 1, 'x')), LimitError);
  EXPECT_THROW(parse("2^9999999999"), LimitError);
  EXPECT_THROW(parse("1e999999999"), LimitError);
}

TEST(Store, EqualTreesAreOneNode) {
  EXPECT_EQ(parse("x + y*sin(z)").key(), parse("sin(z)*y + x").key());
  EXPECT_NE(parse("x + y").key(), parse("x - y").key());
}

TEST(Store, TreesAMillionDeepAreBuiltWalkedAndDestroyed) {
  Expr e = symbol("x");
  for (int i = 0; i < 1'000'000; ++i) e = call(Op::Sin, std::span(&e, 1));
  EXPECT_EQ(free_symbols(e).size(), 1u);
  EXPECT_THROW(to_string(e), LimitError);
  EXPECT_THROW(count_nodes(e), LimitError);
}

TEST(Calculus, DerivativesAndDegrees) {
  EXPECT_EQ(to_string(differentiate(parse("x^3*y"), "x")), "3*x**2*y");
  EXPECT_EQ(to_string(differentiate(parse("sin(2x)"), "x")), "2*cos(2*x)");
  EXPECT_EQ(degree(parse("(x+y)^7*z + 1")), 8);
  EXPECT_EQ(degree(parse("x^2 - (x+1)*(x-1)")), 0);
  EXPECT_EQ(degree(parse("sin(x)")), std::nullopt);
  EXPECT_EQ(degree(parse("a*x^2 + sqrt(b)*y")), 2);
}

TEST(Substitute, NeedsNoBranchThatIsDropped) {
  const Expr f = parse("Piecewise((2 + log(1/x), x > 0), (y, True), (1/x, y > 0))");
  EXPECT_EQ(substitute(f, {{symbol("x"), Expr(0L)}}), symbol("y"));
  EXPECT_EQ(substitute(parse("Piecewise((x, x < 1), (1/(x - 2), True))"), {{symbol("x"), Expr(1L)}}), Expr(-1L));
  EXPECT_THROW(substitute(f, {{symbol("x"), Expr(-1L)}, {symbol("y"), parse("log(x)")}, {parse("x > 0"), parse("1 < y")}}), ExpressionError);
  EXPECT_THROW(substitute(parse("x + 1/x"), {{symbol("x"), Expr(0L)}}), ExpressionError);
}

TEST(Simplify, KeepsWhatIsUndefinedEverywhere) {
  EXPECT_EQ(to_string(simplify(parse("log(log(exp(-3/4))) + Abs(x)^2"))), "x**2 + log(log(exp(-3/4)))");
}

TEST(Simplify, IsSoundAndKeepsEvenPowers) {
  EXPECT_EQ(to_string(simplify(parse("Abs(x)^2"))), "x**2");
  EXPECT_EQ(to_string(simplify(parse("sin(x)^2 + cos(x)^2"))), "1");
  EXPECT_EQ(to_string(simplify(parse("sqrt(x^2)"))), "Abs(x)");
  EXPECT_EQ(to_string(simplify(parse("(x+y)^2"))), "(x + y)**2");
  EXPECT_EQ(to_string(simplify(parse("x/x"))), "x/x");
}

}  // namespace
}  // namespace irt
