"""The reference: where rays really meet the surface, with proof, whatever that takes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt import _core
from implicitrt.arguments import (
    finite,
    positive,
    ray_batch,
    request_camera,
    request_parameters,
    request_progress,
    request_region,
    request_size,
)
from implicitrt.camera import Camera
from implicitrt.errors import ArgumentError
from implicitrt.expression import ExprLike, sympify
from implicitrt.frame import Status

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["Reference", "reference"]

# numerics::Arithmetic, in its order.
_PRECISIONS = np.array(["none", "double", "fixed", "mpfr", "exact"])


class Reference:
    """What `reference` found. Arrays have the shape of the rays: (H, W) for a camera, (N,) for a batch.

    Attributes:
        kind: uint8, `Status`. MISS: proven. HIT: a zero where f changes its sign; nothing before it.
            TOUCH: a zero of even multiplicity, proven exactly (polynomials with rational
            coefficients only). UNRESOLVED: not decided; the bracket is the piece that is open, all of the ray where the time limit came first.
        depth: float64; +inf for MISS, the middle of the bracket for HIT and TOUCH, its start for
            UNRESOLVED. In lengths of the ray's direction.
        bracket: (..., 2) float64; nan for MISS. For HIT and TOUCH at most 1.5e-12 |depth| wide (or
            1.5e-15 of the range that counts, where that is more).
        precision: what decided: "double" (intervals of doubles), "fixed" (640 bits of fixed point with
            an error bound), "mpfr" (intervals of 160 or 640 bits), "exact" (rationals); "none"
            where the time limit came first.
        seconds: how long it took.
    """

    def __init__(self, result: Mapping[str, Any], shape: tuple[int, ...], seconds: float) -> None:
        kind = result["kind"]
        lo = np.where(kind == Status.MISS, np.nan, result["lo"])
        hi = np.where(kind == Status.MISS, np.nan, result["hi"])
        found = (kind == Status.HIT) | (kind == Status.TOUCH)
        depth = np.where(found, 0.5 * lo + 0.5 * hi, np.where(kind == Status.MISS, np.inf, lo))
        self.kind: npt.NDArray[np.uint8] = kind.reshape(shape)
        self.depth: npt.NDArray[np.float64] = depth.reshape(shape)
        self.bracket: npt.NDArray[np.float64] = np.stack([lo, hi], axis=-1).reshape(*shape, 2)
        self.precision: npt.NDArray[np.str_] = _PRECISIONS[result["arithmetic"]].reshape(shape)
        self.seconds = seconds

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """Where a zero was found: HIT or TOUCH."""
        found: npt.NDArray[np.bool_] = (self.kind == Status.HIT) | (self.kind == Status.TOUCH)
        return found

    @property
    def uncertainty(self) -> npt.NDArray[np.float64]:
        """Half the width of the bracket of HIT and TOUCH; nan elsewhere."""
        half: npt.NDArray[np.float64] = np.where(self.hit, 0.5 * (self.bracket[..., 1] - self.bracket[..., 0]), np.nan)
        return half

    def __repr__(self) -> str:
        counts = ", ".join(f"{int((self.kind == s).sum())} {s.name}" for s in Status if (self.kind == s).any())
        return f"Reference({' x '.join(map(str, self.kind.shape))}: {counts or 'no rays'}; {self.seconds:.2f} s)"


def reference(
    f: ExprLike,
    *where: Any,
    origins: npt.ArrayLike | None = None,
    directions: npt.ArrayLike | None = None,
    tmin: npt.ArrayLike = 0,
    tmax: npt.ArrayLike = math.inf,
    bounds: Any = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (640, 480),
    params: Mapping[str, float] | None = None,
    isovalue: float | None = None,
    time_limit: float | None = None,
    progress: Callable[[float], None] | None = None,
    **ignored: Any,
) -> Reference:
    """Where rays first meet f = 0, with proof: what `render` and `trace` are judged by. Slow.

    Takes what they take: `reference(f, bounds, camera, size, ...)` looks through a camera, with the
    rays of `Camera.rays`, and `reference(f, origins, directions, tmin, tmax, bounds, ...)` along a
    batch of rays.

    Polynomials in x, y, z (to degree 200 along a ray) become Bernstein coefficients and their roots
    are isolated by Descartes' rule; everything else is subdivided with ranges of f and of its
    derivative. Both start with intervals of doubles and go on, from where those cannot decide, with
    more bits: see `Reference.precision`. Rays and parameters are taken to be exactly the doubles
    given. Zeros where a `Clip` is proven positive are passed over; where its sign on a bracket cannot be
    told the ray is UNRESOLVED. Runs on the host, on all cores, and shares no arithmetic with the kernels.

    Args:
        f, bounds, camera, size, params, isovalue: as in `render`.
        origins, directions, tmin, tmax: as in `trace`.
        time_limit: seconds after which the rays that are left stay UNRESOLVED.
        progress: called with the fraction done, some times a second.
        ignored: `method`, `eps`, `device`, `precision`, `rounding`, `max_pieces`, `steps`, `outputs`, `normals`, `antialias`, `previous` and colours
            may be given, so that calls can be shared, and change nothing.

    Returns:
        a `Reference`.

    Raises:
        ExpressionError, ArgumentError, LimitError.
    """
    if where and (len(where) > 1 and not isinstance(where[1], Camera) and where[1] is not None):
        names: tuple[str, ...] = ("origins", "directions", "tmin", "tmax", "bounds")
    else:
        names = ("bounds", "camera", "size")
    if len(where) > len(names):
        raise ArgumentError(f"reference takes at most {len(names)} positional arguments after f: {', '.join(names)}")
    given = dict(zip(names, where, strict=False))
    origins, directions = given.get("origins", origins), given.get("directions", directions)
    tmin, tmax = given.get("tmin", tmin), given.get("tmax", tmax)
    bounds, camera, size = given.get("bounds", bounds), given.get("camera", camera), given.get("size", size)
    unknown = sorted(set(ignored) - _SHARED)
    if unknown:
        raise ArgumentError(f"reference has no argument {unknown[0]!r}")
    if (origins is None) != (directions is None):
        raise ArgumentError("origins and directions go together; give both, or a camera and neither")
    started = time.perf_counter()
    expr = sympify(f)
    shape: tuple[int, ...]
    if origins is None:
        if not (np.ndim(tmin) == np.ndim(tmax) == 0 and tmin == 0 and tmax == math.inf):
            raise ArgumentError("tmin and tmax are for origins and directions; a camera's rays begin at its eye")
        region = request_region(f, bounds)
        width, height = request_size(size)
        shape = (height, width)
        o, d = (a.reshape(-1, 3) for a in request_camera(f, camera, region, (width, height)).rays((width, height)))
        near, far = np.zeros(len(o)), np.full(len(o), math.inf)
    else:
        if camera is not None:
            raise ArgumentError("give a camera, or origins and directions, not both")
        o, d, near, far, region = ray_batch(f, origins, directions, tmin, tmax, bounds)
        shape = (len(o),)
    values = request_parameters(f, expr, params, region)
    if isovalue is not None:
        expr = expr - finite(isovalue, "isovalue")
    request = {
        "origins": o, "directions": d, "tmin": np.maximum(near, -1e300), "tmax": np.minimum(far, 1e300),
        "params": values, "time_limit": None if time_limit is None else positive(time_limit, "time_limit"), "progress": request_progress(progress),
    } | region.request()  # fmt: skip
    result = _core.reference(expr._node, request)
    unseen = (result["kind"] == Status.UNRESOLVED) & (_PRECISIONS[result["arithmetic"]] == "none")
    result["lo"], result["hi"] = np.where(unseen, near, result["lo"]), np.where(unseen, far, result["hi"])
    return Reference(result, shape, time.perf_counter() - started)


_SHARED = {
    "method", "eps", "device", "precision", "rounding", "max_pieces", "outputs", "color", "back_color", "light",
    "background", "unresolved_color", "steps", "normals", "antialias", "previous",
}  # fmt: skip
