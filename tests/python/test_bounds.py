"""Bounds: their forms, intersections, and what is refused."""

from __future__ import annotations

import math

import pytest

import implicitrt as irt
from implicitrt.bounds import Bounds


def test_forms() -> None:
    assert Bounds.of(2) == Bounds((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0))
    box = Bounds.of(((0, 1), (2, 3), (-1, 4)))
    assert box.lower == (0, 2, -1) and box.upper == (1, 3, 4)
    assert box.center == (0.5, 2.5, 1.5) and box.default_eps == pytest.approx(2.5e-3)
    ball = Bounds.of(irt.Sphere((1, 0, 0), 2))
    assert ball.spheres[0].radius == 2 and ball.lower[0] <= -1 and ball.upper[0] >= 3 and ball.radius == 2


def test_lists_are_intersections() -> None:
    both = Bounds.of([2, ((0, 5), (-1, 1), (-5, 5)), irt.Sphere((0, 0, 0), 1.5), irt.Sphere((1, 0, 0), 1)])
    assert both.lower[0] == pytest.approx(0) and both.upper[0] == pytest.approx(1.5)
    assert len(both.spheres) == 2
    boxes = [((0, 2), (0, 2), (0, 2)), ((1, 3), (0, 3), (0, 3)), ((0, 9), (0, 9), (0, 9))]
    assert Bounds.of(boxes).lower == (1, 0, 0)


def test_a_box_may_be_a_list() -> None:
    assert Bounds.of([[1, 2], [1, 2], [1, 2.5]]) == Bounds.of(((1, 2), (1, 2), (1, 2.5)))


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0, "positive"),
        (-1, "positive"),
        (math.nan, "positive"),
        (math.inf, "positive"),
        (((1, 0), (0, 1), (0, 1)), "empty: in x"),
        (((0, 1), (0, 1)), "bounds must be"),
        ("big", "bounds must be"),
        ([], "empty list"),
        ([1, ((2, 3), (0, 1), (0, 1))], "empty: in x"),
        (1e13, "too large"),
        (((0, 1), (0, math.inf), (0, 1)), "finite"),
    ],
)
def test_bad_bounds_are_refused(value: object, words: str) -> None:
    with pytest.raises(irt.ArgumentError, match=words):
        Bounds.of(value)


@pytest.mark.parametrize(
    ("center", "radius"), [((0, 0, 0), 0), ((0, 0, 0), math.inf), ((0, 0), 1), ((0, 0, math.nan), 1), ((0, 0, 0), "x")]
)
def test_bad_spheres_are_refused(center: tuple[float, ...], radius: float) -> None:
    with pytest.raises(irt.ArgumentError):
        irt.Sphere(center, radius)


def test_half_spaces_past_the_range_of_doubles_are_refused() -> None:
    with pytest.raises(irt.ArgumentError):
        irt.HalfSpace((0, 0, 1), 10**400)
