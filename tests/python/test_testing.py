"""The helpers for users' tests, and the renderer against Mitsuba 3."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt
from implicitrt.testing import assert_matches, mitsuba_frame

mi = pytest.importorskip("mitsuba", reason="Mitsuba is not installed; scripts/test installs it")
mi.set_variant("scalar_rgb")
SIZE = (64, 48)
CAMERA = irt.Camera((2.2, 1.7, 3.1), fov=35)


def _render(f: irt.Expr | str, **options: object) -> irt.Frame:
    return irt.render(f, camera=CAMERA, size=SIZE, eps=1e-5, **options)  # type: ignore[arg-type]


def test_missing_normals_and_open_pixels_do_not_match(tmp_path: Path) -> None:
    good = _render("x^2 + y^2 + z^2 - 1")
    for name, value in (("_normal", np.full_like(good.normal, np.nan)), ("status", np.full_like(good.status, irt.Status.UNRESOLVED))):
        worse = copy.copy(good)
        setattr(worse, name, value)
        with pytest.raises(AssertionError, match="pixels differ"):
            assert_matches(worse, good, save=tmp_path)


def test_tolerances_are_numbers_and_bands_may_be_wide() -> None:
    frame = _render("x^2 + y^2 + z^2 - 1")
    irt.testing.assert_matches(frame, frame, silhouette=100)
    for wrong in ({"depth": float("nan")}, {"normal": -1}):
        with pytest.raises(irt.ArgumentError, match="largest differences"):
            assert_matches(frame, frame, **wrong)


def test_sphere() -> None:
    assert_matches(_render("x^2 + y^2 + z^2 - 1"), mitsuba_frame({"s": {"type": "sphere"}}, CAMERA, SIZE))


def test_two_spheres() -> None:
    shapes = {
        "a": {"type": "sphere", "radius": 0.6, "center": [-0.5, 0, 0]},
        "b": {"type": "sphere", "radius": 0.5, "center": [0.6, 0.2, 0.3]},
    }
    f = "Min((x + 1/2)^2 + y^2 + z^2 - 0.36, (x - 0.6)^2 + (y - 0.2)^2 + (z - 0.3)^2 - 1/4)"
    assert_matches(_render(f), mitsuba_frame(shapes, CAMERA, SIZE))


def test_cylinder() -> None:
    shapes = {"c": {"type": "cylinder", "p0": [0, -0.8, 0], "p1": [0, 0.8, 0], "radius": 0.5}}
    box = ((-1, 1), (-0.8, 0.8), (-1, 1))
    assert_matches(_render("x^2 + z^2 - 1/4", bounds=box), mitsuba_frame(shapes, CAMERA, SIZE))


def test_cell_of_a_distance_grid() -> None:
    """Mitsuba interpolates trilinearly; in one cell that is a cubic polynomial, which we draw."""
    grid = np.array([[[-0.5, 0.3], [0.4, -0.2]], [[0.6, 0.1], [-0.3, 0.7]]], dtype=np.float32)  # [z, y, x]
    shape = {"type": "sdfgrid", "grid": mi.TensorXf(grid[..., None]), "normals": "analytic"}
    corners = [
        f"({float(grid[k, j, i])!r})*{'x' if i else '(1 - x)'}*{'y' if j else '(1 - y)'}*{'z' if k else '(1 - z)'}"
        for k in (0, 1) for j in (0, 1) for i in (0, 1)
    ]  # fmt: skip
    camera = irt.Camera((2.6, 2.1, 3.3), target=(0.5, 0.5, 0.5), fov=25)
    frame = irt.render(" + ".join(corners), bounds=((0, 1), (0, 1), (0, 1)), camera=camera, size=SIZE, eps=1e-5)
    assert_matches(frame, mitsuba_frame({"g": shape}, camera, SIZE), normal=2e-3, silhouette=2)


def test_torus_mesh_is_close(tmp_path: Path) -> None:
    n, m = 160, 80
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    ring = 0.9 + 0.35 * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), 0.35 * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    lines = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(points)}",
        "property float x",
        "property float y",
        "property float z",
    ]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_index", "end_header"]
    lines += [" ".join(f"{q:.9g}" for q in p) for p in points] + ["3 " + " ".join(map(str, f)) for f in faces]
    (tmp_path / "torus.ply").write_text("\n".join(lines) + "\n")
    reference = mitsuba_frame({"t": {"type": "ply", "filename": str(tmp_path / "torus.ply")}}, CAMERA, SIZE)
    frame = _render("(x^2 + y^2 + z^2 + 0.81 - 0.1225)^2 - 3.24*(x^2 + y^2)")
    assert_matches(frame, reference, depth=2e-2, normal=None, silhouette=2, allowed=10)


def test_failures_say_what_differs_and_leave_pictures(tmp_path: Path) -> None:
    reference = mitsuba_frame({"s": {"type": "sphere", "radius": 0.99}}, CAMERA, SIZE)
    with pytest.raises(AssertionError, match=r"pixels differ.*\n.*depth: \d+, worst by 0.0"):
        assert_matches(_render("x^2 + y^2 + z^2 - 1"), reference, save=tmp_path / "m")
    assert sorted(p.name for p in (tmp_path / "m").iterdir()) == ["difference.png", "frame.png", "reference.png"]


def test_grids_that_mitsuba_gets_wrong_are_refused() -> None:
    shape = {"type": "sdfgrid", "grid": mi.TensorXf(np.zeros((2, 2, 3, 1), dtype=np.float32))}
    with pytest.raises(irt.ArgumentError, match="cubic"):
        mitsuba_frame({"g": shape}, CAMERA, SIZE)
