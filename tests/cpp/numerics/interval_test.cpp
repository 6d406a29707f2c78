// Intervals of doubles against MPFR at points inside them, for every operator.
#include "numerics/interval.h"

#include <gtest/gtest.h>

#include <random>

#include "expr/build.h"
#include "numerics/mpfr_interval.h"

namespace irt::numerics {
namespace {

struct Case {
  const char* name;
  Op op;
  int arity;
};

const Case kCases[] = {
    {"Add", Op::Add, 2},   {"Mul", Op::Mul, 2},     {"Sin", Op::Sin, 1},   {"Cos", Op::Cos, 1},     {"Tan", Op::Tan, 1},
    {"Asin", Op::Asin, 1}, {"Acos", Op::Acos, 1},   {"Atan", Op::Atan, 1}, {"Atan2", Op::Atan2, 2}, {"Sinh", Op::Sinh, 1},
    {"Cosh", Op::Cosh, 1}, {"Tanh", Op::Tanh, 1},   {"Exp", Op::Exp, 1},   {"Log", Op::Log, 1},     {"Cbrt", Op::Cbrt, 1},
    {"Abs", Op::Abs, 1},   {"Sign", Op::Sign, 1},   {"Floor", Op::Floor, 1}, {"Ceiling", Op::Ceiling, 1}, {"Min", Op::Min, 2},
    {"Max", Op::Max, 2},   {"Mod", Op::Mod, 2},     {"Pow", Op::Pow, 2}};

class EveryOperator : public testing::TestWithParam<Case> {};

double random_real(std::mt19937_64& random) {
  std::uniform_real_distribution<double> exponent(-20, 12), mantissa(-1, 1);
  const double special[] = {0, 1, -1, 0.5, 2, 3.141592653589793, -1.5707963267948966};
  if (random() % 8 == 0) return special[random() % std::size(special)];
  return random() % 2 ? std::ldexp(mantissa(random), static_cast<int>(exponent(random))) : 4 * mantissa(random);
}

// e at exact doubles, to 300 bits; nothing where it is undefined.
void expect_holds(const Expr& e, long exponent, int arity, std::mt19937_64& random) {
  constexpr mpfr_prec_t kBits = 300;
  std::vector<Interval> ranges;
  for (int i = 0; i < arity; ++i) {
    const double a = random_real(random), b = random() % 4 ? a + std::fabs(random_real(random)) * 0x1p-3 : a;
    ranges.emplace_back(std::min(a, b), std::max(a, b));
  }
  std::vector<const Interval*> args;
  for (const Interval& r : ranges) args.push_back(&r);
  const Interval range = apply(e.op(), exponent, args);
  for (int k = 0; k < 6; ++k) {
    std::vector<MpfrInterval> points;
    for (const Interval& r : ranges) {
      const double share = k < 2 ? k : std::uniform_real_distribution<double>(0, 1)(random);
      const double v = std::clamp(r.lo + share * (r.hi - r.lo), r.lo, r.hi);
      points.push_back(MpfrInterval::of(v, v, kBits));
    }
    std::vector<const MpfrInterval*> at;
    for (const MpfrInterval& p : points) at.push_back(&p);
    const MpfrInterval value = apply(e, at, kBits);
    if (value.empty || (value.doubtful && e.op() != Op::Mod)) continue;
    ASSERT_FALSE(range.empty);
    ASSERT_LE(mpfr_cmp_d(value.lo, range.hi), 0) << ranges[0].lo << " " << ranges[0].hi << " -> " << range.lo << " " << range.hi;
    ASSERT_GE(mpfr_cmp_d(value.hi, range.lo), 0) << ranges[0].lo << " " << ranges[0].hi << " -> " << range.lo << " " << range.hi;
  }
}

TEST_P(EveryOperator, HoldsItsValues) {
  const Case& c = GetParam();
  std::mt19937_64 random(7);
  const Expr symbols[] = {symbol("a"), symbol("b")};
  const Expr e = call(c.op, std::span(symbols, static_cast<std::size_t>(c.arity)));
  for (int i = 0; i < 4000; ++i) expect_holds(e, 0, c.arity, random);
}

INSTANTIATE_TEST_SUITE_P(Interval, EveryOperator, testing::ValuesIn(kCases), [](const auto& info) { return info.param.name; });

TEST(Interval, HoldsIntegerPowers) {
  std::mt19937_64 random(8);
  for (const long n : {2L, 3L, 4L, 7L, 8L, 200L, 201L, -1L, -2L, -3L})
    for (int i = 0; i < 1000; ++i) expect_holds(pow(symbol("a"), Expr(n)), n, 1, random);
}

TEST(Interval, SquareRootsAreExactWhereDoublesAre) {
  const Interval four(4), half(0.5);
  const Interval* args[] = {&four, &half};
  const Interval r = apply(Op::Pow, 0, args);
  EXPECT_LE(r.lo, 2);
  EXPECT_GE(r.hi, 2);
  EXPECT_LT(r.hi - r.lo, 1e-14);
  EXPECT_FALSE(r.doubtful);
}

TEST(Interval, DomainsAreClippedOrEmpty) {
  const Interval below(-2, -1), across(-1, 4), zero(0);
  const Interval *b[] = {&below}, *a[] = {&across}, *z[] = {&zero};
  EXPECT_TRUE(apply(Op::Log, 0, b).empty);
  EXPECT_TRUE(apply(Op::Log, 0, a).doubtful);
  EXPECT_TRUE(apply(Op::Pow, -1, z).empty);
  EXPECT_TRUE(apply(Op::Pow, -1, a).doubtful);
  EXPECT_TRUE(apply(Op::Floor, 0, a).doubtful);
  EXPECT_FALSE(apply(Op::Cbrt, 0, a).doubtful);
}

}  // namespace
}  // namespace irt::numerics
