"""enclose and enclose_rays: bounds of f over boxes and pieces of rays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt import _core
from implicitrt.arguments import broadcast, directions_of, one_of, request_parameters, scalars, vectors
from implicitrt.devices import open_device
from implicitrt.errors import ArgumentError
from implicitrt.expression import Expr, ExprLike, sympify

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["enclose", "enclose_rays"]

# Rounding outward: the inputs' own, to the working precision.


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
        "algebra": one_of(algebra, "algebra", ("ia", "raa")),
        "precision": one_of(precision, "precision", ("single", "double")),
        "rounding": one_of(rounding, "rounding", ("outward", "fast")),
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
    low, high = broadcast(vectors(lower, "lower"), vectors(upper, "upper"))
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
    origin_array = vectors(origins, "origins")
    if not np.isfinite(origin_array).all():
        raise ArgumentError("origins must be finite")
    o, d, start, end = broadcast(origin_array, directions_of(directions), scalars(t0, "t0"), scalars(t1, "t1"))
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
    with np.errstate(invalid="ignore", over="ignore"):
        middle = _below(0.5 * at_start + 0.5 * at_end, precision)
        slope = _below(0.5 * (at_end - at_start), precision)
        # How far the exact piece may lie from middle + slope e, at either end of it.
        off = np.maximum(np.abs((middle - slope) - at_start), np.abs((middle + slope) - at_end)) + 2 * error
    endless = ~(np.isfinite(middle) & np.isfinite(slope) & np.isfinite(off))
    pieces = np.stack([middle, slope, _above(_step(off, np.inf), precision)], axis=-1)
    box = _affine(_below(low, precision), _above(high, precision), precision)
    return _result(expr, request, np.where(endless[..., None], box, pieces))
