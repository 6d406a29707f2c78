// The operator table. To add an operator: a code (program.h), a row here, helpers in kernels/, lowering in lower.cpp.
#include "program/operators.h"

#include <array>
#include <cstddef>

namespace irt::program {
namespace {

constexpr const char* kCore = "interval.cl";
constexpr const char* kDivide = "interval_divide.cl";
constexpr const char* kPower = "interval_power.cl";
constexpr const char* kExponential = "interval_exponential.cl";
constexpr const char* kTrigonometric = "interval_trigonometric.cl";
constexpr const char* kStep = "interval_step.cl";
constexpr const char* kModulo = "interval_modulo.cl";
constexpr const char* kChoice = "interval_choice.cl";
constexpr const char* kPolynomial = "polynomial.cl";
constexpr const char* kAffine = "affine.cl";
constexpr const char* kAffineDivide = "affine_divide.cl";
constexpr const char* kAffineExponential = "affine_exponential.cl";
constexpr const char* kAffineRealPower = "affine_real_power.cl";
constexpr const char* kAffineTrigonometric = "affine_trigonometric.cl";
constexpr const char* kAffineChoice = "affine_choice.cl";
constexpr const char* kAffineModulo = "affine_modulo.cl";
constexpr const char* kAffineSelect = "affine_select.cl";

// Rows without helpers are written by the emitters themselves: they need constants, signs or masks of their operands.
constexpr std::array kTable = {
    Operator{Code::Constant, "constant", 0, nullptr, "", nullptr, kCore, nullptr, kAffine, false},
    Operator{Code::Coordinate, "coordinate", 0, nullptr, "", nullptr, kCore, nullptr, kAffine, false},
    Operator{Code::Parameter, "parameter", 0, nullptr, "", nullptr, kCore, nullptr, kAffine, false},
    Operator{Code::Neg, "neg", 1, "-$a", "-(F)1", "ia_neg", kCore, "ra_neg", kAffine, false},
    Operator{Code::Add, "add", 2, "$a + $b", "(F)1;(F)1", "ia_add", kCore, "ra_add", kAffine, false},
    Operator{Code::Sub, "sub", 2, "$a - $b", "(F)1;-(F)1", "ia_sub", kCore, "ra_sub", kAffine, false},
    Operator{Code::Mul, "mul", 2, "$a * $b", "$b;$a", "ia_mul", kCore, "ra_mul", kAffine, false},
    Operator{Code::Sqr, "sqr", 1, "$a * $a", "R(2.0) * $a", "ia_sqr", kCore, "ra_sqr", kAffine, false},
    Operator{Code::Power, "power", 1, nullptr, "", nullptr, kCore, nullptr, kAffine, false},
    Operator{Code::Polynomial, "polynomial", 1, nullptr, "", nullptr, kPolynomial, nullptr, kAffine, false},
    Operator{Code::Recip, "recip", 1, "R(1.0) / $a", "-$r * $r", "ia_recip", kDivide, "ra_recip", kAffineDivide, true, true},
    Operator{Code::Div, "div", 2, "$a / $b", "R(1.0) / $b;-$r / $b", "ia_div", kDivide, "ra_div", kAffineDivide, true, true},
    Operator{Code::Sqrt, "sqrt", 1, "sqrt($a)", "R(0.5) / $r", "ia_sqrt", kDivide, "ra_sqrt", kAffineDivide, true, true},
    Operator{Code::Cbrt, "cbrt", 1, "cbrt($a)", "R(1.0) / (R(3.0) * $r * $r)", "ia_cbrt", kDivide, "ra_cbrt", kAffineDivide, false, true},
    Operator{Code::RealPower, "real power", 1, "exp($v * log($a))", "$v * exp(($v - R(1.0)) * log($a))", nullptr, kPower, "ra_pow_constant", kAffineRealPower, true, true},
    Operator{Code::Pow, "pow", 2, "exp($b * log($a))", "$b * exp(($b - R(1.0)) * log($a));$r * log($a)", "ia_pow", kPower, "ra_pow", kAffineRealPower, true, true},
    Operator{Code::Exp, "exp", 1, "exp($a)", "$r", "ia_exp", kExponential, "ra_exp", kAffineExponential, false, true},
    Operator{Code::Log, "log", 1, "log($a)", "R(1.0) / $a", "ia_log", kExponential, "ra_log", kAffineExponential, true, true},
    Operator{Code::Sinh, "sinh", 1, "sinh($a)", "cosh($a)", "ia_sinh", kExponential, "ra_sinh", kAffineExponential, false, true},
    Operator{Code::Cosh, "cosh", 1, "cosh($a)", "sinh($a)", "ia_cosh", kExponential, "ra_cosh", kAffineExponential, false, true},
    Operator{Code::Tanh, "tanh", 1, "tanh($a)", "R(1.0) - $r * $r", "ia_tanh", kExponential, "ra_tanh", kAffineExponential, false, true},
    Operator{Code::Sin, "sin", 1, "sin($a)", "cos($a)", "ia_sin", kTrigonometric, "ra_sin", kAffineTrigonometric, false},
    Operator{Code::Cos, "cos", 1, "cos($a)", "-sin($a)", "ia_cos", kTrigonometric, "ra_cos", kAffineTrigonometric, false},
    Operator{Code::Tan, "tan", 1, "tan($a)", "R(1.0) + $r * $r", "ia_tan", kTrigonometric, "ra_tan", kAffineTrigonometric, true, true},
    Operator{Code::Asin, "asin", 1, "asin($a)", "R(1.0) / sqrt(R(1.0) - $a * $a)", "ia_asin", kTrigonometric, "ra_asin", kAffineTrigonometric, true, true},
    Operator{Code::Acos, "acos", 1, "acos($a)", "R(-1.0) / sqrt(R(1.0) - $a * $a)", "ia_acos", kTrigonometric, "ra_acos", kAffineTrigonometric, true, true},
    Operator{Code::Atan, "atan", 1, "atan($a)", "R(1.0) / (R(1.0) + $a * $a)", "ia_atan", kTrigonometric, "ra_atan", kAffineTrigonometric, false, true},
    Operator{Code::Atan2, "atan2", 2, "atan2($a, $b)", "$b / ($a * $a + $b * $b);-$a / ($a * $a + $b * $b)", "ia_atan2",
             kTrigonometric, "ra_atan2", kAffineTrigonometric, true, true},
    Operator{Code::Abs, "abs", 1, "fabs($a)", "sign($a)", "ia_abs", kCore, "ra_abs", kAffineChoice, false, true},
    Operator{Code::Sign, "sign", 1, "sign($a)", "", "ia_sign", kStep, nullptr, nullptr, true},
    Operator{Code::Floor, "floor", 1, "floor($a)", "", "ia_floor", kStep, nullptr, nullptr, true},
    Operator{Code::Ceiling, "ceiling", 1, "ceil($a)", "", "ia_ceiling", kStep, nullptr, nullptr, true},
    Operator{Code::Min, "min", 2, "min($a, $b)", "SELECT(LE($a, $b), (F)1, (F)0);SELECT(LE($a, $b), (F)0, (F)1)", "ia_min",
             kCore, "ra_min", kAffineChoice, false, true},
    Operator{Code::Max, "max", 2, "max($a, $b)", "SELECT(GE($a, $b), (F)1, (F)0);SELECT(GE($a, $b), (F)0, (F)1)", "ia_max",
             kCore, "ra_max", kAffineChoice, false, true},
    Operator{Code::Mod, "mod", 2, "$a - $b * floor($a / $b)", "(F)1;-floor($a / $b)", "ia_mod", kModulo, "ra_mod", kAffineModulo, true, true},
    Operator{Code::Select, "select", 3, "SELECT($a, $b, $c)", "", nullptr, kChoice, "ra_select", kAffineSelect, true, true},
    Operator{Code::Less, "less", 2, "LT($a, $b)", "", "tri_less", kChoice, nullptr, nullptr, false},
    Operator{Code::LessEqual, "less equal", 2, "LE($a, $b)", "", "tri_less_equal", kChoice, nullptr, nullptr, false},
    Operator{Code::Equal, "equal", 2, "EQ($a, $b)", "", "tri_equal", kChoice, nullptr, nullptr, false},
    Operator{Code::And, "and", 2, "$a & $b", "", "tri_and", kChoice, nullptr, nullptr, false},
    Operator{Code::Or, "or", 2, "$a | $b", "", "tri_or", kChoice, nullptr, nullptr, false},
    Operator{Code::Not, "not", 1, "~$a", "", "tri_not", kChoice, nullptr, nullptr, false},
    Operator{Code::True, "true", 0, "ALL", "", "tri_true", kChoice, nullptr, nullptr, false},
    Operator{Code::Undefined, "undefined", 0, "(F)NAN", "", nullptr, kChoice, nullptr, nullptr, true},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kTable.size(); ++i)
    if (static_cast<std::size_t>(kTable[i].code) != i) return false;
  return kTable.size() == static_cast<std::size_t>(Code::Undefined) + 1;
}
static_assert(in_order(), "the table has one row for each code, in the order of the codes");

}  // namespace

const Operator& describe(Code code) { return kTable[static_cast<std::size_t>(code)]; }

}  // namespace irt::program
