// Intervals with MPFR ends, rounded outward: what constants, parameters and references are proven with.
//
// Domains follow IEEE 1788: an operation outside its domain is empty, partly outside clipped, and what has no bound
// entire. `doubtful` says that the operation was not proven defined and continuous on all of its arguments.
#pragma once

#include <mpfr.h>

#include <span>
#include <utility>

#include "expr/expr.h"

namespace irt::numerics {

// An MPFR number that owns its memory; what was moved from owns none.
class Real {
 public:
  explicit Real(mpfr_prec_t precision) { mpfr_init2(value_, precision); }
  Real(const Real& other) {
    mpfr_init2(value_, mpfr_get_prec(other.value_));
    mpfr_set(value_, other.value_, MPFR_RNDN);
  }
  Real(Real&& other) noexcept {
    *value_ = *other.value_;
    other.value_->_mpfr_d = nullptr;
  }
  Real& operator=(Real other) noexcept {
    std::swap(*value_, *other.value_);
    return *this;
  }
  ~Real() {
    if (value_->_mpfr_d) mpfr_clear(value_);
  }
  operator mpfr_ptr() { return value_; }
  operator mpfr_srcptr() const { return value_; }

 private:
  mpfr_t value_;
};

struct MpfrInterval {
  Real lo, hi;
  bool empty = false;     // defined nowhere
  bool doubtful = false;  // not proven defined and continuous everywhere

  explicit MpfrInterval(mpfr_prec_t precision) : lo(precision), hi(precision) {}
  static MpfrInterval of(const mpq_class& q, mpfr_prec_t precision);
  static MpfrInterval of(double lo, double hi, mpfr_prec_t precision);
  mpfr_prec_t precision() const { return mpfr_get_prec(static_cast<mpfr_srcptr>(lo)); }
};

// The operator over intervals. Conditions are intervals too: 0 for false, 1 for true, [0, 1] for either.
MpfrInterval apply(const Expr& e, std::span<const MpfrInterval* const> args, mpfr_prec_t precision);

}  // namespace irt::numerics
