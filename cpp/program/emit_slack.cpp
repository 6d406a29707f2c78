// How far arithmetic without pads may be off: one pass with sums of magnitudes, and a count of roundings
// (docs/architecture.md, "What rounding may do to a piece"). The arithmetic is that of one of the algebras, or of values at points in double.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "program/emit.h"
#include "program/text.h"

namespace irt::program {
namespace {

// A bound of a value's magnitude, as text, how many roundings each of its terms has been through, and how many coordinates at points it is made of, each of which may
// be off by as large a part of its size.
struct Size {
  std::string text;
  double roundings = 0, places = 0;
};

double largest(const numerics::Bounds& b) { return std::max(std::fabs(b.lo), std::fabs(b.hi)); }

// What products may lose to underflow is covered by their roundings if their magnitudes are so much larger.
constexpr const char* kProduct = "fma({}, {}, (F)(R(64.0) * TINY / ULP))";
constexpr const char* kMore = "{} + (F)(R(64.0) * TINY / ULP)";

enum class Arithmetic { interval, affine, point };

class SlackEmitter {
 public:
  // Sizes are reals of `precision`; values at points are doubles, whatever that is.
  SlackEmitter(const Program& program, Precision precision, Arithmetic arithmetic)
      : program_(program), precision_(precision), affine_(arithmetic == Arithmetic::affine), point_(arithmetic == Arithmetic::point) {}

  std::string run() {
    if (program_.has_region() || program_.derivative) return {};
    for (Value v = 0; v < static_cast<Value>(program_.code.size()); ++v) {
      if (program_.is_constant(v) && v != program_.result) {
        sizes_.push_back({"(F)" + literal(largest(outward(program_[v].value, precision_))), point_ ? 2.0 : affine_ ? 1.0 : 0.0});
        continue;
      }
      Size s = size(v);
      if (s.text.empty()) return {};
      text_ += fmt::format("  const F {} = {};\n", name(v, 'm'), s.text);
      sizes_.push_back({name(v, 'm'), s.roundings, s.places});
    }
    // Two more for the comparison with the result (BARE in kernels/form.cl); a hundredth for products of roundings, as much for those of this pass.
    const Size& result = sizes_[static_cast<std::size_t>(program_.result)];
    const double count = 1.03 * (result.roundings + 2), half = point_ || precision_ == Precision::Double ? 0x1p-53 : 0x1p-24;
    if (count * half > 0.01) return {};
    const std::string rounding = "(F)" + literal(nearest({count * half, count * half}, Precision::Single));
    if (point_)
      return fmt::format("// How far its value in double may be off, from the sizes of the coordinates, which may be off by a part `place` of them.\n"
                         "static inline F irt_fine_error(F x, F y, F z, F place) {{\n{}  return fma((F)R({:.2f}), place, {}) * {};\n}}\n",
                         text_, 1.03 * result.places, rounding, result.text);
    return fmt::format("// How far the enclosure without pads may be off, from the magnitudes of the coordinates.\n"
                       "static inline F irt_slack(F x, F y, F z PARAMETERS) {{\n{}  return {} * {};\n}}\n", text_, rounding, result.text);
  }

 private:
  const Program& program_;
  Precision precision_;
  bool affine_, point_;
  std::string text_;
  std::vector<Size> sizes_;

  // The size of a value by those of its operands; no text where rounding has no such bound. Affine rules with several roundings
  // count each part's longest way; sizes |x| + |y| + z multiply as their forms do.
  Size size(Value v) const {
    const Instruction& in = program_[v];
    const auto operand = [&](Value w) { return w >= 0 ? sizes_[static_cast<std::size_t>(w)] : Size{}; };
    const auto constant = [&](Value w) { return w >= 0 && program_.is_constant(w); };
    const Size a = operand(in.a), b = operand(in.b);
    const double more = std::max(a.roundings, b.roundings) + 1, product = affine_ ? 3 : 1, places = std::max(a.places, b.places);
    if (affine_ && ((constant(in.a) && in.code != Code::Mul) || (constant(in.b) && in.code != Code::Add))) return {};
    switch (in.code) {
      case Code::Coordinate: return {coordinate(in.index), 0, 1};
      case Code::Parameter:
        if (point_) return {};  // its ends are floats
        return {fmt::format(kMore, fmt::format("max(fabs((F)p[{}]), fabs((F)p[{}]))", 2 * in.index, 2 * in.index + 1)), affine_ ? 4.0 : 0.0};
      case Code::Neg: return a;
      case Code::Add:
      case Code::Sub: return {fmt::format("{} + {}", a.text, b.text), more, places};
      case Code::Mul: {
        const double c = constant(in.a) ? nearest(program_[in.a].value, precision_) : 1;
        if (!(std::fabs(c) > 1e-30 && std::fabs(c) < 1e30)) return {};
        return {fmt::format(kProduct, a.text, b.text), constant(in.a) && !point_ ? b.roundings + 2 : a.roundings + b.roundings + product, a.places + b.places};
      }
      case Code::Sqr: return {fmt::format(kProduct, a.text, a.text), 2 * a.roundings + (affine_ ? 4 : 1), 2 * a.places};
      case Code::Power: {  // but of intervals: a square and a product, or two squares
        const double n = static_cast<double>(in.index);
        if (!affine_ && !point_) return {fmt::format(kMore, fmt::format("power_{}({})", in.index, a.text)), n * a.roundings + n, n * a.places};
        if (in.index > 4) return {};
        const std::string square = fmt::format(kProduct, a.text, a.text);
        return {fmt::format(kProduct, square, in.index == 3 ? a.text : square), n * a.roundings + (point_ ? n : 12), n * a.places};
      }
      case Code::Abs: return affine_ ? Size{} : a;
      case Code::Min:
      case Code::Max: return affine_ ? Size{} : Size{fmt::format("max({}, {})", a.text, b.text), more, places};
      // Values up to 1, by builtins that err by four ulp: as if of a magnitude larger by 1 than their operand's, which their slopes do not exceed.
      case Code::Sin:
      case Code::Cos: return point_ ? Size{fmt::format("{} + (F)1", a.text), std::max(a.roundings, 8.0) + 1, places} : Size{};
      case Code::Exp: return point_ && program_[in.a].nonpositive ? Size{fmt::format("{} + (F)1", a.text), std::max(a.roundings, 6.0) + 1, places} : Size{};
      default: return {};
    }
  }
};

}  // namespace

std::string emit_slack(const Program& program, Precision precision, bool affine) {
  return SlackEmitter(program, precision, affine ? Arithmetic::affine : Arithmetic::interval).run();
}

std::string emit_fine(const Program& program) {
  const std::string error = SlackEmitter(program, Precision::Single, Arithmetic::point).run();
  return error.empty() ? "" : in_doubles(value_function(program, program.result, "irt_fine", Precision::Double)) + error;
}

}  // namespace irt::program
