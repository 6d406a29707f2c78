// Every cap of cpp/caps.h: what is at it goes through, what is one past it does not. Pixels, rays and degrees that methods take
// are tested from Python (tests/python/test_caps.py).
#include "caps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "error.h"
#include "expr/build.h"
#include "expr/calculus.h"
#include "expr/parse.h"
#include "expr/print.h"
#include "numerics/ray_polynomial.h"
#include "program/program.h"

namespace irt {
namespace {

Expr sines(std::size_t depth) {
  Expr e = symbol("x");
  for (std::size_t i = 0; i < depth; ++i) e = call(Op::Sin, std::span(&e, 1));
  return e;
}

std::string nested(std::size_t levels) { return std::string(levels, '(') + "x" + std::string(levels, ')'); }

// sum of x^(k stride), k < terms
Expr powers(long terms, long stride) {
  std::vector<Expr> all;
  for (long k = 0; k < terms; ++k) all.push_back(pow(symbol("x"), number(k * stride)));
  return add(all);
}

Expr product(const Expr& a, const Expr& b) {
  const Expr both[] = {a, b};
  return mul(both);
}

Expr power(const Expr& a, long n) { return pow(a, number(n)); }

template <class Call>
void at_and_past(const Call& call, std::size_t cap) {
  EXPECT_NO_THROW(call(cap));
  EXPECT_THROW(call(cap + 1), LimitError);
}

TEST(Caps, Nodes) {
  at_and_past([](std::size_t n) { count_nodes(sines(n - 1)); }, limits::kNodes);
}

TEST(Caps, ParseDepth) {
  const auto repeated = [](const char* text, std::size_t n) {
    std::string all;
    while (n--) all += text;
    return all;
  };
  at_and_past([](std::size_t n) { parse(nested(n)); }, limits::kParseDepth);
  at_and_past([&](std::size_t n) { parse(repeated("sin(", n) + "x" + repeated(")", n)); }, limits::kParseDepth);
  at_and_past([&](std::size_t n) { parse("x" + repeated("^x", n)); }, limits::kParseDepth);
  at_and_past([&](std::size_t n) { parse(repeated("\u221a", n) + "x"); }, limits::kParseDepth);
  // Pairs have parentheses of their own.
  at_and_past([&](std::size_t n) { parse(repeated("Piecewise((", n) + "x" + repeated(", x < 1), (0, True))", n)); }, limits::kParseDepth / 2);
}

TEST(Caps, PrintDepth) {
  at_and_past([](std::size_t n) { to_string(sines(n - 1)); }, limits::kPrintDepth);
}

TEST(Caps, FormulaLength) {
  at_and_past([](std::size_t n) { parse("x" + std::string(n - 1, ' ')); }, limits::kFormulaLength);
}

TEST(Caps, IdentifierLength) {
  EXPECT_NO_THROW(symbol(std::string(limits::kIdentifierLength, 'a')));
  EXPECT_NO_THROW(parse(std::string(limits::kIdentifierLength, 'a')));
  EXPECT_THROW(symbol(std::string(limits::kIdentifierLength + 1, 'a')), ExpressionError);
  EXPECT_THROW(parse(std::string(limits::kIdentifierLength + 1, 'a')), Error);
}

TEST(Caps, NumberBits) {
  const mpz_class largest = (mpz_class(1) << limits::kNumberBits) - 1;
  const Expr n = number(mpq_class(largest)), one = number(1), two = number(2);
  const Expr same[] = {n, number(0)}, more[] = {n, one}, twice[] = {n, two};
  EXPECT_NO_THROW(add(same));
  EXPECT_THROW(add(more), LimitError);
  EXPECT_THROW(mul(twice), LimitError);
}

TEST(Caps, ExpandTerms) {
  EXPECT_NO_THROW(expand(product(powers(400, 1), powers(500, 400))));
  EXPECT_THROW(expand(product(powers(401, 1), powers(500, 401))), LimitError);
  static_assert(limits::kExpandTerms == 400 * 500);
}

TEST(Caps, ExpandProducts) {
  // A product of s and t terms counts s, for the first factor, and s t.
  std::vector<Expr> parts;
  for (long k = 1; k <= 4; ++k) parts.push_back(product(powers(400, k), powers(500, k)));
  parts.push_back(product(powers(400, 5), powers(495, 5)));
  static_assert(limits::kExpandProducts == 4 * (400 + 400 * 500) + 400 + 400 * 495);
  EXPECT_NO_THROW(expand(add(parts)));
  parts.push_back(product(parse("y + 1"), parse("y + 2")));
  EXPECT_THROW(expand(add(parts)), LimitError);
}

TEST(Caps, Degree) {
  const Expr most = power(parse("x^1000000 + y"), 1000);
  EXPECT_EQ(degree(most), limits::kDegree);
  EXPECT_THROW(degree(product(most, symbol("y"))), LimitError);
}

TEST(Caps, DerivativeArguments) {
  // A chain of n sines has a derivative of n factors, and so have all shorter ones.
  const auto most = static_cast<std::size_t>(std::sqrt(2.0 * static_cast<double>(limits::kDerivativeArguments)));
  EXPECT_NO_THROW(differentiate(sines(most - 2), "x"));
  EXPECT_THROW(differentiate(sines(most + 2), "x"), LimitError);
}

TEST(Caps, Exponent) {
  EXPECT_NO_THROW(program::lower(power(symbol("x"), limits::kExponent)));
  EXPECT_THROW(program::lower(power(symbol("x"), limits::kExponent + 1)), LimitError);
  EXPECT_NO_THROW(numerics::Formula(power(symbol("x"), limits::kExponent), {}));
  EXPECT_THROW(numerics::Formula(power(symbol("x"), limits::kExponent + 1), {}), LimitError);
}

TEST(Caps, Operations) {
  at_and_past([](std::size_t n) { program::lower(sines(n - 1)); }, limits::kOperations);
}

TEST(Caps, Parameters) {
  const auto sum = [](std::size_t n) {
    std::vector<Expr> all{symbol("x")};
    for (std::size_t k = 0; k < n; ++k) all.push_back(symbol("p" + std::to_string(k)));
    return add(all);
  };
  at_and_past([&](std::size_t n) { program::lower(sum(n)); }, limits::kParameters);
}

TEST(Caps, RayDegree) {
  const numerics::Formula at(power(symbol("x"), limits::kRayDegree), {}), past(power(symbol("x"), limits::kRayDegree + 1), {});
  EXPECT_TRUE(numerics::PolynomialPlan::of(at));
  EXPECT_FALSE(numerics::PolynomialPlan::of(past));
}

}  // namespace
}  // namespace irt
