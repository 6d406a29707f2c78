"""render, trace and enclose: arguments are checked here, kernels are run by the core."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt import _core
from implicitrt.bounds import Bounds
from implicitrt.camera import Camera
from implicitrt.devices import open_device
from implicitrt.errors import ArgumentError, LimitError, MethodError
from implicitrt.expression import Expr, ExprLike, check_parameter_names, sympify
from implicitrt.frame import Frame, Hits, Stats, Status
from implicitrt.surfaces import NamedSurface

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = [
    "Bisection",
    "Contraction",
    "Method",
    "enclose",
    "enclose_rays",
    "explain",
    "kernel_source",
    "methods",
    "render",
    "trace",
]

MAX_PIXELS = 1 << 26  # caps.h: kPixels
MAX_SAMPLES = 16  # in a row and in a column of a pixel: each costs a frame
SILHOUETTE_SAMPLES = 4  # likewise; steps of 1/16 in coverage are hardly seen


@dataclass(frozen=True)
class Method:
    """A root finder: what it accepts, what it guarantees ("inclusion", "numerical", "sampled")."""

    name: str
    accepts: str
    guarantee: str
    options: tuple[str, ...]
    source: str


@dataclass(frozen=True)
class Bisection:
    """Stackless bisection with an inclusion algebra, "ia" or "raa"; those names are its shorthand."""

    algebra: str = "raa"

    def __post_init__(self) -> None:
        if self.algebra not in ("ia", "raa"):
            raise ArgumentError(f'algebra must be "ia" or "raa", not {self.algebra!r}')


@dataclass(frozen=True)
class Contraction:
    """The forward march with affine contraction; "contract" is its shorthand."""


_FRUSTUM_FINDERS = {
    "lr": "the frustum form; Bezier subdivision at the control polygon's first zero",
    "lr-mult": "the same with an estimate of the root's multiplicity",
    "mr": "the frustum form; knots inserted at the control polygon's first zero",
    "mr-mult": "the same with an estimate of the root's multiplicity",
    "clip": "the frustum form; Bezier clipping",
    "midpoint": "the frustum form; subdivision at the middle",
}


_METHODS = MappingProxyType({
    m.name: m
    for m in (
        Method("ia", "every formula", "inclusion", ("eps", "max_pieces"),
               "S1 section 4.2: stackless bisection by interval arithmetic"),
        Method("raa", "every formula", "inclusion", ("eps", "max_pieces"),
               "S1 section 4.3: stackless bisection by reduced affine arithmetic"),
        Method("contract", "every formula", "inclusion", ("eps", "max_pieces"),
               "ours: a march that cuts away what the affine form excludes (docs/architecture.md)"),
        *(Method(f"frustum-{finder}", "polynomials in x, y, z up to degree 32", "inclusion", ("eps", "max_pieces"), f"S2 section 4.2: {what}")
          for finder, what in _FRUSTUM_FINDERS.items()),
        Method("auto", "every formula", "inclusion", ("eps", "max_pieces"),
               "contract, or ia for planes, jumps and high even powers; see explain"),
    )
})  # fmt: skip


def methods() -> Mapping[str, Method]:
    """Every method that is built, by name."""
    return _METHODS


def _choose(expr: Expr) -> tuple[str, str]:
    """The method that auto takes for a formula, and why."""
    jumps = choice = curved = powers = 0
    stack, seen = [expr._node], set()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        jumps += node.op in ("Mod", "floor", "ceiling", "sign", "Piecewise")
        choice += node.op in ("Min", "Max", "Abs")
        curved += node.op in _CURVED or (node.op == "Mul" and sum(a.op != "Number" for a in node.args) > 1)
        if node.op == "Pow" and node.args[1].op == "Number":
            p, q = node.args[1].ratio()
            powers += q == 1 and p % 2 == 0 and p > 40
        stack.extend(node.args)
    if powers:
        return "ia", "it has even powers above 40, whose ranges interval arithmetic keeps tight"
    if jumps:
        return "ia", "it has jumps, at which affine forms fall back to ranges anyway"
    if choice and not curved:
        return "ia", "it is made of planes, whose ranges along a ray interval arithmetic knows exactly"
    return "contract", "it is curved, and affine forms tell along the ray where zeros may lie"


# Methods whose root finder asks the clip formula (REGION_VARIABLES in kernels/contract.cl), or whose roots are judged by it
# (cpp/render/frustum_clip.h).
_CLIPPING = frozenset({"ia", "raa", "contract", *(f"frustum-{finder}" for finder in _FRUSTUM_FINDERS)})

_CURVED = frozenset({
    "Pow", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "cbrt",
})  # fmt: skip


def explain(f: ExprLike) -> str:
    """Which method "auto" takes for f, and why."""
    method, reason = _choose(sympify(f))
    return f"auto takes {method}: {reason}."


def _resolve(method: Any, expr: Expr) -> tuple[str, str]:
    """The name of the method that runs, and why."""
    if isinstance(method, Bisection):
        return method.algebra, "asked for"
    if isinstance(method, Contraction):
        return "contract", "asked for"
    if not isinstance(method, str) or method not in _METHODS:
        import difflib

        close = difflib.get_close_matches(str(method), list(_METHODS), 1)
        hint = f"; did you mean '{close[0]}'?" if close else ""
        raise ArgumentError(f"unknown method {method!r}{hint} known are: {', '.join(_METHODS)}")
    if method == "auto":
        return _choose(expr)
    return method, "asked for"


def _one_of(value: Any, what: str, allowed: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in allowed:
        raise ArgumentError(f"{what} must be one of {', '.join(map(repr, allowed))}, not {value!r}")
    return str(value)


def _positive(value: Any, what: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be a positive number, not {value!r}") from None
    if not (math.isfinite(number) and number > 0):
        raise ArgumentError(f"{what} must be positive and finite, not {value!r}")
    return number


def _finite(value: Any, what: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be a number, not {value!r}") from None
    if not math.isfinite(number):
        raise ArgumentError(f"{what} must be finite, not {number}")
    if abs(number) > 1e30:
        raise ArgumentError(f"{what} must lie within 1e30 of zero, not at {number}")
    return number


def request_parameters(
    f: Any, expr: Expr, params: Mapping[str, float] | None, bounds: Bounds | None = None
) -> dict[str, float]:
    """A checked value for each parameter of the formula and of the bounds' clips."""
    if params is not None and not isinstance(params, Mapping):
        raise ArgumentError(f"params must be a mapping of names to numbers, not {params!r}")
    names = parameter_names(expr, bounds)
    defaults = dict(f.params) if isinstance(f, NamedSurface) else {}
    given = {str(k): v for k, v in (params or {}).items()}
    values = defaults | given
    check_parameter_names(names, values)
    return {k: _finite(v, f"the parameter '{k}'") for k, v in values.items()}


