"""Normals from neighbouring points, and anti-aliasing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Status

SPHERE = "x^2 + y^2 + z^2 - 1"
CAMERAS = [
    irt.Camera((1.9, 1.4, 3.2)),
    irt.Camera((1.9, 1.4, 3.2), projection="orthographic", height=2.5),
    irt.Camera((1900, 1400, 3200), fov=0.05),
]


def _degrees(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between unit vectors, through the chord, which loses no digits."""
    return np.degrees(2 * np.arcsin(np.minimum(0.5 * np.linalg.norm(a.astype(float) - b, axis=-1), 1)))


@pytest.mark.parametrize("camera", CAMERAS, ids=["near", "orthographic", "far"])
@pytest.mark.parametrize("precision", ["single", "double", "auto"])
def test_neighbours_agree_with_the_gradient(device: str, camera: irt.Camera, precision: str) -> None:
    call: dict[str, Any] = {"camera": camera, "size": (161, 120), "eps": 1e-6, "precision": precision, "device": device}
    by_gradient = irt.render(SPHERE, **call)
    frame = irt.render(SPHERE, **call, normals="neighbours")
    for name in ("depth", "status", "uncertainty"):
        assert np.array_equal(getattr(frame, name), getattr(by_gradient, name), equal_nan=True)
    assert np.array_equal(np.isnan(frame.normal), np.isnan(by_gradient.normal))
    hit = frame.hit
    angle = _degrees(frame.normal[hit], by_gradient.normal[hit])
    # A float's depth is only so good from far away.
    assert np.median(angle) < (0.2 if camera is CAMERAS[2] and precision == "single" else 0.05) and angle.max() < 12
    assert np.abs(np.linalg.norm(frame.normal[hit], axis=-1) - 1).max() < 1e-5
    assert np.abs(frame.rgb.astype(int) - by_gradient.rgb).max() < 16
    assert not np.array_equal(frame.normal[hit], by_gradient.normal[hit])


def test_neighbours_of_a_plane_are_exact() -> None:
    normal = np.array([0.48, 0.36, 0.8])
    frame = irt.render("0.48x + 0.36y + 0.8z - 0.1", camera=CAMERAS[0], size=(64, 48), eps=1e-7, normals="neighbours")
    assert frame.hit.sum() > 1000
    assert _degrees(frame.normal[frame.hit], np.broadcast_to(normal, frame.normal.shape)[frame.hit]).max() < 0.1


def test_neighbours_behind_a_silhouette_are_not_taken() -> None:
    """A ball before a plane: no normal mixes the two, and pixels without help have the gradient's."""
    scene, call = "Min(x^2 + y^2 + (z - 1)^2 - 1/4, z + 1)", {"camera": irt.Camera((0.4, 0.3, 6)), "size": (97, 73)}
    by_gradient = irt.render(scene, **call, eps=1e-6)
    frame = irt.render(scene, **call, eps=1e-6, normals="neighbours")
    ball = by_gradient.hit & (by_gradient.points[..., 2] > 0)
    plane = by_gradient.hit & ~ball
    assert ball.sum() > 100 and plane.sum() > 1000
    assert _degrees(frame.normal, by_gradient.normal)[ball].max() < 20  # one-sided at the rim, where it curves away
    assert _degrees(frame.normal, by_gradient.normal)[plane].max() < 0.1
    alone = irt.render(scene, camera=call["camera"], size=(1, 1), normals="neighbours")
    assert np.abs(alone.normal - irt.render(scene, camera=call["camera"], size=(1, 1)).normal).max() < 1e-6


def test_neighbours_converge_with_the_square_of_a_pixel() -> None:
    """Differences are central: half a pixel, a quarter of the error."""
    medians = []
    for width in (80, 160, 320):
        call: dict[str, Any] = {
            "camera": CAMERAS[0],
            "size": (width, 3 * width // 4),
            "eps": 1e-9,
            "precision": "double",
        }
        by_gradient = irt.render("x^4 + y^4 + z^4 - 1", **call)
        frame = irt.render("x^4 + y^4 + z^4 - 1", **call, normals="neighbours")
        medians.append(np.median(_degrees(frame.normal, by_gradient.normal)[frame.hit]))
    assert medians[0] < 1 and medians[0] > 3 * medians[1] > 9 * medians[2]


def test_neighbours_compile_nothing_for_new_parameters() -> None:
    call: dict[str, Any] = {"size": (48, 36), "normals": "neighbours", "antialias": "silhouette"}
    irt.render("x^2 + y^2 + z^2 - a", params={"a": 1}, **call)
    frame = irt.render("x^2 + y^2 + z^2 - a", params={"a": 1.5}, **call)
    assert frame.stats.builds == 0 and frame.hit.any()


def test_neighbours_keep_what_is_open() -> None:
    frame = irt.render(SPHERE, size=(32, 24), normals="neighbours", max_pieces=1, unresolved_color="magenta", method="raa")
    assert (frame.status == Status.UNRESOLVED).any()
    assert (frame.rgb[frame.status == Status.UNRESOLVED] == (255, 0, 255)).all()
    late = irt.render(SPHERE, size=(64, 64), time_limit=1e-9, normals="neighbours", antialias=2)
    assert late.normal.shape == (64, 64, 3) and late.stats.counts["UNRESOLVED"] > 4000


# Anti-aliasing ---------------------------------------------------------------------------------

FLAT = irt.Camera((0, 0, 5), projection="orthographic", height=2)


def _linear(v: np.ndarray) -> np.ndarray:
    c = v / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def _bytes(v: np.ndarray) -> np.ndarray:
    return np.round(255 * np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 0) ** (1 / 2.4) - 0.055))


