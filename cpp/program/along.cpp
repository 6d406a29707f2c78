// The derivative of a program's result along a ray, as a program: forward differentiation, written once for every algebra, because
// what comes out is enclosed by the same emitters. S3 isolates roots by it; kernels/isolate.cl uses it.
#include <cmath>

#include "program/numbering.h"

namespace irt::program {
namespace {

using numerics::Bounds;

constexpr Value kZero = -1;  // the derivative of what does not vary along the ray

// n c, rounded outward.
Bounds times(Bounds c, double n) {
  const auto rounded = [&](double v, double direction) {
    const double p = n * v;
    return std::fma(n, v, -p) == 0 ? p : std::nextafter(p, direction);
  };
  return {rounded(c.lo, -HUGE_VAL), rounded(c.hi, HUGE_VAL)};
}

class Along {
 public:
  explicit Along(const Program& program) : out_(program) {}

  std::optional<Program> run() {
    const auto n = static_cast<Value>(out_.code.size());
    slopes_.assign(out_.code.size(), kZero);
    for (Value v = 0; v < n; ++v) slopes_[static_cast<std::size_t>(v)] = slope(v);
    if (!exists_) return std::nullopt;
    const Value d = slopes_[static_cast<std::size_t>(out_.result)];
    out_.derivative = true;
    out_.function = out_[out_.result].partial ? out_.result : -1;
    out_.result = d == kZero ? constant(0) : d;
    out_.clip = out_.numerator = -1;
    prune(out_);
    return std::move(out_);
  }

 private:
  Program out_;
  std::vector<Value> slopes_;
  Numbering numbering_{out_};
  bool exists_ = true;

  Value emit(const Instruction& i) { return numbering_.emit(i); }

  Value constant(Bounds b) { return emit({.code = Code::Constant, .value = b, .nonnegative = b.lo >= 0}); }
  Value constant(double v) { return constant({v, v}); }
  Value one(Code code, Value a) { return emit({.code = code, .a = a}); }
  Value two(Code code, Value a, Value b) { return emit({.code = code, .a = a, .b = b}); }
  Value square(Value a) { return emit({.code = Code::Sqr, .a = a, .nonnegative = true}); }
  Value plus_one(Value a) { return two(Code::Add, a, constant(1)); }

  // The rules below may meet derivatives that are zero.
  Value neg(Value a) { return a == kZero ? kZero : one(Code::Neg, a); }
  Value mul(Value a, Value b) {
    if (a == kZero || b == kZero) return kZero;
    if (out_.is_constant(b)) std::swap(a, b);  // the constant first
    return two(Code::Mul, a, b);
  }
  Value div(Value a, Value b) { return a == kZero ? kZero : two(Code::Div, a, b); }
  Value add(Value a, Value b) { return a == kZero ? b : b == kZero ? a : two(Code::Add, a, b); }
  Value sub(Value a, Value b) { return b == kZero ? a : a == kZero ? neg(b) : two(Code::Sub, a, b); }
  Value some(Value a) { return a == kZero ? constant(0) : a; }
  Value select(Value condition, Value a, Value b) {
    if (a == kZero && b == kZero) return kZero;
    return emit({.code = Code::Select, .a = condition, .b = some(a), .c = some(b)});
  }

  Value power(Value a, std::int64_t n) {
    return n == 1 ? a : n == 2 ? square(a) : emit({.code = Code::Power, .a = a, .index = n, .nonnegative = n % 2 == 0});
  }

  Value polynomial(const Instruction& in) {
    std::vector<Bounds> c;
    const auto& original = out_.polynomials[static_cast<std::size_t>(in.index)];
    for (std::size_t k = 1; k < original.size(); ++k) c.push_back(times(original[k], static_cast<double>(k)));
    if (c.size() > 3) {
      out_.polynomials.push_back(std::move(c));
      return emit({.code = Code::Polynomial, .a = in.a, .index = static_cast<std::int64_t>(out_.polynomials.size() - 1)});
    }
    // Taylor forms begin at degree 3.
    Value sum = constant(c.back());
    for (std::size_t k = c.size() - 1; k-- > 0;) sum = two(Code::Add, mul(sum, in.a), constant(c[k]));
    return sum;
  }

  Value slope(Value v) {
    const Instruction in = out_[v];
    const auto of = [&](Value w) { return w < 0 ? kZero : slopes_[static_cast<std::size_t>(w)]; };
    const Value a = in.a, b = in.b, da = of(in.a), db = of(in.b), dc = of(in.c);
    if (in.code == Code::Coordinate) return emit({.code = Code::Coordinate, .index = in.index + 3});
    if (da == kZero && db == kZero && dc == kZero) return kZero;
    switch (in.code) {
      case Code::Neg: return neg(da);
      case Code::Add: return add(da, db);
      case Code::Sub: return sub(da, db);
      case Code::Mul: return add(mul(a, db), mul(b, da));
      case Code::Sqr: return mul(constant(2), mul(a, da));
      case Code::Power: return mul(constant(static_cast<double>(in.index)), mul(power(a, in.index - 1), da));
      case Code::Polynomial: return mul(polynomial(in), da);
      case Code::Recip: return neg(mul(square(v), da));
      case Code::Div: return div(sub(da, mul(v, db)), b);
      case Code::Sqrt: return mul(constant(0.5), div(da, v));
      case Code::Cbrt: return div(da, mul(constant(3), square(v)));
      case Code::RealPower: {
        const Bounds less{std::nextafter(in.value.lo - 1, -HUGE_VAL), std::nextafter(in.value.hi - 1, HUGE_VAL)};
        exists_ = exists_ && (less.lo > 0 || less.hi < 0);
        return mul(constant(in.value), mul(emit({.code = Code::RealPower, .a = a, .value = less, .nonnegative = true}), da));
      }
      case Code::Pow: return mul(v, add(mul(b, div(da, a)), mul(db == kZero ? kZero : one(Code::Log, a), db)));
      case Code::Exp: return mul(v, da);
      case Code::Log: return div(da, a);
      case Code::Sinh: return mul(one(Code::Cosh, a), da);
      case Code::Cosh: return mul(one(Code::Sinh, a), da);
      case Code::Tanh: return mul(plus_one(neg(square(v))), da);
      case Code::Sin: return mul(one(Code::Cos, a), da);
      case Code::Cos: return neg(mul(one(Code::Sin, a), da));
      case Code::Tan: return mul(plus_one(square(v)), da);
      case Code::Asin: return div(da, one(Code::Sqrt, plus_one(neg(square(a)))));
      case Code::Acos: return neg(div(da, one(Code::Sqrt, plus_one(neg(square(a))))));
      case Code::Atan: return div(da, plus_one(square(a)));
      case Code::Atan2: return div(sub(mul(b, da), mul(a, db)), two(Code::Add, square(a), square(b)));
      case Code::Abs: return mul(one(Code::Sign, a), da);
      case Code::Min: return select(two(Code::LessEqual, a, b), da, db);
      case Code::Max: return select(two(Code::LessEqual, b, a), da, db);
      case Code::Mod: return sub(da, mul(db == kZero ? kZero : one(Code::Floor, two(Code::Div, a, b)), db));
      case Code::Select: return select(a, db, dc);
      default: return kZero;  // steps, whose jumps are marked; conditions
    }
  }
};

}  // namespace

std::optional<Program> along(const Program& program) { return Along(program).run(); }

}  // namespace irt::program