def parameter_names(expr: Expr, bounds: Bounds | None) -> list[str]:
    """Symbols of the formula and of the bounds' clips, other than x, y, z; sorted."""
    symbols = set(expr.free_symbols)
    for c in bounds.clips if bounds else ():
        symbols |= c.g.free_symbols
    return sorted({s.name for s in symbols} - {"x", "y", "z"})


def _color(value: Any, what: str) -> tuple[float, float, float]:
    """A CSS name, "#rrggbb" or three numbers from 0 to 1 (sRGB), in linear light."""
    if isinstance(value, str):
        from PIL import ImageColor

        try:
            rgb = [c / 255 for c in ImageColor.getrgb(value)[:3]]
        except ValueError:
            raise ArgumentError(
                f"{what} {value!r} is no colour; use a CSS name, '#rrggbb' or three numbers 0..1"
            ) from None
    else:
        try:
            rgb = [float(c) for c in value]
        except (TypeError, ValueError, OverflowError):
            rgb = []
        if len(rgb) != 3 or not all(0 <= c <= 1 for c in rgb):
            raise ArgumentError(f"{what} must be a CSS name, '#rrggbb' or three numbers from 0 to 1, not {value!r}")
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb]
    return (linear[0], linear[1], linear[2])


def request_size(size: Any) -> tuple[int, int]:
    try:
        width, height = size
        pixels = (int(width), int(height))
        if pixels != (width, height):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"size must be (width, height) in whole pixels, not {size!r}") from None
    if pixels[0] < 1 or pixels[1] < 1:
        raise ArgumentError(f"size must be at least (1, 1), not {pixels}")
    if pixels[0] * pixels[1] > MAX_PIXELS or max(pixels) > 1 << 20:
        raise LimitError(
            f"{pixels[0]} x {pixels[1]} pixels are more than the limit of {MAX_PIXELS} (and 2**20 on a "
            "side); render parts of the picture"
        )
    return pixels