@pytest.mark.parametrize("antialias", [1, 2, 3, 4, "silhouette"])
def test_coverage_of_a_straight_edge(antialias: int | str) -> None:
    """A square of z = 0 whose right edge moves through a pixel: alpha and light are what the samples say."""
    n = 4 if antialias == "silhouette" else int(antialias)
    for k, edge in enumerate(np.linspace(0.01, 0.99, 8)):
        x = (10 + edge) * 0.1 - 1  # in the eleventh of 20 columns, each 0.1 wide
        call: dict[str, Any] = {"bounds": ((-3, x), (-3, 3), (-1, 1)), "camera": FLAT, "size": (20, 20)}
        clear = irt.render("z", **call, antialias=antialias, background=None)
        inside = ((np.arange(n) + 0.5) / n < edge).mean()
        assert np.abs(clear.rgba[:, 10, 3] - 255 * inside).max() <= 0.5
        assert (clear.rgba[:, :10, 3] == 255).all() and (clear.rgba[:, 11:, 3] == 0).all()
        surface = clear.rgb[:, :10].astype(int)
        if inside > 0:  # a colour that alpha dims no more
            assert np.abs(clear.rgb[:, 10] - surface[:, 9]).max() <= 2
        solid = irt.render("z", **call, antialias=antialias, background="#204080")
        expected = inside * _linear(clear.rgb[:, 10].astype(float)) + (1 - inside) * _linear(np.array([32.0, 64, 128]))
        assert np.abs(solid.rgb[:, 10] - _bytes(expected)).max() <= 1, k


@pytest.mark.parametrize("normals", ["gradient", "neighbours"])
@pytest.mark.parametrize("precision", ["single", "auto"])
def test_antialias_changes_colours_alone(device: str, normals: str, precision: str) -> None:
    region = [1.5, irt.Clip("x + y/2 - 1/4")]
    call: dict[str, Any] = {
        "bounds": region, "camera": CAMERAS[0], "size": (81, 60), "normals": normals, "device": device, "precision": precision,
    }  # fmt: skip
    plain = irt.render(SPHERE, **call)
    rims = irt.render(SPHERE, **call, antialias="silhouette")
    every = irt.render(SPHERE, **call, antialias=4)
    for frame in (rims, every):
        for name in ("depth", "status", "uncertainty", "normal"):
            assert np.array_equal(getattr(frame, name), getattr(plain, name), equal_nan=True)
        assert frame.stats.counts == plain.stats.counts
    changed = (rims.rgb != plain.rgb).any(axis=-1)
    assert 50 < changed.sum() < 0.2 * changed.size
    # It changes no pixel whose eight neighbours are all of the same kind and about as deep.
    kind = np.pad(plain.hit, 1, mode="edge")
    depth = np.pad(np.where(plain.hit, plain.depth, 0), 1, mode="edge")
    rows, columns = plain.hit.shape
    interior = np.ones(plain.hit.shape, dtype=bool)
    for i in range(3):
        for j in range(3):
            interior &= kind[i : i + rows, j : j + columns] == plain.hit
            interior &= np.abs(depth[i : i + rows, j : j + columns] - depth[1:-1, 1:-1]) < 0.05
    assert interior.sum() > 3000 and not changed[interior].any()
    if normals == "gradient":  # where it does, its samples are those of antialias=4
        assert np.array_equal(rims.rgb[changed], every.rgb[changed])
    assert np.abs(every.rgb.astype(int) - plain.rgb)[interior].max() < 24


def test_antialias_is_idempotent_where_all_samples_agree() -> None:
    flat = irt.render("z", bounds=2, camera=FLAT, size=(16, 16), antialias=5)
    assert np.array_equal(flat.rgba, irt.render("z", bounds=2, camera=FLAT, size=(16, 16)).rgba)
    empty = irt.render("z - 9", bounds=2, camera=FLAT, size=(16, 16), antialias=2, background=None)
    assert not empty.rgba.any()
    assert irt.render("z", bounds=2, camera=FLAT, size=(16, 16), antialias=3, outputs=()).hit.all()


@pytest.mark.parametrize(
    ("keyword", "value"),
    [("antialias", v) for v in ("rims", 0, -1, 17, 2.5, True)] + [("normals", v) for v in ("neighbors", None)],
)
def test_bad_arguments_are_refused(keyword: str, value: Any) -> None:
    with pytest.raises(irt.ArgumentError, match=f"{keyword} must be"):
        irt.render(SPHERE, **{keyword: value})
