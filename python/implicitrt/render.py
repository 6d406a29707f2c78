"""render: pictures. Arguments are checked here, kernels are run by the core."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np

from implicitrt import _core
from implicitrt.arguments import (
    color_of,
    one_of,
    parameter_names,
    request_camera,
    request_outputs,
    request_region,
    request_size,
)
from implicitrt.bounds import Bounds
from implicitrt.camera import Camera, point
from implicitrt.errors import ArgumentError, MethodError
from implicitrt.expression import Expr, ExprLike, sympify
from implicitrt.frame import Frame
from implicitrt.methods import methods
from implicitrt.request import finder_request, stats_of
from implicitrt.surfaces import NamedSurface

__all__ = ["kernel_source", "render"]

MAX_SAMPLES = 16  # in a row and in a column of a pixel: each costs a frame
SILHOUETTE_SAMPLES = 4  # likewise; steps of 1/16 in coverage are hardly seen


def render(
    f: ExprLike,
    bounds: Any = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (640, 480),
    method: Any = "auto",
    eps: float | None = None,
    params: Mapping[str, float] | None = None,
    device: str | None = None,
    precision: str = "auto",
    rounding: str = "outward",
    *,
    isovalue: float | None = None,
    max_pieces: int | None = None,
    steps: int | None = None,
    time_limit: float | None = None,
    outputs: Collection[str] = ("rgb", "normal"),
    normals: str = "gradient",
    antialias: str | int | None = None,
    color: Any = "#5b9bd5",
    back_color: Any = "#e07b39",
    light: Any = (0.3, 0.9, 0.4),
    background: Any = "white",
    unresolved_color: Any = "magenta",
    previous: Frame | None = None,
    progress: Callable[[float], None] | None = None,
) -> Frame:
    """Draws the surface f = 0.

    Args:
        f: a formula (Expr, string, SymPy object) or a named surface.
        bounds: where surface counts: r for the cube [-r, r]^3, a box ((x0, x1), (y0, y1), (z0, z1)),
            `Sphere`, or a list of them, which may hold `HalfSpace` and `Clip` as well: their
            intersection. Clipped surfaces are open, not capped. Default: the named surface's, else 2.
        camera: `Camera`; default: the named surface's, else one with the bounds in view.
        size: (width, height) in pixels.
        method: a name of `methods()`, or an object with its options: `Bisection`, `Contraction`, `Mitchell`, `Marching`,
            `SampledNewton`.
        eps: the width that a hit's bracket is to reach, in units of distance. Default: a thousandth
            of half the largest side of the bounds.
        params: values of the parameters of the formula and of `Clip`s. Changing them compiles nothing, but that a value may need what none before it did:
            double precision, or contraction where it leaves much open that the frustum form decides else.
        device: part of a device's or driver's name; default: IMPLICITRT_DEVICE, else the best.
        precision: "single", "double", or "auto": single, and double for rays where single cannot reach eps; where it hardly
            could for any, double narrows down what single has found, or finds it. Where "auto" redoes more than 8 pixels, their depths may
            differ from frame to frame, by their uncertainty at most.
        rounding: "outward": every step is rounded so that MISS and HIT are proven; "fast": none is.
        isovalue: draws f = isovalue; changing it compiles nothing.
        max_pieces: pieces that one ray may look at before it is UNRESOLVED.
        steps: along each ray inside the bounds, by the methods that sample; the adaptive ones shorten and lengthen them.
        time_limit: seconds after which the rest of the frame is left UNRESOLVED.
        outputs: of "rgb", "normal" and "pieces" (how many pieces each ray took) those that are
            wanted; kernels contain nothing else.
        normals: "gradient", which is exact; or "neighbours": from the points of neighbouring pixels, which
            exist where the gradient vanishes (double surfaces), and are as good as eps is small beside
            a pixel. Next to silhouettes differences are one-sided; pixels that no neighbour in their
            row or in their column helps take the gradient.
        antialias: None; n for the mean of n x n samples in each pixel, in linear light; or "silhouette":
            4 x 4 samples, with gradient normals, in pixels next to a miss or a jump of depth only.
            Changes rgb and rgba alone: all else is that of the pixels' centres.
        color, back_color: of the sides where f > 0 and f < 0, as CSS name, "#rrggbb", or 0..1 sRGB.
        light: a direction towards the one light besides the headlight; None for none.
        background: a colour, or None for transparent.
        unresolved_color: of UNRESOLVED pixels.
        previous: a frame of the same formula and size, for the methods on the frustum form: roots are looked for near those
            of the same pixels there first. Changes how long it takes, and nothing that is said of a pixel; its kernel
            is another one, which the first such frame builds. `auto` takes it where it takes such a method.
        progress: called with the fraction done, between bands of rows.

    Returns:
        a `Frame` of (height, width) arrays.

    Raises:
        ExpressionError, ArgumentError, MethodError, LimitError, DeviceError, BuildError.

    Source: S1 (Knoll et al.) sections 4 and 5; S2 (Reimers and Seland) sections 4.2 to 4.4 for frame coherence, clip
    regions, normals from neighbours and anti-aliasing.
    """
    started = time.perf_counter()
    expr = sympify(f)
    region = request_region(f, bounds)
    width, height = request_size(size)
    camera = request_camera(f, camera, region, (width, height))
    want = request_outputs(outputs)
    request, reason = finder_request(
        f, expr, region, method, eps, params, device, precision, rounding, isovalue, max_pieces, time_limit, progress,
        frames=True, steps=steps,
    )
    request |= {
        "want": want,
        "neighbours": one_of(normals, "normals", ("gradient", "neighbours")) == "neighbours",
        "samples": _samples(antialias),
        "everywhere": antialias != "silhouette",
        "width": width,
        "height": height,
        "camera": camera.request(),
        "color": color_of(color, "color"),
        "back_color": color_of(back_color, "back_color"),
        "unresolved_color": color_of(unresolved_color, "unresolved_color"),
        "background": None if background is None else color_of(background, "background"),
        "light": None if light is None else _unit(light),
        "previous": _previous(previous, request["method"], method == "auto", expr, (width, height), region),
    }
    parsed = time.perf_counter()
    result = _core.render_frame(request["formula"], request)
    stats = stats_of(request, result, reason, started, parsed)
    return Frame(result, expr, camera, region, request["params"], stats)


def _previous(frame: Any, name: str, auto: bool, expr: Expr, size: tuple[int, int], region: Bounds) -> tuple[Any, float] | None:
    """Depths of the frame before, and how far its camera was from the plane through the middle of the bounds."""
    if frame is None:
        return None
    if not isinstance(frame, Frame):
        raise ArgumentError(f"previous must be a Frame that render returned, not {type(frame).__name__}")
    if frame.formula != expr:
        raise ArgumentError("previous is a frame of another formula; parameters, isovalue and camera may differ, the formula may not")
    if frame.size != size:
        raise ArgumentError(f"previous is a frame of {frame.size[0]} x {frame.size[1]} pixels, and this one has {size[0]} x {size[1]}")
    if "previous" not in methods()[name].options:
        if auto:
            return None
        able = ", ".join(n for n, m in methods().items() if "previous" in m.options)
        raise MethodError(f"{name} makes no use of a previous frame; {able} do")
    return frame.depth, float(frame.camera.basis()[2] @ (np.array(region.center) - frame.camera.origin))


def _samples(antialias: Any) -> int:
    """Samples in a row and in a column of a pixel."""
    if antialias is None:
        return 1
    if isinstance(antialias, str) and antialias == "silhouette":
        return SILHOUETTE_SAMPLES
    if isinstance(antialias, (int, np.integer)) and not isinstance(antialias, bool) and 1 <= antialias <= MAX_SAMPLES:
        return int(antialias)
    raise ArgumentError(
        f'antialias must be None, "silhouette" or a whole number from 1 to {MAX_SAMPLES}, not {antialias!r}'
    )


def _unit(light: Any) -> tuple[float, float, float]:
    x, y, z = point(light, "light")
    length = math.hypot(x, y, z)
    if length == 0:
        raise ArgumentError("light is a direction towards the light, not the zero vector; None means no light")
    return x / length, y / length, z / length


def kernel_source(
    f: ExprLike, method: Any = "auto", *, precision: str = "single", rounding: str = "outward",
    outputs: Collection[str] = ("rgb", "normal"), params: Mapping[str, float] | None = None,
    bounds: Any = None, device: str | None = None, isovalue: float | None = None,
) -> str:  # fmt: skip
    """The OpenCL C that `render` would run first, readable; parameters need no values for it."""
    expr = sympify(f)
    region = request_region(f, bounds)
    if params is not None and not isinstance(params, Mapping):
        raise ArgumentError(f"params must be a mapping of names to numbers, not {params!r}")
    values = {n: 1.0 for n in parameter_names(expr, region)} | (dict(f.params) if isinstance(f, NamedSurface) else {}) | dict(params or {})
    request, _ = finder_request(f, expr, region, method, None, values, device, precision, rounding, isovalue, None, None, None, frames=True)
    black = (0.0, 0.0, 0.0)
    request |= {
        "want": request_outputs(outputs), "color": black, "back_color": black, "unresolved_color": black,
        "background": None, "light": None,
    }  # fmt: skip
    return _core.kernel_source(request["formula"], request)
