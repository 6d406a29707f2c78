// How large can intermediate values get? One pass with sums of magnitudes, which bound interval and affine forms alike.
#include <algorithm>
#include <cmath>
#include <limits>

#include "program/program.h"

namespace irt::program {

double magnitude(const Program& program, const double coordinates[3], const std::vector<double>& parameters) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> m(program.code.size());
  double largest = 0;
  for (std::size_t i = 0; i < program.code.size(); ++i) {
    const Instruction& in = program.code[i];
    const double a = in.a >= 0 ? m[static_cast<std::size_t>(in.a)] : 0;
    const double b = in.b >= 0 ? m[static_cast<std::size_t>(in.b)] : 0;
    const double c = in.c >= 0 ? m[static_cast<std::size_t>(in.c)] : 0;
    double r = 0;
    switch (in.code) {
      case Code::Constant: r = std::max(std::fabs(in.value.lo), std::fabs(in.value.hi)); break;
      // Slopes are those along a whole path, which is no longer than the bounds and a little more.
      case Code::Coordinate: r = in.index < 3 ? coordinates[in.index] : 4 * coordinates[in.index - 3]; break;
      case Code::Parameter: r = parameters[static_cast<std::size_t>(in.index)]; break;
      case Code::Neg: r = a; break;
      case Code::Add:
      case Code::Sub: r = a + b; break;
      case Code::Mul: r = a * b; break;
      case Code::Sqr: r = a * a; break;
      case Code::Power: r = std::pow(std::max(a, 1.0), static_cast<double>(in.index)); break;
      case Code::Polynomial: {
        const auto& coefficients = program.polynomials[static_cast<std::size_t>(in.index)];
        for (std::size_t k = coefficients.size(); k-- > 0;)
          r = r * 3 * std::max(a, 1.0) + std::max(std::fabs(coefficients[k].lo), std::fabs(coefficients[k].hi));
        break;
      }
      case Code::Sqrt: r = 2 * std::sqrt(a) + 1; break;
      case Code::Cbrt: r = 2 * std::cbrt(a) + 1; break;
      case Code::RealPower: r = in.value.lo > 0 ? 4 * std::pow(std::max(a, 1.0), in.value.hi) : kInfinity; break;
      case Code::Exp:
        // Of what is never positive the emitters hand on no range above zero; its reach is squared.
        r = 4 * std::exp(program[in.a].nonpositive ? 0 : a);
        largest = std::max(largest, a * a);
        break;
      case Code::Sinh:
      case Code::Cosh: r = 4 * std::exp(a); break;
      case Code::Sign: r = 2; break;
      // Lines reach beyond the range of the function, by less than that range.
      case Code::Tanh:
      case Code::Sin:
      case Code::Cos: r = 6; break;
      case Code::Atan:
      case Code::Atan2:
      case Code::Asin:
      case Code::Acos: r = 16; break;
      case Code::Abs: r = 4 * a; break;
      case Code::Floor:
      case Code::Ceiling: r = 2 * a + 1; break;
      case Code::Min:
      case Code::Max: r = 4 * std::max(a, b); break;
      case Code::Select: r = 2 * std::max(b, c); break;
      case Code::Undefined: r = 0; break;
      case Code::Recip:
      case Code::Div:
      case Code::Log:
      case Code::Pow:
      case Code::Tan:
      case Code::Mod: r = kInfinity; break;
      default: break;  // conditions
    }
    m[i] = std::isnan(r) ? kInfinity : r;
    largest = std::max(largest, m[i]);
  }
  return largest;
}

}  // namespace irt::program