def request_region(f: Any, bounds: Any) -> Bounds:
    if bounds is None:
        return f.bounds if isinstance(f, NamedSurface) else Bounds.of(2)
    return Bounds.of(bounds)


def _common(
    f: Any, expr: Expr, bounds: Bounds, method: Any, eps: float | None, params: Mapping[str, float] | None,
    device: str | None, precision: str, rounding: str, isovalue: float | None, max_pieces: int | None,
    time_limit: float | None, progress: Callable[[float], None] | None,
) -> tuple[dict[str, Any], str]:  # fmt: skip
    """The part of a request that render and trace share, and why its method was chosen."""
    name, reason = _resolve(method, expr)
    if bounds.clips and name not in _CLIPPING:
        raise MethodError(
            f"{name} knows boxes, balls and half-spaces, not irt.Clip; {', '.join(sorted(_CLIPPING))} know it"
        )
    if max_pieces is not None and not (isinstance(max_pieces, (int, np.integer)) and 0 < max_pieces < 2**31):
        raise ArgumentError(f"max_pieces must be a whole number from 1 to 2**31 - 1, not {max_pieces!r}")
    request = {
        "method": name,
        "finder": name if name == "contract" or name.startswith("frustum-") else "bisection",
        "algebra": "ia" if name == "ia" else "raa",
        "precision": _one_of(precision, "precision", ("auto", "single", "double")),
        "rounding": _one_of(rounding, "rounding", ("outward", "fast")),
        "eps": bounds.default_eps if eps is None else _positive(eps, "eps"),
        "params": request_parameters(f, expr, params, bounds),
        "isovalue": None if isovalue is None else _finite(isovalue, "isovalue"),
        "max_pieces": int(max_pieces or 0),
        "time_limit": None if time_limit is None else _positive(time_limit, "time_limit"),
        "progress": progress,
        "device": open_device(device),
    } | bounds.request()
    return request, reason


