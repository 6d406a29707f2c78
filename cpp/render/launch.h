// What render, trace and enclose share: choice of the kernel, parameters and settings as buffers, and the launch.
#pragma once

#include <memory>
#include <vector>

#include "kernel/assemble.h"
#include "render/call.h"
#include "render/reals.h"

namespace irt::render {

// Packets of doubles are half as wide: the same bytes.
int packet_width(const device::Device& device, program::Precision precision);

// Whether rays are set up in double for a kernel of single precision.
bool splits(const device::Device& device, const Options& options, program::Precision precision);

// The part of the bounds that may hold zeros of f, for Options::by_enclosures(): what the host finds empty once, each ray would have to march through.
Bounds narrowed(const Bounds& bounds, const Formulas& formulas, const Options& options);

// How large coordinates of pieces get: brackets may reach a little out of the bounds.
glm::dvec3 brackets_reach(const Bounds& bounds);

// Whether values may overflow for coordinates and parameters of these sizes.
bool needs_infinities(const program::Program& program, const glm::dvec3& coordinates, const Options& options,
                      program::Precision precision);

// Lower and upper ends of each parameter, rounded outward.
Reals parameter_ends(const program::Program& program, const Options& options, program::Precision precision);

// The settings of kernels/scene.cl; near is that of a camera.
Reals scene_settings(const Bounds& bounds, const Options& options, program::Precision precision, double position_pad,
                     double near, bool boxed = true);

// The distance from the middle of the bounds to its corners, and a little more.
double reach(const Bounds& bounds);

// The part of a specification that the options decide.
kernel::Spec with_options(kernel::Spec spec, const Options& options);

// What a kernel is made of that marches along rays: of a camera, of pixels or of a list.
kernel::Spec spec_of(const program::Program& program, const Bounds& bounds, const Options& options, const device::Device& device,
                     program::Precision precision, kernel::Entry entry);

// A colour in linear light, and its alpha, as sRGB bytes.
std::uint32_t pixel_of(const std::array<double, 4>& color);

// Begins to build a kernel that a later call may need. Whether it is there already.
bool prepare(const program::Program& program, const kernel::Spec& spec, device::Device& device);

// One launch of a kernel that writes into `answer`; `inputs` are the arguments that make the rays, `more` those after the results.
void launch(const program::Program& program, const kernel::Spec& spec, std::vector<device::Arg> inputs, const Reals& settings,
            std::vector<device::Arg> more, const Options& options, device::Device& device, Answer& answer);

// The same for a kernel whose source does not come from a program.
void launch(const std::string& source, const kernel::Spec& spec, std::vector<device::Arg> inputs, const Reals& settings,
            std::vector<device::Arg> more, const Options& options, device::Device& device, Answer& answer);

// The same by contraction.
Options contracting(Options options);

// Rows of `answer` that hold `columns` results each.
Answer make_answer(std::size_t columns, std::size_t rows, int width, program::Precision precision, const Options& options);
// Memory for normals and colours, where they are asked for.
void add_shading(Answer& answer, const Options& options);

// Fills in Answer::tally.
void tally(Answer& answer, const Options& options);

// Pixels or rays that single precision left open, or whose bracket is wider than eps.
std::vector<std::size_t> undecided(Answer& answer, const Options& options);

// Puts the results of `part`, in order, at the indices given. Returns those that are still undecided.
std::vector<std::size_t> scatter(Answer& answer, Answer part, const std::vector<std::size_t>& where, const Options& options);

}  // namespace irt::render
