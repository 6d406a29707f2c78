// Clip formulas for methods whose root finder does not ask them: zeros found elsewhere are judged, and looked for again where they do not count.
#pragma once

#include "render/launch.h"

namespace irt::render {

// `answer` was found without the clip formula formulas.g, which `program` has. Misses stay, and hits where g is proven at most zero on all
// of the bracket; the other pixels, or rays, are found again by contraction.
void apply_clip(Answer& answer, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options, device::Device& device);
void apply_clip(Answer& answer, const program::Program& program, const Formulas& formulas, const Rays& rays, const Bounds& bounds, const Options& options, device::Device& device);

}  // namespace irt::render
