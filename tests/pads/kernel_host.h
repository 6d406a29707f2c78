// Kernels as C++: what lets kernels/*.cl be compiled for packets of one ray on the host, with arithmetic that errs by all that OpenCL permits, so that what a
// function promises (a contract) can be held against exact arithmetic. tests/python/contracts.py compiles and runs it.
//
// VARIANT says which text: 0 single precision with rays set up in double, 1 single alone, 2 double.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <type_traits>
#include <utility>

#ifdef __SIZEOF_FLOAT128__
typedef __float128 exact;  // 113 bits: what it rounds is 2^60 times as small as any pad
#else
typedef long double exact;
#endif

// ---- samples

struct Random {
  std::uint64_t state;
  std::uint64_t bits() {
    state += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double between(double a, double b) { return a + (b - a) * unit(); }
  int below(int n) { return static_cast<int>(bits() % static_cast<unsigned>(n)); }
  bool chance(double p) { return unit() < p; }
  double sign() { return chance(0.5) ? 1 : -1; }
  // 2^a to 2^b; often a little more than a power of two, where half an ulp is largest.
  double size(double a, double b) {
    const double v = std::exp2(between(a, b));
    return chance(0.5) ? v : std::exp2(std::floor(between(a, b))) * (1 + unit() * std::exp2(-between(0, 12)));
  }
  // -1, 1, or between.
  double part() { return chance(0.7) ? sign() : between(-1, 1); }
};

extern Random random_numbers;
extern double pad_shares[];  // what is left of each pad
extern int error_mode;       // of sloppy operations: -1, 1, or 0 for either at random
#define PAD(k, constant) ((real)pad_shares[k] * (constant))

// ---- contracts

// Whether one random sample keeps the contract.
struct Contract {
  const char* name;
  bool (*sample)(Random&);
  int variant;
  Contract* next;
  static Contract* first;
  Contract(const char* n, bool (*s)(Random&), int v) : name(n), sample(s), variant(v), next(first) { first = this; }
};
#define CONTRACT(name) \
  static bool name##_holds(Random& rng); \
  static Contract name##_contract(#name, name##_holds, VARIANT); \
  static bool name##_holds(Random& rng)

inline exact magnitude(exact v) { return v < 0 ? -v : v; }
inline exact least(exact a, exact b) { return a < b ? a : b; }
inline exact most(exact a, exact b) { return a < b ? b : a; }
// a <= b but for the rounding of `exact` itself.
inline bool at_most(exact a, exact b) { return a <= b + (magnitude(a) + magnitude(b)) * static_cast<exact>(0x1p-105L); }
inline exact root_of(exact v) {
  if (v <= 0) return 0;
  exact r = static_cast<exact>(std::sqrt(static_cast<long double>(v)));
  for (int i = 0; i < 2; ++i) r = (r + v / r) / 2;
  return r;
}

// ---- reals of a packet of one

inline int error_sign() { return error_mode ? error_mode : (random_numbers.bits() & 1 ? 1 : -1); }

// y moved by n ulp and rounded so that no more than that comes out: the worst quotient or root that OpenCL permits.
inline float moved(double y, double n) {
  if (!std::isfinite(y) || y == 0 || std::fabs(y) >= 0x1p127) return static_cast<float>(y);
  // The ulp below powers of two, which the value may have been rounded to.
  const double unit = std::exp2(std::ilogb(std::fabs(y) * (1 - 0x1p-52)) - 23);
  const int sign = error_sign();
  const double wanted = y + sign * n * unit;
  const float v = static_cast<float>(wanted);
  return sign * (v - wanted) > 0 ? std::nextafterf(v, static_cast<float>(sign) * -INFINITY) : v;
}
inline float quotient(float a, float b) { return moved(static_cast<double>(a) / static_cast<double>(b), 2.5); }
inline double quotient(double a, double b) { return a / b; }
inline float root(float a) { return moved(std::sqrt(static_cast<double>(a)), 3); }
inline double root(double a) { return std::sqrt(a); }

template <class T>
struct Number {
  T v;
  Number() = default;
  template <class U, class = std::enable_if_t<std::is_arithmetic_v<U>>>
  Number(U u) : v(static_cast<T>(u)) {}
  template <class U>
  explicit Number(Number<U> o) : v(static_cast<T>(o.v)) {}
  explicit operator exact() const { return v; }

