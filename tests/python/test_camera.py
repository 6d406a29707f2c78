"""Cameras: the basis, the rays, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import implicitrt as irt
from implicitrt.bounds import Bounds


def test_basis_is_orthonormal_and_right_handed() -> None:
    right, up, forward = irt.Camera((1, 2, 3), target=(-1, 0.5, 2), up=(0.1, 1, 0.2)).basis()
    frame = np.stack([right, up, forward])
    assert np.allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.allclose(np.cross(right, forward), up)
    assert np.allclose(forward, np.array([-2, -1.5, -1]) / math.sqrt(4 + 2.25 + 1))


def test_rays_of_a_perspective_view() -> None:
    camera = irt.Camera((0, 0, 5), fov=60)
    origins, directions = camera.rays((4, 2))
    assert origins.shape == directions.shape == (2, 4, 3)
    assert np.allclose(np.linalg.norm(directions, axis=2), 1)
    half = math.tan(math.radians(30))
    # Row 0 is the top, column 0 the left, samples lie at pixel centres.
    expected = np.array([-0.75 * half * 2, 0.5 * half, -1])
    assert np.allclose(directions[0, 0], expected / np.linalg.norm(expected))
    assert directions[0, 0, 1] > 0 > directions[1, 0, 1] and directions[0, 0, 0] < 0 < directions[0, 3, 0]


def test_rays_of_an_orthographic_view() -> None:
    camera = irt.Camera((0, 0, 5), projection="orthographic", height=2)
    origins, directions = camera.rays((4, 2))
    assert np.allclose(directions, [0, 0, -1])
    assert np.allclose(origins[0, 0], [-1.5, 0.5, 5])
    framed = irt.Camera((0, 0, 5), projection="orthographic").framed(Bounds.of(1))
    assert framed.height == pytest.approx(2 * math.sqrt(3))


def test_the_default_camera_has_the_bounds_in_view() -> None:
    bounds = Bounds.of(((0, 2), (1, 4), (-1, 1)))
    camera = irt.Camera.default(bounds)
    _, _, forward = camera.basis()
    corners = np.array(np.meshgrid(*zip(bounds.lower, bounds.upper, strict=True))).reshape(3, -1).T
    offset = corners - np.array(camera.origin)
    cosine = (offset @ forward) / np.linalg.norm(offset, axis=1)
    assert cosine.min() >= math.cos(math.radians(camera.fov / 2))
    assert np.allclose(-forward, np.array([0.48, 0.36, 0.8]) / np.linalg.norm([0.48, 0.36, 0.8]))


@pytest.mark.parametrize("size", [(8, 32), (32, 32), (32, 8)])
@pytest.mark.parametrize("camera", [None, irt.Camera((0, 0, 5), projection="orthographic")])
def test_the_bounds_are_in_view_at_every_aspect(camera: irt.Camera | None, size: tuple[int, int]) -> None:
    """A sphere a little larger than that of the bounds would be cut by the edges of the picture, one a little smaller is not."""
    frame = irt.render("x^2 + y^2 + z^2 - 1", bounds=irt.Sphere((0, 0, 0), 1.01), camera=camera, size=size)
    edges = frame.hit[0].any(), frame.hit[-1].any(), frame.hit[:, 0].any(), frame.hit[:, -1].any()
    wide = size[0] >= size[1]
    assert edges[2:] == (False, False) or not wide or size[0] == size[1]
    assert edges[:2] == (False, False) or wide
    assert frame.hit.any() and frame.hit.sum() < 0.9 * min(size) ** 2


def test_a_named_surface_has_its_camera_whatever_the_bounds() -> None:
    torus = irt.surfaces["torus"]
    assert irt.render(torus, bounds=1, size=(8, 6)).camera == torus.camera
    assert np.array_equal(irt.render(torus, bounds=1, size=(8, 6)).hit, irt.reference(torus, bounds=1, size=(8, 6)).hit)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.3, 0.1, 0.9)])
def test_the_up_that_is_proposed_will_do(axis: tuple[float, float, float]) -> None:
    with pytest.raises(irt.ArgumentError, match="parallel") as error:
        irt.Camera(axis, up=axis)
    other = str(error.value).rpartition("such as (")[2].rstrip(")").split(", ")
    irt.Camera(axis, up=[float(c) for c in other])


@pytest.mark.parametrize("size", [None, (2.5, 2), (-2, 2), 3])
def test_rays_are_of_whole_pixels(size: object) -> None:
    with pytest.raises(irt.ArgumentError, match="size"):
        irt.Camera((0, 0, 1)).rays(size)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"origin": (0, 0, 0)}, "same point"),
        ({"origin": (0, 3, 0)}, "parallel"),
        ({"origin": (0, 0, 1), "up": (0, 0, 0)}, "zero vector"),
        ({"origin": (0, 0, 1), "fov": 0}, "fov"),
        ({"origin": (0, 0, 1), "fov": 180}, "fov"),
        ({"origin": (0, 0, 1), "fov": "wide"}, "number"),
        ({"origin": (0, 0, math.nan)}, "finite"),
        ({"origin": (0, 0, 1e20)}, "1e15"),
        ({"origin": (0, 1)}, "three numbers"),
        ({"origin": (0, 0, 1), "projection": "fisheye"}, "projection"),
        ({"origin": (0, 0, 1), "projection": np.zeros(3)}, "projection"),
        ({"origin": (0, 0, 1), "height": -1}, "height"),
    ],
)
def test_degenerate_cameras_are_refused(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(irt.ArgumentError, match=words):
        irt.Camera(**arguments)  # type: ignore[arg-type]
