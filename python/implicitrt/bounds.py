"""Bounds: the closed region in which surface counts (S2 section 4.2: clip regions)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from implicitrt.camera import number, point
from implicitrt.errors import ArgumentError
from implicitrt.expression import Expr, ExprLike, Max, sympify

__all__ = ["Bounds", "Clip", "HalfSpace", "Sphere"]

# Bounds larger or smaller than this leave single precision no digits or no exponents.
LARGEST = 1e12
SMALLEST = 1e-12


@dataclass(frozen=True)
class Sphere:
    """A ball to clip to: `center` (3,) and `radius`."""

    center: tuple[float, float, float]
    radius: float

    def __init__(self, center: Sequence[float], radius: float) -> None:
        object.__setattr__(self, "center", point(center, "the sphere's center"))
        value = number(radius, "the sphere's radius")
        if value <= 0:
            raise ArgumentError(f"the sphere's radius must be positive, not {radius!r}")
        object.__setattr__(self, "radius", value)


@dataclass(frozen=True)
class HalfSpace:
    """The side normal . p <= offset of a plane, to clip to; `normal` (3,) has any length."""

    normal: tuple[float, float, float]
    offset: float

    def __init__(self, normal: Sequence[float], offset: float) -> None:
        vector = point(normal, "the half-space's normal")
        object.__setattr__(self, "normal", vector)
        value = number(offset, "the half-space's offset")
        largest = max(map(abs, vector))
        if largest == 0:
            raise ArgumentError("the half-space's normal is the zero vector; give the direction that points out of it")
        if not abs(value) <= 1e15 * largest:
            raise ArgumentError(f"the half-space's plane must lie within 1e15 of the origin; its offset is {offset!r}")
        object.__setattr__(self, "offset", value)

    def scaled(self) -> tuple[float, float, float, float]:
        """Normal and offset times the power of two that brings the normal's largest coordinate into [1, 2)."""
        exponent = 1 - math.frexp(max(map(abs, self.normal)))[1]
        a, b, c, d = (math.ldexp(v, exponent) for v in (*self.normal, self.offset))
        return (a, b, c, d)


@dataclass(frozen=True)
class Clip:
    """The region g <= 0 of any formula g, to clip to; where g is undefined nothing counts.

    Symbols other than x, y, z are parameters, with values in the call's `params`.
    """

    g: Expr

    def __init__(self, g: ExprLike) -> None:
        object.__setattr__(self, "g", sympify(g))


