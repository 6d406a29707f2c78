// Puts a kernel together.
#include "kernel/assemble.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "error.h"
#include "kernel/library.h"
#include "numerics/recent.h"
#include "program/text.h"
#include "caps.h"

namespace irt::kernel {
namespace {

using program::Precision;

// What packets, precision and outputs need.
std::string prelude(const Spec& spec) {
  const bool wide = spec.precision == Precision::Double;
  const std::string real = wide ? "double" : "float", integer = wide ? "long" : "int";
  const std::string w = spec.width == 1 ? "" : std::to_string(spec.width);
  std::string text = fmt::format("#pragma OPENCL FP_CONTRACT OFF\n#define W {}\n", spec.width);
  const auto define = [&](const char* name, int value) { text += fmt::format("#define {} {}\n", name, value); };
  define("IRT_DOUBLE", wide);
  define("IRT_OUTWARD", spec.outward);
  define("IRT_INFINITE", spec.infinite);
  define("IRT_ALONG", spec.along);
  if (spec.entry != Entry::Enclose) {
    define("IRT_LIST", spec.entry == Entry::PixelList);
    define("IRT_SPHERES", spec.spheres);
    define("IRT_HALF_SPACES", spec.half_spaces);
    define("IRT_NORMAL", spec.normal);
    define("IRT_RGB", spec.rgb);
    define("IRT_PIECES", spec.pieces);
    define("IRT_SPLIT", spec.split);
    define("IRT_FINE", spec.wide_results);
    define("IRT_REFINES", spec.refines);
    define("IRT_BEAMS", spec.beams);
    define("IRT_SHARPENS", spec.sharpens);
    const Shape shape = shape_of(spec);
    define("PACKET_WIDTH", shape.width);
    define("PACKET_HEIGHT", shape.height);
    if (spec.beams) {
      const Tiling tiling(spec.width);
      define("BEAM", kBeam);
      define("BEAMS_ACROSS", tiling.beams_across);
      define("BEAMS_DOWN", tiling.beams_down);
    }
  }
  text += fmt::format("typedef {} real;\ntypedef {}{} F;\ntypedef {}{} I;\ntypedef uint{} UINT;\n", real, real, w, integer, w, w);
  text += fmt::format("#define TO_F(v) convert_{0}{1}(v)\n#define TO_I(v) convert_{2}{1}(v)\n#define AS_F(v) as_{0}{1}(v)\n"
                      "#define AS_I(v) as_{2}{1}(v)\n#define TO_UINT(v) convert_uint{1}(v)\n", real, w, integer);
  text += fmt::format("typedef uchar{0} BYTES;\ntypedef float{0} FLOATS;\n#define TO_BYTES(v) convert_uchar{0}(v)\n#define TO_FLOATS(v) convert_float{0}(v)\n", w);
  if (spec.entry != Entry::Enclose) {
    // Rays are set up in `wide` reals.
    const std::string setup = spec.split ? "double" : real;
    text += fmt::format("typedef {0} wide;\ntypedef {0}{1} FW;\n#define TO_LONG(m) convert_long{1}(m)\n#define WIDEN(v) {2}\n#define NARROW(v) {3}\n#define LOAD_WIDE(p) {4}\n#define FINE(v) v\n",
                        setup, w, spec.split ? fmt::format("convert_double{}(v)", w) : "(v)",
                        spec.split ? fmt::format("convert_float{}(v)", w) : "(v)", spec.width == 1 ? "(*(p))" : fmt::format("vload{}(0, p)", w));
  }
  if (spec.width == 1) {
    text += "#define LOAD(p) (*(p))\n#define STORE(v, p) (*(p) = (v))\n";
  } else {
    text += fmt::format("#define LOAD(p) vload{0}(0, p)\n#define STORE(v, p) vstore{0}(v, 0, p)\n", spec.width);
  }
  return text;
}

// What the formula's parameters need.
std::string parameters_of(const program::Program& program, const Spec& spec) {
  std::string text = fmt::format("#define IRT_AFFINE {}\n#define IRT_PARTIAL {}\n#define IRT_GRADIENT_FOUND 0\n", spec.affine ? 1 : 0,
                                 program[program.result].partial ? 1 : 0);
  text += program.inputs() > 0 ? "#define PARAMETERS , __global const real* p\n#define PARAMETERS_PASS , p\n"
                               : "#define PARAMETERS\n#define PARAMETERS_PASS\n";
  text += "#define ARGUMENTS PARAMETERS\n#define ARGUMENTS_PASS PARAMETERS_PASS\n";
  text += spec.beams ? "#define FINDER , HEAD* head, const int beam PARAMETERS\n#define FINDER_PASS , &head, beam PARAMETERS_PASS\n"
                     : "#define FINDER PARAMETERS\n#define FINDER_PASS PARAMETERS_PASS\n";
  text += fmt::format("#define IRT_CLIP {}\n", program.clip >= 0 ? 1 : 0);
  // What clip and numerator tell of a piece of ray; without them everything is inside.
  text += program.has_region() ? "#define REGION_PARAMETERS , I* outside, I* inside\n#define REGION_PASS , outside, inside\n"
                              "#define REGION_OUT , &outside, &inside\n#define REGION_VARIABLES I outside, inside;\n"
                            : "#define REGION_PARAMETERS\n#define REGION_PASS\n#define REGION_OUT\n"
                              "#define REGION_VARIABLES const I outside = NONE, inside = ALL;\n";
  // Numbered, not named: a formula whose parameters have other names is the same kernel.
  for (std::size_t i = 0; i < program.parameters.size(); ++i)
    text += fmt::format("// p[{}], p[{}]: bounds of parameter {} in the order of names\n", 2 * i, 2 * i + 1, i);
  if (program.isovalue) text += fmt::format("// p[{}], p[{}]: bounds of the isovalue\n", 2 * program.parameters.size(), 2 * program.parameters.size() + 1);
  return text;
}

// Library files in the order in which they build on one another.
constexpr const char* kArithmetic[] = {"interval.cl", "interval_divide.cl", "interval_exponential.cl", "interval_power.cl",
                                       "interval_trigonometric.cl", "interval_step.cl", "interval_modulo.cl",
                                       "interval_choice.cl", "polynomial.cl", "affine.cl", "affine_power.cl",
                                       "affine_polynomial.cl", "affine_smooth.cl", "affine_divide.cl", "affine_exponential.cl",
                                       "affine_real_power.cl", "affine_trigonometric.cl", "affine_choice.cl", "affine_modulo.cl",
                                       "affine_select.cl"};

std::string included(const std::string& name) { return fmt::format("\n// ---- {}\n", name) + library_file(name); }

// Whether a definition that pads has this name: one of these, alone or before an underscore.
bool pads(std::string_view name) {
  static constexpr std::string_view kNames[] = {"IA", "RA", "ia", "ra", "irt", "FORM", "LOWER", "UPPER"};
  const std::string_view first = name.substr(0, name.find('_'));
  return std::find(std::begin(kNames), std::end(kNames), first) != std::end(kNames) && name.size() != first.size() + 1;
}

// The same definitions once more without pads, under names that begin with bare_.
std::string without_pads(std::string_view text) {
  std::string out = "\n// ---- the same without pads\n#undef IRT_OUTWARD\n#define IRT_OUTWARD 0\n#define bare_LOWER(v, k) (v)\n#define bare_UPPER(v, k) (v)\n";
  out += program::renamed(text, [](std::string& to, std::string_view name) {
    if (pads(name)) to += "bare_";
    to += name;
  });
  return out + "#undef IRT_OUTWARD\n#define IRT_OUTWARD 1\n";
}

// The formula as an enclosure, with the arithmetic that it needs; and its derivative along the ray.
std::string enclosures(const program::Program& program, const Spec& spec) {
  const auto emit = [&](const program::Program& p) {
    return spec.affine ? program::emit_affine(p, spec.precision, spec.infinite) : program::emit_interval(p, spec.precision);
  };
  program::Emitted f = emit(program);
  const std::string formula = f.source;
  if (spec.along || spec.refines) {
    program::Emitted d = emit(program::along(program).value());
    f.files.merge(d.files);
    f.functions.merge(d.functions);
    f.source += d.source;
  }
  if (spec.refines) f.source += program::emit_fine(program);
  // Files that others build on.
  if (f.files.count("affine_trigonometric.cl")) f.files.insert({"affine_divide.cl", "interval_trigonometric.cl"});
  if (f.files.count("affine_real_power.cl")) f.files.insert({"affine_exponential.cl", "interval_power.cl"});
  if (f.files.count("affine_divide.cl")) f.files.insert("interval_divide.cl");
  for (const char* name : {"affine_divide.cl", "affine_exponential.cl", "affine_real_power.cl", "affine_trigonometric.cl", "affine_choice.cl", "affine_modulo.cl", "affine_select.cl"})
    if (f.files.count(name)) f.files.insert("affine_smooth.cl");
  if (f.files.count("interval_power.cl")) f.files.insert("interval_exponential.cl");
  if (f.files.count("interval_modulo.cl")) f.files.insert({"interval_divide.cl", "interval_step.cl"});
  std::string text;
  for (const char* name : kArithmetic)
    if (f.files.count(name)) text += included(name);
  const program::Result result = spec.affine ? f.result : program::Result::range;
  const char* type = result == program::Result::form ? "RA" : result == program::Result::range ? "IA" : "struct {\n  F x, y, z, lo, hi;\n}";
  text += fmt::format("\n// ---- the formula\ntypedef {} FORM;\n#define FORM_IS_RANGE {}\n#define FORM_HAS_RANGE {}\n", type,
                      result == program::Result::range ? 1 : 0, result == program::Result::form ? 0 : 1);
  for (const std::string& function : f.functions) text += function;
  const std::string slack = spec.slack ? program::emit_slack(program, spec.precision, spec.affine) : "";
  text += fmt::format("#define IRT_SLACK {}\n", slack.empty() ? 0 : 1) + f.source;
  if (slack.empty()) return text;
  std::string bare;
  for (const char* name : {"interval.cl", "affine.cl"})  // the operators that have a slack are there
    if (f.files.count(name)) bare += library_file(name);
  return text + slack + without_pads(bare + fmt::format("typedef {} FORM;\n", type) + formula);
}

std::string values(const program::Program& program, const Spec& spec) { return "\n" + program::emit_value(program, spec.precision).source; }
std::string coefficients(const program::Program& program, const Spec& spec) { return "\n" + program::emit_coefficients(program, spec.precision).source; }
std::string slopes(const program::Program& program, const Spec& spec) {
  return values(program, spec) + "\n" + program::emit_slope(program, spec.precision).source;
}

// What root finders may read of f along the ray: a method names it (Spec::reads), and its kernel has that and nothing else. The
// functions of the formula, and the files that evaluate them along a path.
struct Reader {
  std::string_view name;
  std::string (*formula)(const program::Program&, const Spec&);
  std::vector<std::string> (*files)(const Spec&);
  bool gradient = false;  // irt_gradient, too
};

const Reader kReaders[] = {
    {"enclosures", enclosures, [](const Spec& s) -> std::vector<std::string> {
       std::vector<std::string> files{"path.cl", "candidate.cl", "form.cl", s.affine ? "enclosure_affine.cl" : "enclosure_interval.cl"};
       if (s.along) files.push_back("isolate.cl");
       return files;
     }},
    {"values", values, [](const Spec&) -> std::vector<std::string> { return {"path.cl", "values.cl"}; }},
    {"slopes", slopes, [](const Spec&) -> std::vector<std::string> { return {"path.cl", "values.cl", "slopes.cl"}; }},
    {"coefficients", coefficients, [](const Spec&) -> std::vector<std::string> { return {"closed_form.cl"}; }},
    {"gradients", slopes, [](const Spec&) -> std::vector<std::string> { return {"path.cl", "values.cl", "slopes.cl", "gradients.cl"}; }, true},
};

const Reader& reader_of(const Spec& spec) {
  for (const Reader& r : kReaders)
    if (r.name == spec.reads) return r;
  throw Error(fmt::format("{}.cl reads '{}', which kernels do not know", spec.finder, spec.reads));
}

// How much longer than the last piece of a beam the first one of its rays is: longer, because surfaces seldom cross a beam at a right angle; less so
// where f has high powers, which bend so much over such pieces that affine forms tell nothing.
double lead(const program::Program& program) {
  double highest = 1;
  for (const program::Instruction& in : program.code)
    if (in.code == program::Code::Power) highest = std::max(highest, static_cast<double>(in.index));
  return std::clamp(16 / highest, 1.0 / 3, 4.0);
}

}  // namespace

Shape shape_of(const Spec& spec) {
  // Second passes read whole packets; cells of the frustum form are contracted with one row.
  if (spec.entry != Entry::Camera || spec.sharpens || spec.degree > 0) return {spec.width, 1};
  return {std::min(spec.width, kBeam), std::max(spec.width / kBeam, 1)};
}

const char* entry_name(Entry entry) {
  return entry == Entry::Enclose ? "enclose_pieces" : entry == Entry::Neighbours ? "shade_neighbours" : "trace";
}

std::string assemble(const program::Program& program, const Spec& spec) {
  std::string text = prelude(spec) + parameters_of(program, spec);
  if (spec.beams) text += fmt::format("#define IRT_LEAD R({:.3f})\n", lead(program));
  const auto include = [&](const std::string& name) { text += included(name); };
  const auto gradient = [&](bool wanted) {
    if (wanted) text += "\n" + program::emit_gradient(program, spec.precision).source;
  };
  include("packet.cl");
  if (spec.entry == Entry::Enclose) {
    text += enclosures(program, spec);
    if (spec.slack) include("form.cl");
    include("enclose.cl");
  } else if (spec.entry == Entry::Neighbours) {  // shading needs nothing but the gradient
    gradient(spec.normal || spec.rgb);
    for (const char* name : {"scene.cl", "ray_camera.cl", "normal.cl", "shade.cl"}) include(name);
    text += fmt::format("#define JUMP R({}.0)\n", kJump);
    include("neighbours.cl");
  } else {
    const Reader& reader = reader_of(spec);
    text += reader.formula(program, spec);
    gradient(spec.normal || spec.rgb || reader.gradient);
    include("scene.cl");
    include(spec.entry == Entry::RayList ? "ray_list.cl" : "ray_camera.cl");
    include("clip.cl");
    for (const std::string& name : reader.files(spec)) include(name);
    for (const std::string& macro : spec.defines) text += fmt::format("#define {}\n", macro);
    include(spec.finder + ".cl");
    if (spec.normal || spec.rgb) include("normal.cl");
    if (spec.rgb) include("shade.cl");
    if (spec.refines) include("refine.cl");
    include("results.cl");
    include(spec.beams ? "beams.cl" : spec.sharpens ? "sharpen.cl" : "trace.cl");
  }
  if (text.size() > limits::kSourceBytes)
    throw LimitError(fmt::format("the kernel's source has {} bytes; the limit is {}; shorten the formula", text.size(),
                                 limits::kSourceBytes));
  return text;
}

namespace {

std::string joined(std::string text, std::initializer_list<const char*> files) {
  for (const char* name : files) text += included(name);
  return text;
}

// The entry point, and the files that it calls.
std::string with_shading(std::string text, const Spec& spec) {
  if (spec.normal || spec.rgb) text = joined(text, {"normal.cl"});
  if (spec.rgb) text = joined(text, {"shade.cl"});
  return joined(text + "#define PARAMETERS\n#define PARAMETERS_PASS\n", {"results.cl", "trace.cl"});
}

}  // namespace

namespace {

// How often each coefficient of Bernstein's basis counts; exact in double up to limits::kFrustumDegree.
std::string binomials(const char* type, const char* name, int degree, bool wide) {
  std::string text = fmt::format("__constant {} {}[] = {{", type, name);
  double value = 1;
  for (int i = 0; i <= degree; ++i) {
    text += fmt::format("{:.1f}{}, ", value, wide ? "" : "f");
    value = std::round(value * (degree - i) / (i + 1));
  }
  return text + "};\n";
}

// kernels/frustum_contract.cl for one type.
std::string contraction(const char* scalar, const char* lanes, const char* terms, const char* prefix) {
  return fmt::format("\n#define SCALAR {}\n#define LANES {}\n#define TERMS {}\n#define CONTRACTION(with) {}##with\n", scalar, lanes, terms, prefix) +
         included("frustum_contract.cl");
}

// Cells of the frustum form, or coefficients ray by ray.
std::string cells(const Spec& spec) {
  if (spec.entry == Entry::RayList) return included("frustum_rays.cl");
  std::string text = contraction("real", "F", "N", "contract_");
  if (spec.fine_terms)
    text += fmt::format("\n#define FINE_TERMS {}\n", spec.fine_terms) + binomials("double", "fine_binomials", spec.fine_terms - 1, true) +
            contraction("wide", "FW", "FINE_TERMS", "contract_fine_") + included("frustum_fine.cl");
  return text + included("frustum_cells.cl");
}

std::string frustum_source(const Spec& spec) {
  const bool gradient = spec.normal || spec.rgb, rays = spec.entry == Entry::RayList;
  const std::string file = spec.finder + ".cl";
  std::string text = prelude(spec) +
      fmt::format("#define IRT_DEGREE {}\n#define IRT_MOST_TERMS {}\n#define IRT_TILE {}\n#define IRT_GRADIENT_FOUND {}\n#define IRT_PREVIOUS {}\n", spec.degree, limits::kFrustumDegree + 1, spec.tile, gradient ? 1 : 0,
                  spec.previous ? 1 : 0) +
      binomials("real", "binomials", spec.degree, spec.precision == Precision::Double) +
      (rays ? std::string("#define FORM_ARGUMENTS __global const real *rays_form, const int stride, const real reach_s\n"
                          "#define ARGUMENTS_PASS , rays_form, stride, reach_s\n")
            : fmt::format("#define FORM_ARGUMENTS __global const int *tiles, __global const int *shapes, __global const real *slabs, __global const real *form, "
                          "__global const real *basis, const int terms, const int tile_x0, const int tile_y0, const int tile_columns, const int tile_rows{}{}\n"
                          "#define ARGUMENTS_PASS , tiles, shapes, slabs, form, basis, terms, tile_x0, tile_y0, tile_columns, tile_rows{}{}\n",
                          spec.fine_terms ? ", __global const wide *fine_form, __global const wide *fine_basis" : "", spec.previous ? ", __global const float *previous, const int previous_pitch" : "",
                          spec.fine_terms ? ", fine_form, fine_basis" : "", spec.previous ? ", previous, previous_pitch" : "")) +
      // A list holds whole packets of a frame.
      fmt::format("#define FINDER_PASS , {} ARGUMENTS_PASS\n",
                  spec.entry == Entry::PixelList ? "list[2 * W * column] / W, list[2 * W * column + 1]" : "column, row") +
      "#define ARGUMENTS , FORM_ARGUMENTS\n#define FINDER , const size_t packet, const size_t pixel_row, FORM_ARGUMENTS\n";
  text = joined(text, {"packet.cl", "scene.cl", rays ? "ray_list.cl" : "ray_camera.cl", "clip.cl", "frustum_form.cl"}) + cells(spec);
  if (spec.finder != "frustum_newton") text = joined(text, {spec.finder.starts_with("frustum_mr") ? "frustum_knots.cl" : "frustum_pieces.cl"});
  return with_shading(joined(text, {file.c_str()}), spec);
}

}  // namespace

std::string assemble_frustum(const Spec& spec) {
  static auto* const recent = new numerics::Recent<Spec, std::string>;  // each frame asks for two or three
  return *recent->get(spec, [&] { return std::make_shared<const std::string>(frustum_source(spec)); });
}

}  // namespace irt::kernel
