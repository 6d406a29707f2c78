// Constants: evaluated at growing precision until the two doubles around them are known, or the one that they seem to be.
#include "numerics/constant.h"

#include <cmath>
#include <unordered_map>

#include "error.h"
#include "expr/build.h"
#include "expr/print.h"
#include "numerics/mpfr_interval.h"

namespace irt::numerics {

Bounds enclose_constant(const Expr& e) {
  constexpr mpfr_prec_t kFirst = 128, kLast = 16384;
  const std::vector<Expr> order = postorder(e);
  Bounds best{0, 0};
  for (mpfr_prec_t p = kFirst; p <= kLast; p *= 2) {
    std::unordered_map<const Node*, MpfrInterval> values;
    for (const Expr& part : order) {
      if (part.op() == Op::Symbol) throw ExpressionError("'" + part.name() + "' is a symbol, not a constant");
      std::vector<const MpfrInterval*> args;
      for (const Expr& a : part.args()) args.push_back(&values.at(a.key()));
      values.emplace(part.key(), apply(part, args, p));
    }
    const MpfrInterval& v = values.at(e.key());
    if (v.empty) throw ExpressionError(to_string(e) + " has no value");
    best = {mpfr_get_d(v.lo, MPFR_RNDD), mpfr_get_d(v.hi, MPFR_RNDU)};
    if (v.doubtful || !(mpfr_number_p(static_cast<mpfr_srcptr>(v.lo)) && mpfr_number_p(static_cast<mpfr_srcptr>(v.hi)))) continue;
    const double next = std::nextafter(best.lo, HUGE_VAL);
    if (best.lo == best.hi || next == best.hi) return best;
    // A double that no precision tells from the value, as 5 from sqrt(5) sqrt(5), lies between.
    if (p > kFirst && std::nextafter(next, HUGE_VAL) == best.hi) return best;
  }
  if (best.lo == best.hi) return best;
  throw ExpressionError("the constant " + to_string(e) + " is undefined, infinite or at a jump: its value cannot be bounded");
}

}  // namespace irt::numerics