@dataclass(frozen=True)
class Bounds:
    """A box, and balls, half-spaces and formulas that cut it."""

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    spheres: tuple[Sphere, ...] = ()
    half_spaces: tuple[HalfSpace, ...] = ()
    clips: tuple[Clip, ...] = ()

    @property
    def clip(self) -> Expr | None:
        """The formula that is at most zero where all clips are; None without clips."""
        parts = tuple(dict.fromkeys(c.g for c in self.clips))
        return (parts[0] if len(parts) == 1 else Max(*parts)) if parts else None

    def request(self) -> dict[str, Any]:
        """What the core needs to clip rays."""
        g = self.clip
        return {
            "lower": self.lower,
            "upper": self.upper,
            "spheres": [(*s.center, s.radius) for s in self.spheres],
            "half_spaces": [h.scaled() for h in self.half_spaces],
            "clip": None if g is None else g._node,
        }

    @property
    def center(self) -> tuple[float, float, float]:
        """The middle of the box."""
        low, high = self.lower, self.upper
        return (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))

    @property
    def radius(self) -> float:
        """The radius of the sphere around the box; of the ball, where the bounds are one ball."""
        corner = 0.5 * math.dist(self.lower, self.upper)
        return min(self.spheres[0].radius, corner) if len(self.spheres) == 1 else corner

    @property
    def default_eps(self) -> float:
        """A thousandth of half the largest side."""
        return 1e-3 * 0.5 * max(b - a for a, b in zip(self.lower, self.upper, strict=True))

    @property
    def single_resolution(self) -> float:
        """What single precision resolves along a ray: a unit of a path (kernels/path.cl), or the rounding of coordinates."""
        return max(math.dist(self.lower, self.upper), max(map(abs, self.lower + self.upper))) * 2.0**-21

    @staticmethod
    def of(value: Any) -> Bounds:
        """Bounds from a number r (the cube [-r, r]^3), a box ((x0, x1), (y0, y1), (z0, z1)), a
        `Sphere`, or a list of these, of `HalfSpace` and of `Clip`, which is their intersection.

        Raises:
            ArgumentError: not finite, empty, without a bounded part, or of another form.
        """
        if isinstance(value, Bounds):
            return value
        if isinstance(value, (HalfSpace, Clip)):
            value = [value]
        if isinstance(value, list) and not _is_box(value):
            half_spaces = tuple(v for v in value if isinstance(v, HalfSpace))
            clips = tuple(v for v in value if isinstance(v, Clip))
            return _intersection(
                [Bounds.of(v) for v in value if not isinstance(v, (HalfSpace, Clip))], half_spaces, clips
            )
        if isinstance(value, Sphere):
            # A little larger than the ball, so that the ball alone decides.
            r = value.radius * (1 + 1e-9)
            center = value.center
            return _checked([c - r for c in center], [c + r for c in center], (value,))
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise ArgumentError(_forms(value)) from None
        if array.shape == ():
            r = float(array)
            if not (math.isfinite(r) and r > 0):
                raise ArgumentError(f"bounds must be positive and finite, not {value!r}")
            return _checked([-r] * 3, [r] * 3, ())
        if array.shape != (3, 2):
            raise ArgumentError(_forms(value))
        return _checked(array[:, 0].tolist(), array[:, 1].tolist(), ())


def _is_box(value: list[Any]) -> bool:
    """Whether a list is three pairs of numbers: a box, as JSON and `tolist` write it."""
    return len(value) == 3 and all(
        isinstance(side, (list, tuple)) and len(side) == 2 and all(isinstance(v, (int, float, np.number)) for v in side)
        for side in value
    )


def _forms(value: Any) -> str:
    return (
        "bounds must be a number r, a box ((x0, x1), (y0, y1), (z0, z1)), an irt.Sphere, or a list "
        f"of these, irt.HalfSpace and irt.Clip, not {value!r}"
    )


def _checked(lower: list[float], upper: list[float], spheres: tuple[Sphere, ...]) -> Bounds:
    for axis, low, high in zip("xyz", lower, upper, strict=True):
        if not (math.isfinite(low) and math.isfinite(high)):
            raise ArgumentError(f"bounds must be finite; in {axis} they are {low} to {high}")
        if not low < high:
            raise ArgumentError(f"the bounds are empty: in {axis} they go from {low} to {high}")
        if max(abs(low), abs(high)) > LARGEST or high - low < SMALLEST * max(1.0, abs(low), abs(high)):
            raise ArgumentError(
                f"the bounds in {axis}, {low} to {high}, are too large or too thin for the "
                f"precision; they must stay within {LARGEST:g}; scale the formula"
            )
    a, b = lower, upper
    return Bounds((a[0], a[1], a[2]), (b[0], b[1], b[2]), spheres)


def _intersection(parts: list[Bounds], half_spaces: tuple[HalfSpace, ...], clips: tuple[Clip, ...]) -> Bounds:
    if not parts and (half_spaces or clips):
        raise ArgumentError(
            "half-spaces and clips alone leave the bounds infinite; put a number, a box or an irt.Sphere into the list"
        )
    if not parts:
        raise ArgumentError("bounds are an empty list; give at least one region")
    lower = [max(p.lower[k] for p in parts) for k in range(3)]
    upper = [min(p.upper[k] for p in parts) for k in range(3)]
    box = _checked(lower, upper, tuple(s for p in parts for s in p.spheres))
    return replace(
        box,
        half_spaces=tuple(h for p in parts for h in p.half_spaces) + half_spaces,
        clips=tuple(c for p in parts for c in p.clips) + clips,
    )
