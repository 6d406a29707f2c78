// What a picture is made of, whichever method finds the surface.
#pragma once

#include <functional>
#include <vector>

#include "render/launch.h"

namespace irt::render {

// One frame as a method finds it, with what the options ask for.
using Finder = std::function<Answer(const View&, const Options&)>;

// Statuses, depths and what else the options ask for, of all pixels or those of a list (row * pitch + column), by the program's
// kernels: in single precision, in double, or in double where single leaves a pixel open. A few open pixels go to the reference.
Answer camera_passes(const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
                     device::Device& device, const std::vector<std::size_t>* pixels = nullptr, std::size_t pitch = 0);

// A frame with normals from neighbours where the options ask for them; the program has the gradient.
Answer shaded(const Finder& find, const program::Program& program, const View& view, const Bounds& bounds, const Options& options,
              device::Device& device);

// A shaded frame, anti-aliased where the options ask for it.
Answer picture(const Finder& find, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds, const Options& options,
               device::Device& device);

// Pixels next to a silhouette: a neighbour, of eight, has another kind of status or lies on another sheet.
std::vector<std::size_t> silhouettes(const Answer& answer, const View& view);

// Replaces colours by means over samples, as the options ask; nothing else changes.
void antialias(Answer& answer, const Finder& find, const program::Program& program, const Formulas& formulas, const View& view, const Bounds& bounds,
               const Options& options, device::Device& device);

}  // namespace irt::render
