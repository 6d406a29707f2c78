// Straight-line programs in static single assignment: what an expression becomes before kernels are emitted from it.
//
// Every value is computed once (common subexpressions are shared), and sums, quotients and powers have the form that
// inclusion arithmetic likes best: squares and even powers are kept, constants are folded into scales and shifts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "expr/expr.h"
#include "numerics/constant.h"

namespace irt::program {

enum class Code : std::uint8_t {
  Constant,    // value
  Coordinate,  // index 0, 1, 2: x, y, z; 3, 4, 5: how they change along a ray (along)
  Parameter,   // index into Program::parameters
  Neg,
  Add,
  Sub,
  Mul,
  Sqr,
  Power,       // a ** exponent, exponent >= 3
  Polynomial,  // of the value a; index into Program::polynomials
  Recip,
  Div,
  Sqrt,
  Cbrt,
  RealPower,  // a ** value, not an integer; a >= 0
  Pow,        // a ** b; a >= 0
  Exp,
  Log,
  Sinh,
  Cosh,
  Tanh,
  Sin,
  Cos,
  Tan,
  Asin,
  Acos,
  Atan,
  Atan2,
  Abs,
  Sign,
  Floor,
  Ceiling,
  Min,
  Max,
  Mod,
  Select,  // condition ? b : c
  // Conditions.
  Less,
  LessEqual,
  Equal,
  And,
  Or,
  Not,
  True,
  Undefined,  // the value of a Piecewise none of whose conditions holds
};

inline bool is_condition(Code code) { return code >= Code::Less && code <= Code::True; }

using Value = std::int32_t;  // index of an instruction

struct Instruction {
  Code code = Code::Constant;
  Value a = -1, b = -1, c = -1;
  numerics::Bounds value{0, 0};  // Constant; the exponent of RealPower
  std::int64_t index = 0;        // Coordinate, Parameter; the exponent of Power
  bool nonnegative = false;      // the value is never below zero
  bool nonpositive = false;      // or never above
  bool partial = false;          // the value may be undefined or discontinuous somewhere
};

struct Program {
  std::vector<Instruction> code;  // operands come before their users
  Value result = 0;
  Value numerator = -1;                 // where this is not zero, f is not (expr/fraction.h); -1: f has no poles to see through
  Value clip = -1;                      // where this is above zero, zeros of the result do not count; -1: they do everywhere
  bool derivative = false;              // made by `along`
  Value function = -1;                  // what the result is the derivative of, where that may be undefined or jump
  std::vector<std::string> parameters;  // sorted by name
  std::vector<std::vector<numerics::Bounds>> polynomials;  // coefficients, lowest first
  bool isovalue = false;                // one more input, after the parameters

  // Whether pieces of ray are told to be passed over for other reasons than the sign of f.
  bool has_region() const { return clip >= 0 || numerator >= 0; }
  bool has_choices() const {
    return std::ranges::any_of(code, [](const Instruction& i) { return i.code == Code::Min || i.code == Code::Max; });
  }
  std::size_t inputs() const { return parameters.size() + (isovalue ? 1 : 0); }

  const Instruction& operator[](Value v) const { return code[static_cast<std::size_t>(v)]; }
  bool is_constant(Value v) const { return (*this)[v].code == Code::Constant; }
};

// The program of f, or of f - isovalue with the isovalue as one more parameter; and of g, where zeros of f count only if
// g <= 0; with the numerator of f where `poles` asks for it and there is one. Symbols of both other than x, y, z are parameters. Throws LimitError past limits::kOperations.
Program lower(const Expr& f, bool isovalue = false, const Expr* g = nullptr, bool poles = false);

// The derivative of the result along a ray, or nothing where no rule gives one. Its enclosure over a piece of ray holds all slopes of f
// there if neither it nor f is rough: at kinks (Abs, Min, Max) the derivative jumps, at jumps f does.
std::optional<Program> along(const Program& program);

// Drops what no result needs and renumbers.
void prune(Program& program);

// An upper bound of the magnitude of every intermediate value, for interval and affine forms alike, where the
// coordinates stay below `coordinates` and the parameters below `parameters`; infinity where a value has no bound
// (division, log, tan, overflow). Tells which kernels need arithmetic that survives infinities.
double magnitude(const Program& program, const double coordinates[3], const std::vector<double>& parameters);

}  // namespace irt::program