  friend Number operator+(Number a, Number b) { return a.v + b.v; }
  friend Number operator-(Number a, Number b) { return a.v - b.v; }
  friend Number operator*(Number a, Number b) { return a.v * b.v; }
  friend Number operator/(Number a, Number b) { return quotient(a.v, b.v); }
  friend Number operator-(Number a) { return -a.v; }
  Number& operator+=(Number b) { return *this = *this + b; }
  Number& operator-=(Number b) { return *this = *this - b; }
  Number& operator*=(Number b) { return *this = *this * b; }
  friend bool operator<(Number a, Number b) { return a.v < b.v; }
  friend bool operator<=(Number a, Number b) { return a.v <= b.v; }
  friend bool operator>(Number a, Number b) { return a.v > b.v; }
  friend bool operator>=(Number a, Number b) { return a.v >= b.v; }
  friend bool operator==(Number a, Number b) { return a.v == b.v; }
  friend Number fma(Number a, Number b, Number c) { return std::fma(a.v, b.v, c.v); }
  friend Number fabs(Number a) { return std::fabs(a.v); }
  friend Number floor(Number a) { return std::floor(a.v); }
  friend Number sqrt(Number a) { return root(a.v); }
  friend Number cbrt(Number a) { return std::cbrt(a.v); }
  friend Number copysign(Number a, Number b) { return std::copysign(a.v, b.v); }
  friend Number min(Number a, Number b) { return b.v < a.v ? b : a; }
  friend Number max(Number a, Number b) { return a.v < b.v ? b : a; }
  friend Number clamp(Number a, Number lo, Number hi) { return min(max(a, lo), hi); }
};
template <class T, class = std::enable_if_t<std::is_integral_v<T>>>
T min(T a, T b) { return b < a ? b : a; }
template <class T, class = std::enable_if_t<std::is_integral_v<T>>>
T max(T a, T b) { return a < b ? b : a; }

// ---- what the generated header of a kernel defines (cpp/kernel/assemble.cpp)

#define __global
#define __constant static const
#define __kernel
#define __attribute__(attributes)
typedef unsigned char uchar;
typedef unsigned int uint;
inline size_t get_global_id(int) { return 0; }

#define W 1
#define IRT_DOUBLE (VARIANT == 2)
#define IRT_SPLIT (VARIANT == 0)
#define IRT_OUTWARD 1
#define IRT_INFINITE 0
#define IRT_LIST 0
#define IRT_NORMAL 0
#define IRT_RGB 0
#define IRT_PIECES 0
#define IRT_SHARPENS 0
#define IRT_PARTIAL 0
#define IRT_CLIP 0
#if VARIANT == 2
typedef double real;
typedef long I;
inline long bits_of(Number<double> v) { long i; std::memcpy(&i, &v, sizeof i); return i; }
inline Number<double> of_bits(long i) { double v; std::memcpy(&v, &i, sizeof v); return v; }
#else
typedef float real;
typedef int I;
inline int bits_of(Number<float> v) { int i; std::memcpy(&i, &v, sizeof i); return i; }
inline Number<float> of_bits(int i) { float v; std::memcpy(&v, &i, sizeof v); return v; }
#endif
#if VARIANT == 0
typedef double wide;
#else
typedef real wide;
#endif
inline real max(real a, real b) { return a < b ? b : a; }
typedef Number<real> F;
typedef Number<wide> FW;
typedef uint UINT;
typedef uchar BYTES;
#define TO_F(v) F(v)
inline I whole_of(F v) { return static_cast<I>(v.v); }
#define TO_I(v) whole_of(v)
#define AS_F(v) of_bits(v)
#define AS_I(v) bits_of(v)
#define TO_BYTES(v) ((uchar)(v))
#define WIDEN(v) FW(v)
#define NARROW(v) F(v)
#define PACKET_WIDTH 1
#define PACKET_HEIGHT 1
#define LOAD_WIDE(p) (*(p))
#define LOAD(p) (*(p))
template <class V, class T>
void store(V v, T* p) { *p = static_cast<T>(v); }
template <class V, class T>
void store(Number<V> v, T* p) { *p = static_cast<T>(v.v); }
#define STORE(v, p) store(v, p)

#define PARAMETERS
#define PARAMETERS_PASS
#define ARGUMENTS
#define ARGUMENTS_PASS
#define REGION_PARAMETERS
#define REGION_PASS
#define REGION_OUT
#define REGION_VARIABLES const I outside = NONE, inside = ALL;

// ---- what samples are made of

inline exact of(F v) { return v.v; }
#if VARIANT == 0
inline exact of(FW v) { return v.v; }
#endif
// A random real near v: v rounded.
inline real rounded(double v) { return static_cast<real>(v); }
