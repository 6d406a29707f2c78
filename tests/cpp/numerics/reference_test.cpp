// The reference against roots known in closed form.
#include "numerics/reference.h"

#include <gtest/gtest.h>

#include "error.h"
#include "expr/build.h"
#include "expr/parse.h"

namespace irt::numerics {
namespace {

// Along the z axis from -3 to 3, in the cube of that size: t = z + 3.
Root along_z(const char* formula, double lower = -3, double upper = 3) {
  Query query;
  query.lower = glm::dvec3(lower);
  query.upper = glm::dvec3(upper);
  query.parameters = {{"a", 0.25}};
  const Ray ray{{0, 0, -3}, {0, 0, 1}};
  const double tmin = 0, tmax = 1e300;
  return reference(parse(formula), std::span(&ray, 1), &tmin, &tmax, query)[0];
}

void expect_root(const char* formula, Kind kind, double z) {
  const Root r = along_z(formula);
  EXPECT_EQ(static_cast<int>(r.kind), static_cast<int>(kind)) << formula;
  EXPECT_LE(r.lo, z + 3) << formula;
  EXPECT_GE(r.hi, z + 3) << formula;
  EXPECT_LE(r.hi - r.lo, 4e-12) << formula;
}

TEST(Reference, FindsSimpleRootsOfPolynomials) {
  expect_root("z - 1/3", Kind::hit, 1.0 / 3);
  expect_root("z^2 - 2", Kind::hit, -std::sqrt(2.0));
  expect_root("(z - a)(z - 1)(z + 4)", Kind::hit, 0.25);
  expect_root("z", Kind::hit, 0);
  // Three roots closer together than doubles tell apart.
  expect_root("(z - 1/3)(z - 1/3 + 1e-17)(z - 1/3 + 1e-18)", Kind::hit, 1.0 / 3);
}

TEST(Reference, DecidesMultipleRootsExactly) {
  expect_root("(z - 1/3)^2", Kind::touch, 1.0 / 3);
  expect_root("(z - 1/3)^3", Kind::hit, 1.0 / 3);
  expect_root("(z - 1/3)^4 (z - 2)", Kind::touch, 1.0 / 3);
  EXPECT_EQ(along_z("(z - 1/3)^2").arithmetic, Arithmetic::exact);
}

TEST(Reference, TellsRootsFromNearMisses) {
  EXPECT_EQ(along_z("(z - 1/3)^2 + 1e-24").kind, Kind::miss);
  EXPECT_EQ(along_z("(z - 1/3)^2 + 1e-12").kind, Kind::miss);
  EXPECT_EQ(along_z("(z - 1/3)^2 - 1e-10").kind, Kind::hit);
  EXPECT_EQ(along_z("z^2 + 1").kind, Kind::miss);
}

TEST(Reference, CutsNothingOutsideTheClipWhereNoSignIsKnown) {
  // Coefficients leave doubles and fixed point; only exact numbers tell. It took 10^6 pieces of what lies before the clip, once.
  const Root r = along_z("1e280*((z - 1)^2 + 1)^7 - 1", -3, 1000);
  EXPECT_EQ(r.kind, Kind::miss);
  EXPECT_EQ(r.arithmetic, Arithmetic::exact);
}

TEST(Reference, FindsRootsOfEverythingElse) {
  expect_root("sin(z) - 1/2", Kind::hit, 0.52359877559829887);
  expect_root("exp(z) - 2", Kind::hit, 0.69314718055994531);
  expect_root("Abs(z - 1) - 1/2", Kind::hit, 0.5);
  expect_root("Min(z - 1, z + 1)", Kind::hit, 1);
  expect_root("cbrt(z) - 1/2", Kind::hit, 0.125);
  expect_root("sin(z)^3", Kind::hit, 0);
  expect_root("cbrt(sin(z))", Kind::hit, 0);
  expect_root("Piecewise((z - 2, z > 1), (-5, True))", Kind::hit, 2);
}

TEST(Reference, ExcludesWhatHasNoRoot) {
  for (const char* f : {"exp(z)", "sqrt(z - 1) + 1", "log(z)^2 + 9", "cos(z) + 1.0001", "Abs(z) + 1e-9", "Mod(z, 1) + 1/2", "sqrt(-1 - z^2)"})
    EXPECT_EQ(along_z(f).kind, Kind::miss) << f;
}

TEST(Reference, SaysWhereItCannotDecide) {
  for (const char* f : {"sin(z)^2", "1 - cos(z - 1)", "floor(z) - 1/2", "sign(z - 1/3)", "Piecewise((z - 2, z > 1), (1, True))"}) {
    const Root r = along_z(f);
    EXPECT_EQ(r.kind, Kind::undecided) << f;
    EXPECT_LT(r.hi - r.lo, 1e-9) << f;
  }
}

TEST(Reference, CountsOnlyRootsInsideTheBounds) {
  EXPECT_EQ(along_z("(z + 2)(z - 2)", -1, 1).kind, Kind::miss);
  EXPECT_NEAR(along_z("(z + 2)(z - 1/2)", -1, 1).lo, 3.5, 1e-9);
}

TEST(Reference, MatchesInEveryArithmetic) {
  // The same surface as a polynomial, and hidden from the polynomial way.
  const Root a = along_z("z^3 - 2 z + 1/3"), b = along_z("z^3 - 2 z + 1/3 + 0 Abs(x - 2) + Abs(x) sin(x)");
  EXPECT_EQ(a.kind, Kind::hit);
  EXPECT_EQ(b.kind, Kind::hit);
  EXPECT_LE(std::max(a.lo, b.lo), std::min(a.hi, b.hi));
}

TEST(Reference, RefusesMissingParameters) {
  EXPECT_THROW(along_z("z - b"), ArgumentError);
  EXPECT_THROW(along_z("z^2000000 - 1"), LimitError);
}

}  // namespace
}  // namespace irt::numerics
