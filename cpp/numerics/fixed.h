// Fixed-point numbers of many bits with an error bound: (value +- error) 2^-kBits.
//
// Ray polynomials live near the unit cube of their bounds, where fixed point loses nothing against floating point, and
// GMP's integers are several times as fast as MPFR's intervals.
#pragma once

#include <gmpxx.h>

#include <cmath>

namespace irt::numerics {

class Fixed {
 public:
  static constexpr mp_bitcnt_t kBits = 640;

  Fixed() = default;
  explicit Fixed(double v) : Fixed(mpq_class(v)) {}
  explicit Fixed(const mpq_class& q) {
    value_ = q.get_num() << kBits;
    mpz_fdiv_q(value_.get_mpz_t(), value_.get_mpz_t(), q.get_den_mpz_t());
    error_ = 1;
  }
  // Between lo and hi.
  Fixed(const mpq_class& lo, const mpq_class& hi) : Fixed(lo) {
    const Fixed top(hi);
    error_ = up(mpz_class(top.value_ - value_).get_d() * (1 + 0x1p-50)) + 2;
  }

  int sign() const { return cmp(abs(value_), error_) > 0 ? sgn(value_) : 0; }
  double middle() const { return std::ldexp(1.0, -512) * (mpz_class(value_ >> (kBits - 512)).get_d()); }

  // The nearest T or its neighbour; T has at most 113 bits.
  template <class T>
  T as() const {
    T sum = 0;
    mpz_class rest = value_;
    for (int k = 0; k < 3; ++k) {
      const double d = rest.get_d();
      if (!std::isfinite(d)) return static_cast<T>(d);
      sum += static_cast<T>(d);
      rest -= mpz_class(d);
    }
    return sum * static_cast<T>(0x1p-320) * static_cast<T>(0x1p-320);
  }

  Fixed operator+(const Fixed& b) const { return Fixed(value_ + b.value_, up(error_ + b.error_)); }
  Fixed operator-(const Fixed& b) const { return Fixed(value_ - b.value_, up(error_ + b.error_)); }
  Fixed operator-() const { return Fixed(-value_, error_); }
  Fixed operator*(const Fixed& b) const {
    const double size_a = std::ldexp(std::fabs(value_.get_d()), -static_cast<int>(kBits)) * (1 + 0x1p-50) + 0x1p-600,
                 size_b = std::ldexp(std::fabs(b.value_.get_d()), -static_cast<int>(kBits)) * (1 + 0x1p-50) + 0x1p-600;
    const double product = std::ldexp(error_, -static_cast<int>(kBits)) * b.error_;
    return Fixed(mpz_class((value_ * b.value_) >> kBits), up(size_a * b.error_ + size_b * error_ + product) + 1);
  }
  Fixed half() const { return Fixed(value_ >> 1, error_ / 2 + 1); }
  Fixed over(unsigned long n) const {
    Fixed r(value_, up(error_ / static_cast<double>(n)) + 1);
    mpz_fdiv_q_ui(r.value_.get_mpz_t(), r.value_.get_mpz_t(), n);
    return r;
  }

 private:
  Fixed(mpz_class value, double error) : value_(std::move(value)), error_(error) {}
  // A few operations' rounding, upward; what left the range of doubles (or is inf * 0) bounds nothing.
  static double up(double v) { return v < 1e300 ? v * (1 + 0x1p-50) : HUGE_VAL; }

  mpz_class value_;
  double error_ = 0;  // in units of the last place
};

}  // namespace irt::numerics
