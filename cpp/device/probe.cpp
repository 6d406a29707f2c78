// The probe: a driver can compile plain arithmetic and die, hang or err on builtins, so all kinds of them are called.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "device/device.h"

namespace irt::device {
namespace {

struct Builtin {
  const char* call;  // of F v in [0.1, 0.9]
  double (*expected)(double);
};

constexpr Builtin kBuiltins[] = {
    {"sqrt(v)", [](double v) { return std::sqrt(v); }},
    {"cbrt(v)", [](double v) { return std::cbrt(v); }},
    {"exp(v)", [](double v) { return std::exp(v); }},
    {"log(v)", [](double v) { return std::log(v); }},
    {"sin(v)", [](double v) { return std::sin(v); }},
    {"cos(v)", [](double v) { return std::cos(v); }},
    {"tan(v)", [](double v) { return std::tan(v); }},
    {"asin(v)", [](double v) { return std::asin(v); }},
    {"acos(v)", [](double v) { return std::acos(v); }},
    {"atan(v)", [](double v) { return std::atan(v); }},
    {"atan2(v, (F)2)", [](double v) { return std::atan2(v, 2); }},
    {"sinh(v)", [](double v) { return std::sinh(v); }},
    {"cosh(v)", [](double v) { return std::cosh(v); }},
    {"tanh(v)", [](double v) { return std::tanh(v); }},
    {"fma(v, v, (F)1)", [](double v) { return v * v + 1; }},
    {"min(v, (F)0.5f) + max(v, (F)0.5f)", [](double v) { return v + 0.5; }},
    {"clamp(v, (F)0.25f, (F)0.5f)", [](double v) { return std::fmin(std::fmax(v, 0.25), 0.5); }},
    {"floor(v * (F)4) + ceil(v * (F)4)", [](double v) { return std::floor(v * 4) + std::ceil(v * 4); }},
    {"PICK((F)1, (F)2, v < (F)0.5f)", [](double v) { return v < 0.5 ? 2.0 : 1.0; }},
    {"ANY(v < (F)0) ? (F)3 : (F)4", [](double) { return 4.0; }},
    {"FLOAT(INT(v * (F)8) << 1)", [](double v) { return 2 * std::floor(v * 8); }},
    {"sign(v) + fabs(-v)", [](double v) { return 1 + v; }},
};

constexpr std::size_t kPackets = 4;

template <class T>
std::string run(Device& device, int width) {
  const bool wide = sizeof(T) == 8;
  const std::string w = width == 1 ? "" : std::to_string(width), real = wide ? "double" : "float", integer = wide ? "long" : "int";
  std::string source = fmt::format("#pragma OPENCL FP_CONTRACT OFF\ntypedef {0}{2} F;\ntypedef {1}{2} I;\n#define INT(v) convert_{1}{2}(v)\n"
                                   "#define FLOAT(v) convert_{0}{2}(v)\n", real, integer, w);
  source += width == 1 ? "#define PICK(a, b, m) ((m) ? (b) : (a))\n#define ANY(m) (m)\n#define LOAD(p) (*(p))\n#define STORE(v, p) (*(p) = (v))\n"
                       : fmt::format("#define PICK(a, b, m) select(a, b, m)\n#define ANY(m) any(m)\n#define LOAD(p) vload{0}(0, p)\n#define STORE(v, p) vstore{0}(v, 0, p)\n", width);
  source += fmt::format("__kernel void probe(__global const {0}* in, __global {0}* out, const int n, __global uchar* bytes, const int first_column, const int first_row) {{\n"
                        "  const size_t at = {1} * (first_column + get_global_id(0));\n  const F v = LOAD(in + at);\n", real, width);
  int k = 0;
  for (const Builtin& b : kBuiltins) source += fmt::format("  STORE({}, out + {} * n + at);\n", b.call, k++);
  // The loop of a root finder: masks that decide when it ends.
  source += "  I active = v > (F)0;\n  F sum = (F)0;\n  I count = (I)0;\n";
  source += width == 1 ? "  active = -active;\n" : "";
  source += fmt::format("  while (ANY(active)) {{\n    sum += v;\n    count -= active;\n    active &= {}(sum < (F)3);\n  }}\n", width == 1 ? "-" : "");
  source += fmt::format("  STORE(FLOAT(count), out + {} * n + at);\n  {};\n}}\n", k, width == 1 ? "bytes[at] = convert_uchar(count)" : fmt::format("vstore{0}(convert_uchar{0}(count), 0, bytes + at)", width));
  const std::size_t n = kPackets * static_cast<std::size_t>(width), outputs = std::size(kBuiltins) + 1;
  const auto allocate = [](std::size_t bytes) { return std::unique_ptr<void, decltype(&std::free)>(std::aligned_alloc(64, (bytes + 63) / 64 * 64), &std::free); };
  const auto in = allocate(n * sizeof(T)), out = allocate(n * outputs * sizeof(T)), bytes = allocate(n);
  T *x = static_cast<T*>(in.get()), *y = static_cast<T*>(out.get());
  for (std::size_t i = 0; i < n; ++i) x[i] = static_cast<T>(0.1 + 0.8 * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
  const auto kernel = device.kernel(source, "probe");
  const auto in_buffer = device.buffer(x, n * sizeof(T), Access::read), out_buffer = device.buffer(y, n * outputs * sizeof(T), Access::write),
             byte_buffer = device.buffer(bytes.get(), n, Access::write);
  const Arg args[] = {in_buffer.get(), out_buffer.get(), static_cast<std::int32_t>(n), byte_buffer.get()};
  device.run(*kernel, args, kPackets, 1, {});
  device.read({out_buffer.get(), byte_buffer.get()});
  const double tolerance = wide ? 1e-13 : 1e-5;
  for (std::size_t i = 0; i < n; ++i) {
    const double v = static_cast<double>(x[i]);
    for (std::size_t b = 0; b < std::size(kBuiltins); ++b) {
      const double got = static_cast<double>(y[b * n + i]), expected = kBuiltins[b].expected(v);
      if (!(std::fabs(got - expected) <= tolerance * (1 + std::fabs(expected))))
        return fmt::format("{} at {} gave {} instead of {}", kBuiltins[b].call, v, got, expected);
    }
    T sum = 0;
    int count = 0;
    for (; count == 0 || sum < 3; ++count) sum += x[i];
    if (y[(outputs - 1) * n + i] != static_cast<T>(count) || static_cast<unsigned char*>(bytes.get())[i] != count) return fmt::format("a masked loop ran {} times instead of {}", static_cast<double>(y[(outputs - 1) * n + i]), count);
  }
  return {};
}

}  // namespace

// Doubles as wide as the floats: rays are set up in them.
std::string probe(Device& device) {
  const int width = device.info().width;
  std::string wrong = run<float>(device, width);
  if (wrong.empty() && device.info().fp64) wrong = run<double>(device, width);
  return wrong;
}

}  // namespace irt::device