def _stats(
    request: dict[str, Any], result: dict[str, Any], method: Any, reason: str, started: float, parsed: float
) -> Stats:
    proven = request["rounding"] == "outward"
    device = request["device"]
    depth = result["depth"]
    double = depth.dtype == np.float64
    return Stats(
        method=request["method"],
        reason=reason, guarantee="inclusion", proven=proven, algebra=request["algebra"],
        device=device.name, driver=device.driver, engine=result["engine"],
        precision="double" if double and request["precision"] == "double" else
                  "single and double" if double else "single",
        width=result["width"], rounding=request["rounding"], builds=int(result["builds"]),
        seconds={"parse": parsed - started, **result["seconds"], "total": time.perf_counter() - started},
        counts={s.name: n for s, n in zip(Status, result["counts"], strict=True)}, wide=int(result["wide"]), escalated=int(result["escalated"]),
    )  # fmt: skip


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
    time_limit: float | None = None,
    outputs: Collection[str] = ("rgb", "normal"),
    normals: str = "gradient",
    antialias: str | int | None = None,
    color: Any = "#5b9bd5",
    back_color: Any = "#e07b39",
    light: Any = (0.3, 0.9, 0.4),
    background: Any = "white",
    unresolved_color: Any = "magenta",
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
        method: a name of `methods()`, or a `Bisection`.
        eps: the width that a hit's bracket is to reach, in units of distance. Default: a thousandth
            of half the largest side of the bounds.
        params: values of the parameters of the formula and of `Clip`s. Changing them compiles nothing.
        device: part of a device's or driver's name; default: IMPLICITRT_DEVICE, else the best.
        precision: "single", "double", or "auto": single, and double where single cannot reach eps.
        rounding: "outward": every step is rounded so that MISS and HIT are proven; "fast": none is.
        isovalue: draws f = isovalue; changing it compiles nothing.
        max_pieces: pieces that one ray may look at before it is UNRESOLVED.
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
        progress: called with the fraction done, between bands of rows.

    Returns:
        a `Frame` of (height, width) arrays.

    Raises:
        ExpressionError, ArgumentError, LimitError, DeviceError, BuildError.

    Source: S1 (Knoll et al.) sections 4 and 5; S2 (Reimers and Seland) sections 4.2 to 4.4 for clip
    regions, normals from neighbours and anti-aliasing.
    """
    started = time.perf_counter()
    expr = sympify(f)
    region = request_region(f, bounds)
    if camera is None:
        camera = f.camera if isinstance(f, NamedSurface) and bounds is None else Camera.default(region)
    if not isinstance(camera, Camera):
        raise ArgumentError(f"camera must be an irt.Camera, not {camera!r}")
    camera = camera.framed(region)
    width, height = request_size(size)
    unknown = set(outputs) - {"rgb", "normal", "pieces"} if not isinstance(outputs, str) else {outputs}
    if unknown:
        raise ArgumentError(f'outputs is a collection of "rgb", "normal" and "pieces", not {outputs!r}')
    request, reason = _common(
        f, expr, region, method, eps, params, device, precision, rounding, isovalue, max_pieces, time_limit, progress
    )
    request |= {
        "want": set(outputs),
        "neighbours": _one_of(normals, "normals", ("gradient", "neighbours")) == "neighbours",
        "samples": _samples(antialias),
        "everywhere": antialias != "silhouette",
        "width": width,
        "height": height,
        "camera": camera.request(),
        "color": _color(color, "color"),
        "back_color": _color(back_color, "back_color"),
        "unresolved_color": _color(unresolved_color, "unresolved_color"),
        "background": None if background is None else _color(background, "background"),
        "light": None if light is None else _unit(light),
    }
    parsed = time.perf_counter()
    result = _core.render_frame(expr._node, request)
    stats = _stats(request, result, method, reason, started, parsed)
    return Frame(result, camera, region, request["params"], stats)


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
    from implicitrt.camera import point

    direction = np.array(point(light, "light"))
    length = float(np.linalg.norm(direction))
    if length == 0:
        raise ArgumentError("light is a direction towards the light, not the zero vector; None means no light")
    unit = direction / length
    return (float(unit[0]), float(unit[1]), float(unit[2]))


def _vectors(value: Any, what: str) -> npt.NDArray[np.float64]:
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiub":
            raise TypeError
        array = array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be numbers of shape (3,) or (N, 3)") from None
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise ArgumentError(f"{what} must have shape (3,) or (N, 3), not {array.shape}")
    return np.atleast_2d(array)


def _broadcast(*arrays: npt.NDArray[np.float64]) -> list[npt.NDArray[np.float64]]:
    counts = {len(a) for a in arrays} - {1}
    if len(counts) > 1:
        raise ArgumentError(f"the arrays have different lengths: {', '.join(str(len(a)) for a in arrays)}")
    n = counts.pop() if counts else 1
    return [np.ascontiguousarray(np.broadcast_to(a, (n, *a.shape[1:]))) for a in arrays]


def _scalars(value: Any, what: str) -> npt.NDArray[np.float64]:
    try:
        array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be a number or an array of shape (N,)") from None
    if array.ndim != 1:
        raise ArgumentError(f"{what} must be a number or an array of shape (N,), not {array.shape}")
    if np.isnan(array).any():
        raise ArgumentError(f"{what} must not be nan")
    return array


def _directions(value: Any) -> npt.NDArray[np.float64]:
    directions = _vectors(value, "directions")
    if not np.isfinite(directions).all():
        raise ArgumentError("directions must be finite")
    if len(directions) and not (directions != 0).any(axis=1).all():
        first = int(np.flatnonzero(~(directions != 0).any(axis=1))[0])
        raise ArgumentError(f"the direction of ray {first} is the zero vector")
    return directions


def trace(
    f: ExprLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    tmin: npt.ArrayLike = 0,
    tmax: npt.ArrayLike = math.inf,
    bounds: Any = None,
    method: Any = "auto",
    eps: float | None = None,
    params: Mapping[str, float] | None = None,
    device: str | None = None,
    precision: str = "auto",
    rounding: str = "outward",
    *,
    isovalue: float | None = None,
    max_pieces: int | None = None,
    time_limit: float | None = None,
) -> Hits:
    """Traces any batch of rays to the first zero of f.

    Args:
        f, method, eps, params, device, precision, rounding, isovalue, max_pieces, time_limit: as in
            `render`; eps and t count in lengths of the direction.
        origins, directions: (3,) or (N, 3), any float type; they broadcast.
        tmin, tmax: the part of each ray that counts; numbers or (N,).
        bounds: as in `render`; default: the named surface's, else none, and then tmax must be finite.

    Returns:
        `Hits` with arrays of length N. N = 0 works.

    Raises:
        ArgumentError: a ray is left infinite, a direction is zero or not finite, shapes do not fit.
    """
    started = time.perf_counter()
    expr = sympify(f)
    o, d, near, far, region = ray_batch(f, origins, directions, tmin, tmax, bounds)
    request, reason = _common(
        f, expr, region, method, eps, params, device, precision, rounding, isovalue, max_pieces, time_limit, None
    )
    request |= {
        "want": {"normal"},
        "origins": o,
        "directions": d,
        "tmin": np.maximum(near, -1e300),
        "tmax": np.minimum(far, 1e300),
    }
    parsed = time.perf_counter()
    result = _core.trace_rays(expr._node, request)
    return Hits(result, o, d, _stats(request, result, method, reason, started, parsed))


def ray_batch(
    f: Any, origins: Any, directions: Any, tmin: Any, tmax: Any, bounds: Any
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], Bounds]:
    """Checked origins and directions (N, 3), tmin and tmax (N,), and the bounds of a batch of rays."""
    origin_array = _vectors(origins, "origins")
    if not np.isfinite(origin_array).all():
        raise ArgumentError("origins must be finite")
    o, d, near, far = _broadcast(origin_array, _directions(directions), _scalars(tmin, "tmin"), _scalars(tmax, "tmax"))
    if bounds is None and not isinstance(f, NamedSurface):
        region = _enclosing(o, d, near, far)
    else:
        region = request_region(f, bounds)
    return o, d, near, far, region


def _enclosing(
    o: npt.NDArray[np.float64], d: npt.NDArray[np.float64], near: npt.NDArray[np.float64], far: npt.NDArray[np.float64]
) -> Bounds:
    """A box around all of the rays, which must be finite."""
    if not (np.isfinite(near).all() and np.isfinite(far).all()):
        raise ArgumentError("the rays are infinite: give bounds, or a finite tmax (and tmin)")
    if len(o) == 0:
        return Bounds.of(1)
    ends = np.concatenate([o + near[:, None] * d, o + far[:, None] * d])
    if not np.isfinite(ends).all():
        raise ArgumentError("the rays leave the range of numbers: give bounds, or a smaller tmax")
    low, high = ends.min(axis=0), ends.max(axis=0)
    pad = 1e-6 * max(float((high - low).max()), float(np.abs(ends).max()), 1e-3)
    return Bounds.of(tuple(zip((low - pad).tolist(), (high + pad).tolist(), strict=True)))


# Rounding outward ------------------------------------------------------------------------------


def _below(v: npt.NDArray[np.float64], precision: str) -> npt.NDArray[np.float64]:
    if precision == "double":
        return v
    with np.errstate(over="ignore"):
        f = v.astype(np.float32)
    f = np.where(f.astype(np.float64) > v, np.nextafter(f, np.float32(-np.inf)), f)
    return f.astype(np.float64)


def _above(v: npt.NDArray[np.float64], precision: str) -> npt.NDArray[np.float64]:
    return -_below(-v, precision)


def _step(v: npt.NDArray[np.float64], towards: float) -> npt.NDArray[np.float64]:
    return np.where(np.isfinite(v), np.nextafter(v, towards), v)


def _affine(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], precision: str) -> npt.NDArray[np.float64]:
    """Centre, slope 0 and radius of forms around [low, high], one row each."""
    with np.errstate(invalid="ignore", over="ignore"):
        middle = _below(0.5 * low + 0.5 * high, precision)
        radius = np.maximum(high - middle, middle - low)
    endless = ~np.isfinite(low) | ~np.isfinite(high) | ~np.isfinite(radius)
    middle = np.where(endless, 0.0, middle)
    radius = np.where(endless, np.inf, _above(_step(radius, np.inf), precision))
    return np.stack([middle, np.zeros_like(middle), radius], axis=-1)


def _enclose_request(
    f: Any,
    expr: Expr,
    algebra: str,
    params: Mapping[str, float] | None,
    precision: str,
    rounding: str,
    device: str | None,
) -> dict[str, Any]:
    return {
        "algebra": _one_of(algebra, "algebra", ("ia", "raa")),
        "precision": _one_of(precision, "precision", ("single", "double")),
        "rounding": _one_of(rounding, "rounding", ("outward", "fast")),
        "params": request_parameters(f, expr, params),
        "device": open_device(device),
    }


def _result(expr: Expr, request: dict[str, Any], pieces: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
    request["pieces"] = np.ascontiguousarray(pieces.reshape(len(pieces), 9))
    ranges = _core.enclose_pieces(expr._node, request)
    if request["precision"] == "double":
        return ranges
    with np.errstate(over="ignore"):
        return ranges.astype(np.float32)


def enclose(
    f: ExprLike,
    lower: npt.ArrayLike,
    upper: npt.ArrayLike,
    algebra: str = "ia",
    params: Mapping[str, float] | None = None,
    precision: str = "single",
    rounding: str = "outward",
    device: str | None = None,
) -> npt.NDArray[Any]:
    """Bounds of f over boxes, from the very kernel code that the tracer runs.

    Args:
        lower, upper: corners, (3,) or (N, 3); ends may be infinite. They are rounded outward to the
            working precision.
        algebra: "ia" or "raa".

    Returns:
        (N, 2): lower and upper bounds; nan, nan where f is defined nowhere in the box.

    Raises:
        ArgumentError: lower > upper, nan, or shapes that do not fit.
    """
    expr = sympify(f)
    low, high = _broadcast(_vectors(lower, "lower"), _vectors(upper, "upper"))
    if np.isnan(low).any() or np.isnan(high).any():
        raise ArgumentError("corners must not be nan")
    if (low > high).any():
        raise ArgumentError(
            f"lower must not be above upper; it is in box {int(np.flatnonzero((low > high).any(axis=1))[0])}"
        )
    request = _enclose_request(f, expr, algebra, params, precision, rounding, device)
    low, high = _below(low, precision), _above(high, precision)
    if algebra == "raa":
        return _result(expr, request, _affine(low, high, precision))
    return _result(expr, request, np.stack([low, high, np.zeros_like(low)], axis=-1))


def enclose_rays(
    f: ExprLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    t0: npt.ArrayLike,
    t1: npt.ArrayLike,
    algebra: str = "raa",
    params: Mapping[str, float] | None = None,
    precision: str = "single",
    rounding: str = "outward",
    device: str | None = None,
) -> npt.NDArray[Any]:
    """Bounds of f over pieces of rays, origin + t direction for t in [t0, t1].

    Args:
        origins, directions: (3,) or (N, 3).    t0, t1: numbers or (N,); ends may be infinite.
        algebra: "raa" follows the dependence along the ray; "ia" takes the piece's box.

    Returns:
        (N, 2): lower and upper bounds; nan, nan where f is defined nowhere on the piece.

    Raises:
        ArgumentError: t0 > t1, nan, zero directions, or shapes that do not fit.
    """
    expr = sympify(f)
    origin_array = _vectors(origins, "origins")
    if not np.isfinite(origin_array).all():
        raise ArgumentError("origins must be finite")
    o, d, start, end = _broadcast(origin_array, _directions(directions), _scalars(t0, "t0"), _scalars(t1, "t1"))
    if (start > end).any():
        raise ArgumentError(f"t0 must not be above t1; it is on ray {int(np.flatnonzero(start > end)[0])}")
    request = _enclose_request(f, expr, algebra, params, precision, rounding, device)
    with np.errstate(invalid="ignore", over="ignore"):
        at_start = np.where(d == 0, o, o + start[:, None] * d)
        at_end = np.where(d == 0, o, o + end[:, None] * d)
        # What the two roundings of o + t d can add.
        error = 4e-16 * (np.abs(o) + np.maximum(np.abs(start), np.abs(end))[:, None] * np.abs(d)) + 1e-300
    error = np.where(np.isfinite(error), error, 0.0)
    low = np.minimum(at_start, at_end) - error
    high = np.maximum(at_start, at_end) + error
    if algebra == "ia":
        low, high = _below(low, precision), _above(high, precision)
        return _result(expr, request, np.stack([low, high, np.zeros_like(low)], axis=-1))
    middle = _below(0.5 * at_start + 0.5 * at_end, precision)
    with np.errstate(invalid="ignore", over="ignore"):
        slope = _below(0.5 * (at_end - at_start), precision)
        # How far the exact piece may lie from middle + slope e, at either end of it.
        off = np.maximum(np.abs((middle - slope) - at_start), np.abs((middle + slope) - at_end)) + 2 * error
    endless = ~(np.isfinite(middle) & np.isfinite(slope) & np.isfinite(off))
    pieces = np.stack([middle, slope, _above(_step(off, np.inf), precision)], axis=-1)
    box = _affine(_below(low, precision), _above(high, precision), precision)
    return _result(expr, request, np.where(endless[..., None], box, pieces))


def kernel_source(
    f: ExprLike, method: Any = "auto", *, precision: str = "single", rounding: str = "outward",
    outputs: Collection[str] = ("rgb", "normal"), params: Mapping[str, float] | None = None,
    bounds: Any = None, device: str | None = None, isovalue: float | None = None,
) -> str:  # fmt: skip
    """The OpenCL C that `render` would run, readable; parameters need no values for it."""
    expr = sympify(f)
    region = request_region(f, bounds)
    values = (
        {n: 1.0 for n in parameter_names(expr, region)}
        | (dict(f.params) if isinstance(f, NamedSurface) else {})
        | dict(params or {})
    )
    request, _ = _common(f, expr, region, method, None, values, device, precision, rounding, isovalue, None, None, None)
    black = (0.0, 0.0, 0.0)
    request |= {
        "want": set(outputs), "color": black, "back_color": black, "unresolved_color": black,
        "background": None, "light": None,
    }  # fmt: skip
    return _core.kernel_source(expr._node, request)
