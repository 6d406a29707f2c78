"""The hard cases of the atlas: formula, view, and why it is hard. What each method makes of them is in expected.json."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import implicitrt as irt


@dataclass(frozen=True)
class Case:
    """A picture on which some method fails, and the reason."""

    name: str
    formula: str  # or the name of a named surface
    why: str
    keywords: dict[str, Any] = field(default_factory=dict)  # bounds, camera

    @property
    def surface(self) -> Any:
        """What to draw."""
        return irt.surfaces.get(self.formula, self.formula)


def _close(*point: float) -> irt.Camera:
    """A view of a point from 1.2 away."""
    away = (0.576, 0.432, 0.96)
    return irt.Camera(tuple(p + a for p, a in zip(point, away, strict=True)), point)  # type: ignore[arg-type]


CASES = {
    c.name: c
    for c in (
        Case("steiner", "steiner", "Sheets cross along the axes, and beyond them bare lines stick out on which f only touches zero."),
        Case("steiner_close", "steiner", "The same from near by: the lines are infinitely thin.", {"bounds": 0.3}),
        Case("crosscap", "crosscap", "A double line that ends in pinch points; no sign changes on the line itself."),
        Case("cushion", "cushion", "It touches itself where slopes are steep: extrapolated signs differ where those of f do not."),
        Case("piriform", "piriform", "A cusp: towards it value and slope vanish together.", {"bounds": 1.2}),
        Case("teardrop", "x^5/2 + x^4/2 - y^2 - z^2", "The thread of a cusp, thinner than any step.", {"bounds": 0.4}),
        Case("kiss", "kiss", "A neck that narrows to a point."),
        Case("whitney", "whitney", "The handle of the umbrella is a line on which f touches zero from above."),
        Case("double_sphere", "(x^2 + y^2 + z^2 - 1)^2", "A double sheet: f never changes its sign.", {"bounds": 1.5}),
        Case("expanded_double_sphere", "x^4 + y^4 + z^4 + 2x^2 y^2 + 2y^2 z^2 + 2x^2 z^2 - 2x^2 - 2y^2 - 2z^2 + 1",
             "The same multiplied out: nothing shows any more that f is a square.", {"bounds": 1.5}),
        Case("near_miss", "(x^2 + y^2 + z^2 - 1)^2 + 10^(-6)", "There is no surface, but f comes as near to zero as 1e-6.", {"bounds": 1.5}),
        Case("isolated_circle", "isolated_circle", "f is zero on a circle and positive all round it."),
        Case("tiny_gap", "nested_spheres_tiny_gap", "Two spheres a millionth apart: between them f is about as large as its rounding."),
        Case("grazing_torus", "torus", "Near silhouettes two roots meet, and before them there is almost one.",
             {"camera": irt.Camera((3, 0.62, 0.4), (0, 0.3, 0))}),
        Case("klein_bottle", "klein_bottle", "Sheets cross inside; the outermost one counts."),
        Case("linked_tori", "linked_tori", "Large constants cancel: 10000 of what is added up is left as 1. Finders that cut where they expect a root find both sides of it within the error."),
        Case("tangle", "tangle", "Thin necks and many grazing rays."),
        Case("heart_far_bounds", "heart", "The surface fills a hundredth of the bounds.", {"bounds": 12, "camera": irt.Camera((1.2, 1.5, 3), fov=50)}),
        Case("barth_decic", "barth_decic", "345 double points; products of ten factors cancel."),
        Case("chmutov_14", "chmutov_14", "Printed as sums of monomials that cancel; at the faces of the cube the roots crowd."),
        Case("chmutov_20", "chmutov_20", "The same with coefficients past 2^24: single precision has no digits left."),
        Case("superquadric_200", "superquadric_200", "x^200 is zero in single precision almost everywhere, then infinite; its edges are nearly sharp."),
        Case("supersphere_16", "supersphere_16", "Flat inside, so steep outside that Newton's steps shrink to nothing. Over a tile of the screen sixteenth powers span more than single precision has digits for: the frustum form says so."),
        Case("huge_factor", "10^20*(x^3 + y^2 - z)", "A factor changes no zero, but squares of coefficients leave the range of floats.", {"bounds": 1.5}),
        Case("triple_plane", "(x + y/2 + z/3)^3", "Near the plane f is less than its rounding: where in there the root lies, no value tells.", {"bounds": 1.5}),
        Case("plateau", "(x^2 + y^2 + z^2 - 1)^7", "The sign changes, but with six derivatives that are zero there.", {"bounds": 1.5}),
        Case("mitchell", "mitchell", "Products of ranges that depend on one another are far too wide."),
        Case("pole", "1/x + y", "The sign changes across x = 0, where there is no surface.", {"bounds": 2}),
        Case("tangent_poles", "y - tan(3x)/2", "Branches of the tangent go through infinity between them.", {"bounds": 1.5}),
        Case("log_edge", "y - log(x)/3", "f is undefined for x <= 0, and endless just above.", {"bounds": 1.5}),
        Case("sqrt_edge", "y - sqrt(x)", "f is undefined for x < 0, with an endless slope at the edge, which is on the surface.", {"bounds": 1.5}),
        Case("piecewise", "Piecewise((x^2 + y^2 + z^2 - 1, x < 0), (x^2 + y^2 + z^2 - 1/2, True))", "Two formulas that do not meet: f jumps over zero at x = 0.", {"bounds": 1.3}),
        Case("menger_3", "menger_3", "Cubes out of cubes, three times: most rays pass many edges closely."),
        Case("stairs", "floor(3x)/3 - y", "Between the steps f jumps over zero: no surface there.", {"bounds": 1.2}),
        Case("octahedron", "Abs(x) + Abs(y) + Abs(z) - 1", "Planes that meet in creases: derivatives jump.", {"bounds": 1.2}),
        Case("sq_csg", "sq_csg", "A Max of two solids: creases and thin walls."),
        Case("cup", "cup", "CSG with a thin shell."),
        Case("noise_csg", "noise_csg", "Sines of sines: ranges are wide far from the surface."),
        Case("bubbles", "sin(9x) sin(9y) sin(9z) + 0.99", "Hundreds of bubbles, smaller than the steps of methods that sample.", {"bounds": 1.2}),
        Case("fast_waves", "y - sin(80x)/20 - sin(80z)/20", "Arguments grow fast: over most pieces a sine is anything from -1 to 1.", {"bounds": 1}),
        Case("thin_sheets", "(y - x^2/4)^2 - 10^(-6)", "Two sheets 0.002 apart, between which f is negative.", {"bounds": 1.2}),
        Case("far_camera", "x^4 + y^4 + z^4 - 1", "From 100 000 away: single precision counts distance in steps of 0.008.",
             {"bounds": 1.2, "camera": irt.Camera((48000, 36000, 80000), fov=0.0013)}),
        Case("eye_inside", "gyroid", "The camera stands between the sheets.", {"camera": irt.Camera((0.4, 0.3, 0.2), (2, 1, 0.5), fov=70)}),
        Case("overflow", "exp(60(x^2 + y^2 + z^2)) - exp(60)", "The exponential leaves single precision at 1.2, inside the bounds.", {"bounds": 1.5}),
        Case("barth_node", "barth_sextic", "A double point from near by: the sign of f is lost in rounding before the cones meet.",
             {"bounds": ((0.4, 0.7), (-0.15, 0.15), (0.85, 1.15)), "camera": _close(0.53, 0, 1)}),
    )
}  # fmt: skip
