"""Cameras: where rays start and which way they go."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt.errors import ArgumentError

if TYPE_CHECKING:
    import numpy.typing as npt

    from implicitrt.bounds import Bounds

__all__ = ["Camera"]

# Where a camera looks from when none is given.
DEFAULT_DIRECTION = (0.48, 0.36, 0.8)


def point(value: Any, what: str) -> tuple[float, float, float]:
    """Three finite numbers, or an ArgumentError that names `what`."""
    if type(value) is tuple and len(value) == 3 and all(type(v) in (int, float) and abs(v) <= 1e15 for v in value):
        return (float(value[0]), float(value[1]), float(value[2]))  # as most are
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be three numbers, not {value!r}") from None
    if array.shape != (3,):
        raise ArgumentError(f"{what} must be three numbers, not an array of shape {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{what} must be finite, not {tuple(array.tolist())}")
    if np.max(np.abs(array)) > 1e15:
        raise ArgumentError(f"{what} must lie within 1e15 of the origin, not at {tuple(array.tolist())}")
    return (float(array[0]), float(array[1]), float(array[2]))


def number(value: Any, what: str) -> float:
    """A finite number, or an ArgumentError that names `what`."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} must be a number, not {value!r}") from None
    if not math.isfinite(found):
        raise ArgumentError(f"{what} must be finite, not {value!r}")
    return found


Vector = tuple[float, float, float]


def _cross(a: Vector, b: Vector) -> Vector:
    (ax, ay, az), (bx, by, bz) = a, b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def _over(a: Vector, length: float) -> Vector:
    return a[0] / length, a[1] / length, a[2] / length


@dataclass(frozen=True)
class Camera:
    """A camera at `origin` that looks at `target`.

    Row 0 is the top, column 0 the left; samples lie at pixel centres.

    Args:
        origin: the eye; in orthographic views the middle of the plane on which rays start.
        target: a point in the middle of the picture.
        up: a direction that is up in the picture; not parallel to the view.
        fov: vertical field of view in degrees, between 0 and 180 (perspective).
        projection: "perspective" or "orthographic".
        height: world units from the lower to the upper edge (orthographic); None frames the bounds.

    Raises:
        ArgumentError: anything is missing, not finite, or degenerate.
    """

    origin: tuple[float, float, float]
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov: float = 40.0
    projection: str = "perspective"
    height: float | None = None

    def __init__(
        self,
        origin: Sequence[float],
        target: Sequence[float] = (0, 0, 0),
        up: Sequence[float] = (0, 1, 0),
        fov: float = 40,
        projection: str = "perspective",
        height: float | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "origin", point(origin, "the camera's origin"))
        put(self, "target", point(target, "the camera's target"))
        put(self, "up", point(up, "the camera's up"))
        if not isinstance(projection, str) or projection not in ("perspective", "orthographic"):
            raise ArgumentError(f'projection must be "perspective" or "orthographic", not {projection!r}')
        put(self, "projection", str(projection))
        put(self, "fov", number(fov, "fov"))
        if not 0 < self.fov < 180:
            raise ArgumentError(f"fov must lie between 0 and 180 degrees, not {fov!r}")
        put(self, "height", None if height is None else number(height, "height"))
        if self.height is not None and not 0 < self.height <= 1e15:
            raise ArgumentError(f"height must be positive, not {height!r}")
        self._axes()  # raises where it is degenerate

    def basis(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Unit vectors (right, true up, forward), each of shape (3,)."""
        right, up, forward = self._axes()
        return np.array(right), np.array(up), np.array(forward)

    def _axes(self) -> tuple[Vector, Vector, Vector]:
        # Each frame asks for them: numbers take a tenth of the time that arrays of three take.
        (ox, oy, oz), (tx, ty, tz) = self.origin, self.target
        towards = (tx - ox, ty - oy, tz - oz)
        distance, length = math.hypot(*towards), math.hypot(*self.up)
        if distance == 0:
            raise ArgumentError(f"the camera's origin and target are the same point {self.origin}")
        if length == 0:
            raise ArgumentError("the camera's up is the zero vector")
        forward = _over(towards, distance)
        sideways = _cross(forward, _over(self.up, length))
        across = math.hypot(*sideways)
        if across < 1e-9:
            other = (0, 0, 1) if abs(forward[2]) < 0.9 else (0, 1, 0)
            raise ArgumentError(f"the camera's up {self.up} is parallel to its view; choose another, such as {other}")
        right = _over(sideways, across)
        return right, _cross(right, forward), forward

    def framed(self, bounds: Bounds, aspect: float = 1.0) -> Camera:
        """The camera with a height that frames the bounds, where it is orthographic without one, in pictures `aspect` times as wide as high."""
        if self.projection == "perspective" or self.height is not None:
            return self
        return Camera(self.origin, self.target, self.up, self.fov, self.projection, 2 * bounds.radius / min(aspect, 1.0))

    @staticmethod
    def default(bounds: Bounds, aspect: float = 1.0) -> Camera:
        """The camera that has the bounds' sphere in view, from the direction (0.48, 0.36, 0.8), in pictures `aspect` times as wide as high."""
        fov = 40.0
        direction = np.array(DEFAULT_DIRECTION) / np.linalg.norm(DEFAULT_DIRECTION)
        center = np.array(bounds.center)
        narrow = math.atan(math.tan(math.radians(fov / 2)) * min(aspect, 1.0))  # half the angle of the shorter side
        distance = bounds.radius / math.sin(narrow)
        origin = center + distance * direction
        return Camera(tuple(origin.tolist()), tuple(center.tolist()), fov=fov)

    def rays(self, size: tuple[int, int]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Origins and unit directions of the rays of a picture of (width, height) pixels.

        Returns:
            two arrays (height, width, 3) of float64.

        Raises:
            ArgumentError, LimitError: of the size; ArgumentError: an orthographic camera without a height.
        """
        from implicitrt.arguments import request_size  # which needs cameras

        width, height = request_size(size)
        right, up, forward = self.basis()
        u = (2 * (np.arange(width) + 0.5) / width - 1)[None, :, None]
        v = (1 - 2 * (np.arange(height) + 0.5) / height)[:, None, None]
        aspect = width / height
        if self.projection == "perspective":
            half = math.tan(math.radians(self.fov) / 2)
            directions = forward + u * half * aspect * right + v * half * up
            directions = directions / np.linalg.norm(directions, axis=2, keepdims=True)
            origins = np.broadcast_to(np.array(self.origin), directions.shape)
        else:
            if self.height is None:
                raise ArgumentError("an orthographic camera needs a height; see Camera.framed")
            half = self.height / 2
            origins = np.array(self.origin) + u * half * aspect * right + v * half * up
            directions = np.broadcast_to(forward, origins.shape)
        return origins, directions

    def request(self) -> dict[str, Any]:
        """What the core needs to make the rays."""
        right, up, forward = self._axes()
        return {
            "origin": self.origin,
            "right": right,
            "up": up,
            "forward": forward,
            "perspective": self.projection == "perspective",
            "tan_half_fov": math.tan(math.radians(self.fov) / 2),
            "height": self.height,
        }
