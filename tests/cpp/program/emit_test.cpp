// Programs share what is common, keep even powers, and kernels contain only what they need.
#include "program/emit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "error.h"
#include "expr/parse.h"
#include "kernel/assemble.h"

namespace irt::program {
namespace {

long count(const Program& p, Code code) {
  return std::count_if(p.code.begin(), p.code.end(), [&](const Instruction& i) { return i.code == code; });
}

TEST(Lower, SharesCommonParts) {
  const Program p = lower(parse("sin(x*y) + sin(x*y)^2"));
  EXPECT_EQ(count(p, Code::Sin), 1);
  EXPECT_EQ(count(p, Code::Sqr), 1);
}

TEST(Lower, KeepsEvenPowersAndFoldsConstants) {
  const Program p = lower(parse("x^200 + sqrt(5)*pi*y - 1"));
  EXPECT_EQ(count(p, Code::Power), 1);
  EXPECT_EQ(count(p, Code::Sqrt), 0);
  EXPECT_EQ(count(p, Code::Mul), 1);
}

TEST(Lower, MonomialsThatCancelBecomeOnePolynomial) {
  const Program p = lower(parse("32*x^6 - 48*x^4 + 18*x^2 + y^7 - y^3 + y + x*y - 1"));
  EXPECT_EQ(count(p, Code::Polynomial), 2);
  ASSERT_EQ(p.polynomials.size(), 2u);
  EXPECT_EQ(p.polynomials[0].size(), 4u);  // in x^2
  EXPECT_EQ(p.polynomials[1].size(), 8u);
  EXPECT_EQ(count(p, Code::Power), 0);
  EXPECT_EQ(count(lower(parse("x^4 - 5*x^2 + x")), Code::Polynomial), 0);
}

TEST(Lower, ParametersAreSortedAndNotFolded) {
  const Program p = lower(parse("b*x + a*y"));
  EXPECT_EQ(p.parameters, (std::vector<std::string>{"a", "b"}));
  EXPECT_THROW(lower(parse("x < y")), ExpressionError);
}

TEST(Lower, DivisionStaysDivision) {
  EXPECT_EQ(count(lower(parse("x/y")), Code::Div), 1);
  EXPECT_EQ(count(lower(parse("3/y")), Code::Recip), 1);
}

TEST(Along, DerivativesShareWhatTheyCanAndMarkKinks) {
  const Program p = along(lower(parse("sin(x*y) + x^3"))).value();
  EXPECT_EQ(count(p, Code::Cos), 1);
  EXPECT_EQ(count(p, Code::Sin), 0);
  EXPECT_TRUE(p.derivative);
  EXPECT_LT(p.function, 0);
  EXPECT_EQ(count(along(lower(parse("Abs(x) + y"))).value(), Code::Sign), 1);
  // The slope of x + floor(x) is that of x; that it jumps is told by the function itself.
  const Program jumps = along(lower(parse("x + floor(x)"))).value();
  EXPECT_EQ(count(jumps, Code::Floor), 1);
  EXPECT_GE(jumps.function, 0);
}

std::string source(const char* text, bool affine, bool normal) {
  kernel::set_directory(IRT_KERNEL_DIR);
  return kernel::assemble(lower(parse(text)), {.affine = affine, .normal = normal});
}

TEST(Assemble, KernelsContainOnlyWhatTheSceneUses) {
  const std::string plain = source("x^2 + y^2 + z^2 - 1", false, false);
  EXPECT_EQ(plain.find("ra_mul"), std::string::npos);
  EXPECT_EQ(plain.find("irt_gradient(F"), std::string::npos);
  EXPECT_EQ(plain.find("ia_sin"), std::string::npos);
  EXPECT_EQ(plain.find("ia_recip"), std::string::npos);
  EXPECT_NE(source("sin(x) + y", true, true).find("ia_sin"), std::string::npos);
  EXPECT_NE(source("sin(x) + y", true, true).find("irt_gradient(F"), std::string::npos);
}

TEST(Assemble, UserTextStandsNowhere) {
  const std::string text = source("evil_name*x + y", false, false);
  EXPECT_NE(text.find("// p[0], p[1]: bounds of parameter 0"), std::string::npos);
  EXPECT_EQ(text.find("evil_name"), std::string::npos);
}

TEST(Assemble, AClipFormulaIsAskedBesideTheOther) {
  const Expr g = parse("sin(x*y) - h");
  const Program p = lower(parse("a*sin(x*y) + z^3"), true, &g);
  EXPECT_EQ(count(p, Code::Sin), 1);
  EXPECT_EQ(p.parameters, (std::vector<std::string>{"a", "h"}));
  for (const bool affine : {false, true}) {
    kernel::set_directory(IRT_KERNEL_DIR);
    EXPECT_NE(kernel::assemble(p, {.affine = affine}).find("*outside = "), std::string::npos);
    EXPECT_EQ(source("a*sin(x*y) + z^3", affine, false).find("*outside = "), std::string::npos);
  }
  const Expr condition = parse("x < y");
  EXPECT_THROW(lower(parse("x"), false, &condition), ExpressionError);
}

TEST(Coefficients, AreCutOffBehindTheFourth) {
  const std::string text = emit_coefficients(lower(parse("x^3*y^4 - x")), Precision::Single).source;
  EXPECT_NE(text.find("DO(0, 4)"), std::string::npos);
  EXPECT_EQ(text.find("_5 ="), std::string::npos);
}

TEST(Coefficients, LeavesUnderSetOperationsAreFoundOnce) {
  const std::string text = emit_coefficients(lower(parse("Max(Min(x^2 - 1, y), -(x^2 - 1), a*z)")), Precision::Double).source;
  EXPECT_NE(text.find("#define LEAVES 4\n#define IRT_DEGREE 2\n"), std::string::npos);
  EXPECT_NE(text.find("min(s["), std::string::npos);
  const std::string twice = emit_coefficients(lower(parse("Max(x, Min(x, y))")), Precision::Double).source;
  EXPECT_NE(twice.find("#define LEAVES 2\n"), std::string::npos);
}

TEST(Coefficients, RefuseWhatIsNoPolynomial) {
  EXPECT_THROW(emit_coefficients(lower(parse("sin(x) - y")), Precision::Single), MethodError);
  EXPECT_THROW(emit_coefficients(lower(parse("y/x")), Precision::Single), MethodError);
  EXPECT_NO_THROW(emit_coefficients(lower(parse("sin(a)*x + y/(b + exp(a))")), Precision::Single));
}

TEST(Magnitude, TellsWhatCanOverflow) {
  const double at[3] = {2, 2, 2};
  EXPECT_LT(magnitude(lower(parse("x^2 + 3*y")), at, {}), 100);
  EXPECT_GT(magnitude(lower(parse("x^200")), at, {}), 1e36);
  EXPECT_GT(magnitude(lower(parse("1/x")), at, {}), 1e300);
  EXPECT_LT(magnitude(lower(parse("exp(-99*x^2 - y^2*Abs(x) - 3) + exp(Min(y, -z^2))")), at, {}), 1e12);
  for (const char* rises : {"exp(99*x^2)", "exp(-a*99*x^2)", "exp(-99*x^3)", "exp(-x^2 + 99*y)", "exp(Max(-x^2, 99*y))"})
    EXPECT_GT(magnitude(lower(parse(rises)), at, {1}), 1e36) << rises;
}

TEST(Emit, AffineResultsHaveAFormWhereThereIsOneAndARangeWhereThatKnowsMore) {
  const auto result = [](const char* formula) { return emit_affine(lower(parse(formula)), Precision::Single, false).result; };
  EXPECT_EQ(result("x^2 + sin(y)"), Result::form);
  EXPECT_EQ(result("x + 1/(y + 2)"), Result::both);
  EXPECT_EQ(result("x*log(y)"), Result::both);
  EXPECT_EQ(result("x^200 + y"), Result::both);
  EXPECT_EQ(result("floor(x)"), Result::range);
}

TEST(Emit, AffineSumsTakeInNumbersAndLeaveNoneUnread) {
  const auto text = [](const char* formula) { return emit_affine(lower(parse(formula)), Precision::Single, false).source; };
  const auto has = [](const std::string& s, const char* part) { return s.find(part) != std::string::npos; };
  EXPECT_TRUE(has(text("x*y + 3*z"), "ra_scale_add(") && !has(text("x*y + 3*z"), "ra_scale("));
  EXPECT_TRUE(has(text("x*y - 3*z"), "(-R(3.0)), R(0.0)"));
  EXPECT_TRUE(has(text("3*z"), "ra_scale("));
  const std::string both = text("x*y + 3*z + sin(3*z)");  // which reads it by itself as well
  EXPECT_TRUE(has(both, "ra_scale_add(") && has(both, "ra_scale("));
}

TEST(Emit, ValuesInDoubleHaveABoundWhereAllOperatorsHaveOne) {
  const auto text = [](const char* formula) { return emit_fine(lower(parse(formula))); };
  EXPECT_NE(text("x^2*sin(y) + Max(x, Abs(z)) - exp(-x^2)").find("FINE_SIN("), std::string::npos);
  for (const char* formula : {"x/y + z", "log(x) + y", "a*x + y - z", "exp(x) - y", "x^5 + y", "floor(x) + y"}) EXPECT_EQ(text(formula), "") << formula;
  // Two coordinates in a product, four in the longest term.
  EXPECT_NE(text("x*y + z^4").find("fma((F)R(4.12), place"), std::string::npos) << text("x*y + z^4");
}

TEST(Emit, SlopesFollowTheDirectionAndLeaveOutWhatDoesNotMove) {
  const Program p = lower(parse("a^3*x + sin(y)"));
  const std::string slope = emit_slope(p, Precision::Single).source;
  EXPECT_NE(slope.find("dx"), std::string::npos);
  EXPECT_NE(slope.find("cos("), std::string::npos);
  EXPECT_EQ(slope.find("dz;"), std::string::npos);
  EXPECT_EQ(emit_value(p, Precision::Single).source.find("cos("), std::string::npos);
  EXPECT_NE(emit_slope(lower(parse("floor(x)")), Precision::Single).source.find("*slope = (F)0"), std::string::npos);
}

TEST(Emit, ValuesHaveNothingOfTheClipFormulaAndTheOtherWayRound) {
  const Expr clip = parse("cos(z)");
  const std::string text = emit_value(lower(parse("sin(x)"), false, &clip), Precision::Single).source;
  const std::size_t region = text.find("irt_region");
  ASSERT_NE(region, std::string::npos);
  EXPECT_EQ(text.substr(0, region).find("cos("), std::string::npos);
  EXPECT_EQ(text.substr(region).find("sin("), std::string::npos);
}

}  // namespace
}  // namespace irt::program
