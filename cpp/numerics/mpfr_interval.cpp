// Every operator over MPFR intervals: monotone pieces are evaluated at their ends with directed rounding.
#include "numerics/mpfr_interval.h"

#include <algorithm>
#include <cmath>

#include "error.h"

namespace irt::numerics {
namespace {

using Interval = MpfrInterval;
using Function = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
using Binary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

Interval entire(mpfr_prec_t p) {
  Interval r(p);
  mpfr_set_inf(r.lo, -1);
  mpfr_set_inf(r.hi, 1);
  return r;
}

Interval nothing(mpfr_prec_t p) {
  Interval r(p);
  r.empty = r.doubtful = true;
  return r;
}

Interval ends(double lo, double hi, mpfr_prec_t p) {
  Interval r(p);
  mpfr_set_d(r.lo, lo, MPFR_RNDD);
  mpfr_set_d(r.hi, hi, MPFR_RNDU);
  return r;
}

bool holds_zero(const Interval& a) { return mpfr_sgn((mpfr_srcptr)a.lo) <= 0 && mpfr_sgn((mpfr_srcptr)a.hi) >= 0; }

bool is_point(const Interval& a) { return mpfr_equal_p(a.lo, a.hi); }

// A value rounded down and up by one evaluation: MPFR rounds correctly, so up is the next number, unless down was exact.
template <class F>
Interval around(F f, mpfr_prec_t p) {
  Interval r(p);
  const bool exact = f(r.lo) == 0;
  mpfr_set(r.hi, r.lo, MPFR_RNDU);
  if (!exact) mpfr_nextabove(r.hi);
  return r;
}

Interval around(const Interval& point, Function f) {
  return around([&](mpfr_ptr r) { return f(r, point.lo, MPFR_RNDD); }, point.precision());
}

Interval rising(const Interval& a, Function f) {
  if (is_point(a)) return around(a, f);
  Interval r(a.precision());
  f(r.lo, a.lo, MPFR_RNDD);
  f(r.hi, a.hi, MPFR_RNDU);
  return r;
}

Interval falling(const Interval& a, Function f) {
  if (is_point(a)) return around(a, f);
  Interval r(a.precision());
  f(r.lo, a.hi, MPFR_RNDD);
  f(r.hi, a.lo, MPFR_RNDU);
  return r;
}

// a cut to [lo, hi] first; empty where nothing is left.
Interval cut(const Interval& a, double lo, double hi, bool& outside) {
  Interval r = a;
  outside = mpfr_cmp_d(a.lo, lo) < 0 || mpfr_cmp_d(a.hi, hi) > 0;
  if (mpfr_cmp_d(a.hi, lo) < 0 || mpfr_cmp_d(a.lo, hi) > 0) return nothing(a.precision());
  if (mpfr_cmp_d(r.lo, lo) < 0) mpfr_set_d(r.lo, lo, MPFR_RNDN);
  if (mpfr_cmp_d(r.hi, hi) > 0) mpfr_set_d(r.hi, hi, MPFR_RNDN);
  return r;
}

// The extremes of a function of two variables over its four corners; a nan corner (0 * inf) counts as zero.
Interval corners(const Interval& a, const Interval& b, Binary f) {
  const mpfr_prec_t p = a.precision();
  Interval r(p);
  if (is_point(a) && is_point(b)) {
    r = around([&](mpfr_ptr v) { return f(v, a.lo, b.lo, MPFR_RNDD); }, p);
    return mpfr_nan_p((mpfr_srcptr)r.lo) ? ends(0, 0, p) : r;
  }
  Real v(p);
  bool first = true;
  for (mpfr_srcptr x : {(mpfr_srcptr)a.lo, (mpfr_srcptr)a.hi})
    for (mpfr_srcptr y : {(mpfr_srcptr)b.lo, (mpfr_srcptr)b.hi}) {
      f(v, x, y, MPFR_RNDD);
      if (mpfr_nan_p((mpfr_srcptr)v)) mpfr_set_zero(v, 1);
      if (first || mpfr_cmp(v, r.lo) < 0) mpfr_set(r.lo, v, MPFR_RNDD);
      f(v, x, y, MPFR_RNDU);
      if (mpfr_nan_p((mpfr_srcptr)v)) mpfr_set_zero(v, 1);
      if (first || mpfr_cmp(v, r.hi) > 0) mpfr_set(r.hi, v, MPFR_RNDU);
      first = false;
    }
  return r;
}

Interval add(const Interval& a, const Interval& b) {
  Interval r(a.precision());
  mpfr_add(r.lo, a.lo, b.lo, MPFR_RNDD);
  mpfr_add(r.hi, a.hi, b.hi, MPFR_RNDU);
  return r;
}

Interval negate(const Interval& a) {
  Interval r(a.precision());
  mpfr_neg(r.lo, a.hi, MPFR_RNDD);
  mpfr_neg(r.hi, a.lo, MPFR_RNDU);
  return r;
}

Interval multiply(const Interval& a, const Interval& b) { return corners(a, b, mpfr_mul); }

Interval magnitude(const Interval& a) {
  if (mpfr_sgn((mpfr_srcptr)a.lo) >= 0) return a;
  if (mpfr_sgn((mpfr_srcptr)a.hi) <= 0) return negate(a);
  Interval r(a.precision());
  mpfr_set_zero(r.lo, 1);
  mpfr_neg(r.hi, a.lo, MPFR_RNDU);
  mpfr_max(r.hi, r.hi, a.hi, MPFR_RNDU);
  return r;
}

Interval reciprocal(const Interval& a) {
  const mpfr_prec_t p = a.precision();
  if (mpfr_zero_p((mpfr_srcptr)a.lo) && mpfr_zero_p((mpfr_srcptr)a.hi)) return nothing(p);
  if (!holds_zero(a)) {
    Interval r(p);
    mpfr_ui_div(r.lo, 1, a.hi, MPFR_RNDD);
    mpfr_ui_div(r.hi, 1, a.lo, MPFR_RNDU);
    return r;
  }
  Interval r = entire(p);
  if (mpfr_zero_p((mpfr_srcptr)a.lo)) mpfr_ui_div(r.lo, 1, a.hi, MPFR_RNDD);
  if (mpfr_zero_p((mpfr_srcptr)a.hi)) mpfr_ui_div(r.hi, 1, a.lo, MPFR_RNDU);
  r.doubtful = true;
  return r;
}

Interval integer_power(const Interval& a, unsigned long n) {
  const Interval base = n % 2 == 0 ? magnitude(a) : a;
  Interval r(a.precision());
  mpfr_pow_ui(r.lo, base.lo, n, MPFR_RNDD);
  mpfr_pow_ui(r.hi, base.hi, n, MPFR_RNDU);
  return r;
}

// The roots of what is not negative.
Interval roots(const Interval& a, unsigned long n, bool& outside) {
  Interval r = cut(a, 0, HUGE_VAL, outside);
  if (r.empty) return r;
  mpfr_rootn_ui(r.lo, r.lo, n, MPFR_RNDD);
  mpfr_rootn_ui(r.hi, r.hi, n, MPFR_RNDU);
  return r;
}

Interval logarithm(const Interval& a) {
  const mpfr_prec_t p = a.precision();
  if (mpfr_sgn((mpfr_srcptr)a.hi) <= 0) return nothing(p);
  Interval r(p);
  if (mpfr_sgn((mpfr_srcptr)a.lo) <= 0) {
    mpfr_set_inf(r.lo, -1);
    r.doubtful = true;
  } else {
    mpfr_log(r.lo, a.lo, MPFR_RNDD);
  }
  mpfr_log(r.hi, a.hi, MPFR_RNDU);
  return r;
}

// x ** y = exp(y log x) for x >= 0; 0 ** y is 0 for y > 0.
Interval real_power(const Interval& a, const Interval& b) {
  const mpfr_prec_t p = a.precision();
  bool outside;
  const Interval x = cut(a, 0, HUGE_VAL, outside);
  if (x.empty) return x;
  const bool below = mpfr_sgn((mpfr_srcptr)b.lo) < 0;
  if (mpfr_zero_p((mpfr_srcptr)x.hi) && mpfr_sgn((mpfr_srcptr)b.hi) <= 0) return nothing(p);
  Interval r = corners(x, b, mpfr_pow);
  if (mpfr_zero_p((mpfr_srcptr)x.lo)) {
    mpfr_set_zero(r.lo, 1);
    if (below) mpfr_set_inf(r.hi, 1);
  }
  // x ** y with 1 inside x and 0 inside y passes through 1.
  if (mpfr_cmp_ui(r.lo, 1) > 0 && holds_zero(b)) mpfr_set_ui(r.lo, 1, MPFR_RNDD);
  if (mpfr_cmp_ui(r.hi, 1) < 0 && holds_zero(b)) mpfr_set_ui(r.hi, 1, MPFR_RNDU);
  r.doubtful = outside || (mpfr_zero_p((mpfr_srcptr)x.lo) && mpfr_sgn((mpfr_srcptr)b.lo) <= 0);
  return r;
}

// The whole numbers k with k <= (x - offset * pi) / (2 pi), bounded on both sides.
struct Turns {
  Real lo, hi;
};

Turns turns(mpfr_srcptr x, double offset, mpfr_prec_t p) {
  const mpfr_prec_t wide = p + 64 + (mpfr_regular_p(x) ? std::max<mpfr_exp_t>(0, mpfr_get_exp(x)) : 0);
  Turns t{Real(wide), Real(wide)};
  Real pi(wide);
  for (mpfr_rnd_t round : {MPFR_RNDD, MPFR_RNDU}) {
    // x / (2 pi) - offset / 2, with pi rounded to widen
    Real& r = round == MPFR_RNDD ? t.lo : t.hi;
    const bool positive = mpfr_sgn(x) > 0;
    mpfr_const_pi(pi, (round == MPFR_RNDD) == positive ? MPFR_RNDU : MPFR_RNDD);
    mpfr_mul_2ui(pi, pi, 1, MPFR_RNDN);
    mpfr_div(r, x, pi, round);
    mpfr_sub_d(r, r, offset / 2, round);
    mpfr_floor(r, r);
  }
  return t;
}

// Whether a point offset * pi + 2 pi k may lie in a.
bool meets(const Interval& a, double offset) {
  if (!mpfr_number_p((mpfr_srcptr)a.lo) || !mpfr_number_p((mpfr_srcptr)a.hi)) return true;
  if (mpfr_zero_p((mpfr_srcptr)a.lo) && mpfr_zero_p((mpfr_srcptr)a.hi)) return offset == 0;
  const Turns low = turns(a.lo, offset, a.precision()), high = turns(a.hi, offset, a.precision());
  return !mpfr_equal_p(low.lo, high.hi);
}

Interval wave(const Interval& a, Function f, double peak, double trough) {
  const mpfr_prec_t p = a.precision();
  if (!mpfr_number_p((mpfr_srcptr)a.lo) || !mpfr_number_p((mpfr_srcptr)a.hi)) return ends(-1, 1, p);
  if (is_point(a)) return around(a, f);
  Interval r(p);
  Real v(p);
  f(r.lo, a.lo, MPFR_RNDD);
  f(v, a.hi, MPFR_RNDD);
  mpfr_min(r.lo, r.lo, v, MPFR_RNDD);
  f(r.hi, a.lo, MPFR_RNDU);
  f(v, a.hi, MPFR_RNDU);
  mpfr_max(r.hi, r.hi, v, MPFR_RNDU);
  if (meets(a, peak)) mpfr_set_ui(r.hi, 1, MPFR_RNDU);
  if (meets(a, trough)) mpfr_set_si(r.lo, -1, MPFR_RNDD);
  return r;
}

Interval tangent(const Interval& a) {
  if (!is_point(a) && (meets(a, 0.5) || meets(a, -0.5))) {
    Interval r = entire(a.precision());
    r.doubtful = true;
    return r;
  }
  return rising(a, mpfr_tan);
}

Interval angle(const Interval& y, const Interval& x) {
  const mpfr_prec_t p = y.precision();
  if (holds_zero(y) && mpfr_sgn((mpfr_srcptr)x.lo) <= 0) {
    const bool point = mpfr_zero_p((mpfr_srcptr)y.lo) && mpfr_zero_p((mpfr_srcptr)y.hi);
    if (point && mpfr_zero_p((mpfr_srcptr)x.lo) && mpfr_zero_p((mpfr_srcptr)x.hi)) return nothing(p);
    Interval r(p);
    mpfr_const_pi(r.hi, MPFR_RNDU);
    mpfr_neg(r.lo, r.hi, MPFR_RNDD);
    if (mpfr_sgn((mpfr_srcptr)y.lo) >= 0) mpfr_set_zero(r.lo, 1);
    if (point && mpfr_sgn((mpfr_srcptr)x.hi) < 0) mpfr_const_pi(r.lo, MPFR_RNDD);
    r.doubtful = true;
    return r;
  }
  return corners(y, x, mpfr_atan2);
}

int mpfr_ceiling(mpfr_ptr r, mpfr_srcptr a, mpfr_rnd_t) { return mpfr_ceil(r, a); }
int mpfr_floored(mpfr_ptr r, mpfr_srcptr a, mpfr_rnd_t) { return mpfr_floor(r, a); }
int mpfr_signum(mpfr_ptr r, mpfr_srcptr a, mpfr_rnd_t) { return mpfr_set_si(r, mpfr_sgn(a), MPFR_RNDN); }

Interval step(const Interval& a, Function f) {
  Interval r(a.precision());
  f(r.lo, a.lo, MPFR_RNDD);
  f(r.hi, a.hi, MPFR_RNDU);
  r.doubtful = !mpfr_equal_p(r.lo, r.hi);
  return r;
}

Interval modulo(const Interval& a, const Interval& b) {
  if (mpfr_zero_p((mpfr_srcptr)b.lo) && mpfr_zero_p((mpfr_srcptr)b.hi)) return nothing(a.precision());
  Interval quotient = multiply(a, reciprocal(b));
  const Interval k = step(quotient, mpfr_floored);
  if (!holds_zero(b) && mpfr_equal_p(k.lo, k.hi)) return add(a, negate(multiply(b, k)));
  Interval r(a.precision());
  mpfr_set_zero(r.lo, 1);
  mpfr_set_zero(r.hi, 1);
  mpfr_min(r.lo, r.lo, b.lo, MPFR_RNDD);
  mpfr_max(r.hi, r.hi, b.hi, MPFR_RNDU);
  r.doubtful = true;
  return r;
}

Interval extreme(const Interval& a, const Interval& b, bool least) {
  Interval r(a.precision());
  (least ? mpfr_min : mpfr_max)(r.lo, a.lo, b.lo, MPFR_RNDD);
  (least ? mpfr_min : mpfr_max)(r.hi, a.hi, b.hi, MPFR_RNDU);
  return r;
}

Interval truth(bool may_be_false, bool may_be_true, mpfr_prec_t p) { return ends(may_be_false ? 0 : 1, may_be_true ? 1 : 0, p); }
bool may_be(const Interval& condition, bool value) { return value ? mpfr_sgn((mpfr_srcptr)condition.hi) > 0 : mpfr_zero_p((mpfr_srcptr)condition.lo); }

Interval compare(Op op, const Interval& a, const Interval& b) {
  const mpfr_prec_t p = a.precision();
  switch (op) {
    case Op::Less: return truth(mpfr_cmp(a.hi, b.lo) >= 0, mpfr_cmp(a.lo, b.hi) < 0, p);
    case Op::LessEqual: return truth(mpfr_cmp(a.hi, b.lo) > 0, mpfr_cmp(a.lo, b.hi) <= 0, p);
    default: {
      const bool apart = mpfr_cmp(a.hi, b.lo) < 0 || mpfr_cmp(b.hi, a.lo) < 0;
      const bool same = mpfr_equal_p(a.lo, b.hi) && mpfr_equal_p(a.hi, b.lo);
      return op == Op::Equal ? truth(!same, !apart, p) : truth(!apart, !same, p);
    }
  }
}

Interval piecewise(std::span<const Interval* const> args, mpfr_prec_t p) {
  Interval r(p);
  bool any = false, doubtful = false;
  for (std::size_t i = 0; i + 1 < args.size(); i += 2) {
    const Interval &value = *args[i], &condition = *args[i + 1];
    if (!may_be(condition, true)) continue;
    doubtful = doubtful || value.doubtful || condition.doubtful;
    if (!value.empty) {
      if (any) {
        mpfr_min(r.lo, r.lo, value.lo, MPFR_RNDD);
        mpfr_max(r.hi, r.hi, value.hi, MPFR_RNDU);
      } else {
        r.lo = value.lo;
        r.hi = value.hi;
      }
      any = true;
    }
    if (!may_be(condition, false)) {
      if (!any) return nothing(p);
      r.doubtful = doubtful;
      return r;
    }
    doubtful = true;  // another branch may hold as well
  }
  if (!any) return nothing(p);
  r.doubtful = true;
  return r;
}

}  // namespace

Interval MpfrInterval::of(const mpq_class& q, mpfr_prec_t precision) {
  Interval r(precision);
  mpfr_set_q(r.lo, q.get_mpq_t(), MPFR_RNDD);
  mpfr_set_q(r.hi, q.get_mpq_t(), MPFR_RNDU);
  return r;
}

Interval MpfrInterval::of(double lo, double hi, mpfr_prec_t precision) { return ends(lo, hi, precision); }

Interval apply(const Expr& e, std::span<const Interval* const> args, mpfr_prec_t p) {
  if (e.op() == Op::Piecewise) return piecewise(args, p);
  bool doubtful = false;
  for (const Interval* a : args) {
    if (a->empty && !e.is_condition()) return nothing(p);
    // A comparison of what has no value decides nothing.
    if (a->empty) {
      Interval r = truth(true, true, p);
      r.doubtful = true;
      return r;
    }
    doubtful = doubtful || a->doubtful;
  }
  const auto a = [&]() -> const Interval& { return *args[0]; };
  const auto b = [&]() -> const Interval& { return *args[1]; };
  const auto fold = [&](auto f) {
    Interval r = a();
    for (std::size_t i = 1; i < args.size(); ++i) r = f(r, *args[i]);
    return r;
  };
  Interval r(p);
  bool outside = false;
  switch (e.op()) {
    case Op::Number: r = Interval::of(e.number(), p); break;
    case Op::Pi:
      mpfr_const_pi(r.lo, MPFR_RNDD);
      mpfr_const_pi(r.hi, MPFR_RNDU);
      break;
    case Op::E: r = rising(ends(1, 1, p), mpfr_exp); break;
    case Op::True: r = ends(1, 1, p); break;
    case Op::False: r = ends(0, 0, p); break;
    case Op::Add: r = fold(add); break;
    case Op::Mul: r = fold(multiply); break;
    case Op::Pow: {
      const Expr& n = e.arg(1);
      if (n.op() == Op::Number && n.number().get_den() < 100 && abs(n.number().get_num()) < 1'000'000'000) {
        const long k = n.number().get_num().get_si();
        const unsigned long root = n.number().get_den().get_ui();
        r = root == 1 ? a() : roots(a(), root, outside);
        if (!r.empty) r = integer_power(r, static_cast<unsigned long>(std::labs(k)));
        if (!r.empty && k < 0) r = reciprocal(r);
      } else {
        r = real_power(a(), b());
      }
      break;
    }
    case Op::Sin: r = wave(a(), mpfr_sin, 0.5, -0.5); break;
    case Op::Cos: r = wave(a(), mpfr_cos, 0, 1); break;
    case Op::Tan: r = tangent(a()); break;
    case Op::Asin:
    case Op::Acos:
      r = cut(a(), -1, 1, outside);
      if (!r.empty) r = e.op() == Op::Asin ? rising(r, mpfr_asin) : falling(r, mpfr_acos);
      break;
    case Op::Atan: r = rising(a(), mpfr_atan); break;
    case Op::Atan2: r = angle(a(), b()); break;
    case Op::Sinh: r = rising(a(), mpfr_sinh); break;
    case Op::Cosh: r = rising(magnitude(a()), mpfr_cosh); break;
    case Op::Tanh: r = rising(a(), mpfr_tanh); break;
    case Op::Exp: r = rising(a(), mpfr_exp); break;
    case Op::Log: r = logarithm(a()); break;
    case Op::Cbrt: r = rising(a(), mpfr_cbrt); break;
    case Op::Abs: r = magnitude(a()); break;
    case Op::Sign: r = step(a(), mpfr_signum); break;
    case Op::Floor: r = step(a(), mpfr_floored); break;
    case Op::Ceiling: r = step(a(), mpfr_ceiling); break;
    case Op::Min: r = fold([](const Interval& s, const Interval& t) { return extreme(s, t, true); }); break;
    case Op::Max: r = fold([](const Interval& s, const Interval& t) { return extreme(s, t, false); }); break;
    case Op::Mod: r = modulo(a(), b()); break;
    case Op::Less:
    case Op::LessEqual:
    case Op::Equal:
    case Op::Unequal: r = compare(e.op(), a(), b()); break;
    case Op::And: r = fold([](const Interval& s, const Interval& t) { return extreme(s, t, true); }); break;
    case Op::Or: r = fold([](const Interval& s, const Interval& t) { return extreme(s, t, false); }); break;
    case Op::Not: r = truth(may_be(a(), true), may_be(a(), false), p); break;
    default: throw ExpressionError("no interval for this operator");
  }
  if (!r.empty && (mpfr_nan_p((mpfr_srcptr)r.lo) || mpfr_nan_p((mpfr_srcptr)r.hi))) {
    r = entire(p);
    r.doubtful = true;
  }
  r.doubtful = r.doubtful || doubtful || outside;
  return r;
}

}  // namespace irt::numerics
