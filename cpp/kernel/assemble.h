// Kernel assembly: prelude for a packet width and precision, the library files that the scene needs, the functions
// emitted from its program, and one entry point. A kernel contains nothing else.
#pragma once

#include <string>
#include <vector>

#include "program/emit.h"

namespace irt::kernel {

enum class Entry { Camera, PixelList, RayList, Enclose, Neighbours };

// How many pixel widths nearer or farther a neighbour lies on another sheet of the surface: behind or before a silhouette.
inline constexpr int kJump = 4;

// Beams (kernels/beams.cl): one bounds the rays of kBeam x kBeam pixels; a work-item has a packet of beams, a tile of the picture.
inline constexpr int kBeam = 4;

// How many pixels across and down a packet of rays has (kernels/packet.cl).
struct Shape {
  int width, height;

  constexpr int lanes() const { return width * height; }
};

// How the beams of one packet, of `lanes`, lie in a tile.
struct Tiling {
  int beams_across, beams_down;

  explicit constexpr Tiling(int lanes) : beams_across(lanes < kBeam ? 1 : lanes / kBeam), beams_down(lanes / beams_across) {}
  constexpr int across() const { return beams_across * kBeam; }  // pixels
  constexpr int down() const { return beams_down * kBeam; }
};

struct Spec {
  Entry entry = Entry::Camera;
  bool affine = false;
  std::string finder = "bisection";  // kernels/<finder>.cl
  std::string reads = "enclosures";  // what it reads of f along the ray (assemble.cpp, kReaders)
  std::vector<std::string> defines;  // macros that its file tests
  program::Precision precision = program::Precision::Single;
  int width = 16;        // reals per packet
  bool outward = true;   // rounding="outward"
  bool split = false;    // rays are set up in double and carried as pairs of floats; needs fp64
  bool infinite = true;  // intermediate values may be infinite (program::magnitude)
  int spheres = 0;       // balls among the bounds
  int half_spaces = 0;   // and half-spaces
  bool normal = false;
  bool rgb = false;
  bool pieces = false;   // counted, ray by ray
  bool beams = false;    // the camera's rays start where beams end; needs kernels/contract.cl
  bool wide_results = false;  // depths and uncertainties are doubles, though packets are floats; needs split
  bool refines = false;       // brackets of floats are narrowed down by values in double (kernels/refine.cl); needs wide_results, program::emit_fine
  bool sharpens = false; // rays are the brackets that such a kernel has found (kernels/sharpen.cl)
  bool along = false;    // with the derivative along the ray (program::along), by which roots are isolated
  bool slack = false;    // with arithmetic without pads and a bound of its rounding, where there is one (program::emit_slack)
  // Frustum forms (assemble_frustum): degree, and pixels along the side of a tile.
  int degree = 0, tile = 0;
  int fine_terms = 0;     // where roots are refined in double: coefficients along the depth of the cells for that (kernels/frustum_fine.cl); needs split
  bool previous = false;  // with the depths of the frame before

  friend bool operator==(const Spec&, const Spec&) = default;
};

// Where the files of kernels/ lie. Set once, before the first kernel.
void set_directory(const std::string& path);

// The OpenCL C of a call. Throws LimitError past limits::kSourceBytes.
std::string assemble(const program::Program& program, const Spec& spec);

// The same for polynomials by their frustum form: it depends on the degree, never on the polynomial.
std::string assemble_frustum(const Spec& spec);

Shape shape_of(const Spec& spec);

// The name of the entry point in it.
const char* entry_name(Entry entry);

}  // namespace irt::kernel
