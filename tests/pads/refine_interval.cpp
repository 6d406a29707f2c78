// The contract of refine.cl by intervals.
#define IRT_AFFINE 0
#include "refine.h"

#if VARIANT == 0
namespace {
CONTRACT(slopes_by_intervals) { return asks_for_all(rng); }
}  // namespace
#endif
