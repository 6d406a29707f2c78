"""Arguments that render, trace, enclose and reference share: checked here, once, with errors that say what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt import _core
from implicitrt.bounds import Bounds
from implicitrt.camera import Camera, number
from implicitrt.errors import ArgumentError, LimitError
from implicitrt.expression import Expr, check_parameter_names
from implicitrt.surfaces import NamedSurface

if TYPE_CHECKING:
    import numpy.typing as npt


def one_of(value: Any, what: str, allowed: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in allowed:
        raise ArgumentError(f"{what} must be one of {', '.join(map(repr, allowed))}, not {value!r}")
    return str(value)


def positive(value: Any, what: str) -> float:
    found = number(value, what)
    if found <= 0:
        raise ArgumentError(f"{what} must be positive, not {value!r}")
    return found


def finite(value: Any, what: str) -> float:
    found = number(value, what)
    if abs(found) > 1e30:
        raise ArgumentError(f"{what} must lie within 1e30 of zero, not at {found}")
    return found


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
    check_parameter_names(names, values, "params={'NAME': ...}")
    return {k: finite(v, f"the parameter '{k}'") for k, v in values.items()}


def parameter_names(expr: Expr, bounds: Bounds | None) -> list[str]:
    """Symbols of the formula and of the bounds' clips, other than x, y, z; sorted."""
    names = _symbols(expr)
    for c in bounds.clips if bounds else ():
        names |= _symbols(c.g)
    return sorted(names - {"x", "y", "z"})


@lru_cache(maxsize=256)
def _symbols(expr: Expr) -> frozenset[str]:
    return frozenset(s.name for s in expr.free_symbols)


def color_of(value: Any, what: str) -> tuple[float, float, float]:
    """A CSS name, "#rrggbb" or three numbers from 0 to 1 (sRGB), in linear light."""
    if isinstance(value, str):
        try:
            return _named_color(value)
        except ValueError:
            raise ArgumentError(
                f"{what} {value!r} is no colour; use a CSS name, '#rrggbb' or three numbers 0..1"
            ) from None
    try:
        rgb = [float(c) for c in value]
    except (TypeError, ValueError, OverflowError):
        rgb = []
    if len(rgb) != 3 or not all(0 <= c <= 1 for c in rgb):
        raise ArgumentError(f"{what} must be a CSS name, '#rrggbb' or three numbers from 0 to 1, not {value!r}")
    return _linear(rgb)


@lru_cache(maxsize=64)
def _named_color(name: str) -> tuple[float, float, float]:
    from PIL import ImageColor

    return _linear([c / 255 for c in ImageColor.getrgb(name)[:3]])


def _linear(rgb: list[float]) -> tuple[float, float, float]:
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
    if pixels[0] * pixels[1] > _core.MAX_PIXELS or max(pixels) > _core.MAX_SIDE:
        raise LimitError(
            f"{pixels[0]} x {pixels[1]} pixels are more than the limit of {_core.MAX_PIXELS} (and {_core.MAX_SIDE} on a "
            "side); render parts of the picture"
        )
    return pixels


def request_camera(f: Any, camera: Any, region: Bounds, size: tuple[int, int]) -> Camera:
    """The camera that was given, else the named surface's, else one with the region in view."""
    aspect = size[0] / size[1]
    if camera is None:
        camera = f.camera if isinstance(f, NamedSurface) else Camera.default(region, aspect)
    if not isinstance(camera, Camera):
        raise ArgumentError(f"camera must be an irt.Camera, not {camera!r}")
    return camera.framed(region, aspect)


def request_progress(progress: Any) -> Any:
    if progress is not None and not callable(progress):
        raise ArgumentError(f"progress must be a function of the fraction done, not {progress!r}")
    return progress


def request_outputs(outputs: Any) -> set[str]:
    allowed = {"rgb", "normal", "pieces"}
    try:
        wanted = set() if isinstance(outputs, str) else set(outputs)
    except TypeError:
        wanted = {None}
    if isinstance(outputs, str) or wanted - allowed:
        raise ArgumentError(f'outputs is a collection of "rgb", "normal" and "pieces", not {outputs!r}')
    return wanted


def request_region(f: Any, bounds: Any) -> Bounds:
    if bounds is None:
        return f.bounds if isinstance(f, NamedSurface) else Bounds.of(2)
    return Bounds.of(bounds)


def vectors(value: Any, what: str) -> npt.NDArray[np.float64]:
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


def broadcast(*arrays: npt.NDArray[np.float64]) -> list[npt.NDArray[np.float64]]:
    counts = {len(a) for a in arrays} - {1}
    if len(counts) > 1:
        raise ArgumentError(f"the arrays have different lengths: {', '.join(str(len(a)) for a in arrays)}")
    n = counts.pop() if counts else 1
    if n > _core.MAX_PIXELS:
        raise LimitError(f"{n} rays or boxes are more than the limit of {_core.MAX_PIXELS}; take them in parts")
    return [np.ascontiguousarray(np.broadcast_to(a, (n, *a.shape[1:]))) for a in arrays]


def scalars(value: Any, what: str) -> npt.NDArray[np.float64]:
    try:
        array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be a number or an array of shape (N,)") from None
    if array.ndim != 1:
        raise ArgumentError(f"{what} must be a number or an array of shape (N,), not {array.shape}")
    if np.isnan(array).any():
        raise ArgumentError(f"{what} must not be nan")
    return array


def directions_of(value: Any) -> npt.NDArray[np.float64]:
    directions = vectors(value, "directions")
    if not np.isfinite(directions).all():
        raise ArgumentError("directions must be finite")
    if len(directions) and not (directions != 0).any(axis=1).all():
        first = int(np.flatnonzero(~(directions != 0).any(axis=1))[0])
        raise ArgumentError(f"the direction of ray {first} is the zero vector")
    return directions


def ray_batch(
    f: Any, origins: Any, directions: Any, tmin: Any, tmax: Any, bounds: Any
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], Bounds]:
    """Checked origins and directions (N, 3), tmin and tmax (N,), and the bounds of a batch of rays."""
    origin_array = vectors(origins, "origins")
    if not np.isfinite(origin_array).all():
        raise ArgumentError("origins must be finite")
    o, d, near, far = broadcast(origin_array, directions_of(directions), scalars(tmin, "tmin"), scalars(tmax, "tmax"))
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
