"""irt.reference against certified depth maps and probes, and its arguments."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Status


@pytest.mark.parametrize("name", list(irt.surfaces))
def test_depth_map(name: str, data: Path) -> None:
    depth = np.load(data / "reference_depth_32.npz")[name]
    found = irt.reference(irt.surfaces[name], size=(32, 32))
    assert (found.kind != Status.UNRESOLVED).all()
    assert (found.hit == np.isfinite(depth)).all()
    # The maps themselves are good to about 1e-12, relative.
    assert np.allclose(found.depth, depth, rtol=2e-12, atol=1e-11)
    assert (found.kind[found.hit] == (Status.TOUCH if name == "double_plane" else Status.HIT)).all()


@pytest.mark.parametrize("name", list(irt.surfaces))
def test_probes(name: str, data: Path) -> None:
    probes = json.loads((data / "probes.json").read_text())[name]
    found = irt.reference(irt.surfaces[name], [p["origin"] for p in probes], [p["direction"] for p in probes])
    for i, probe in enumerate(probes):
        if probe["kind"] == "miss":
            assert found.kind[i] == Status.MISS
        else:
            assert found.hit[i] and abs(found.depth[i] - probe["t"]) <= 1e-11 * probe["t"]


@pytest.mark.parametrize(("f", "kind"), [("x^2 + y^2 + z^2 - 1", irt.Status.HIT), ("(x + y + z - 1)^2", irt.Status.TOUCH)])
def test_a_root_at_the_start_counts(f: str, kind: irt.Status) -> None:
    """And in frames by every way, whatever the rest of the ray meets."""
    for direction in ((0, 0, 1), (0.25, 0.5, -1)):
        truth = irt.reference(f, (0, 0, 1), direction, bounds=2)
        assert truth.kind == kind and truth.depth == 0
    frame = irt.render(f, bounds=2, camera=irt.Camera((0, 0, 1)), size=(16, 16))
    assert frame.hit.all() and np.abs(frame.depth).max() < 1e-3


def test_brackets_near_the_start_of_a_ray() -> None:
    # Doubles find this root to 7e-14 only, and wanted is 1e-12 of its small t: more bits have to halve what is left.
    f = "x^4 + y^4 + z^4 - 1.2 x^2 - 0.3 y + 0.1"
    found = irt.reference(f, (0.2, 0.1, 0.3), [(1, 0, 0), (0, 1, 0), (1, 0.3, 0.2)], bounds=2)
    assert (found.kind == Status.HIT).all()
    assert (np.diff(found.bracket)[:, 0] <= 1.5e-12 * found.depth).all()


def test_both_forms_of_call() -> None:
    camera = irt.Camera((0, 0, 5))
    picture = irt.reference("x^2 + y^2 + z^2 - 1", 2, camera, (5, 4), eps=1e-3, method="raa")
    assert picture.kind.shape == (4, 5) and picture.bracket.shape == (4, 5, 2)
    o, d = camera.rays((5, 4))
    batch = irt.reference("x^2 + y^2 + z^2 - 1", o.reshape(-1, 3), d.reshape(-1, 3), bounds=2)
    assert (batch.depth == picture.depth.ravel()).all()
    axis = irt.reference("x^2 + y^2 + z^2 - 1", (0, 0, 5), (0, 0, -2), bounds=2)
    assert axis.depth[0] == pytest.approx(2, abs=1e-12) and axis.precision[0] == "double"
    assert len(irt.reference("x", np.zeros((0, 3)), np.zeros((0, 3)), bounds=1).kind) == 0


def test_parameters_and_isovalue() -> None:
    found = irt.reference("a x^2 + y^2 + z^2", (0, 0, 5), (0, 0, -1), bounds=4, params={"a": 1}, isovalue=4)
    assert found.depth[0] == pytest.approx(3, abs=1e-12)
    with pytest.raises(irt.ArgumentError, match="'a'"):
        irt.reference("a x^2 + y^2 + z^2", (0, 0, 5), (0, 0, -1), bounds=4)


def test_clips_to_balls() -> None:
    ball = irt.Sphere((0, 0, 0), 1)
    assert irt.reference("z - 1/2", (0.1, 0.2, 5), (0, 0, -1), bounds=ball).depth[0] == pytest.approx(4.5, abs=1e-12)
    assert irt.reference("z - 1/2", (0.9, 0.2, 5), (0, 0, -1), bounds=ball).kind[0] == Status.MISS
    assert irt.reference("z - 1/2", (2, 0, 5), (0, 0, -1), bounds=ball).kind[0] == Status.MISS


def test_the_limits_of_a_ray_count() -> None:
    sphere = "x^2 + y^2 + z^2 - 1"
    inside = irt.reference(sphere, (0, 0, 5), (0, 0, -1), tmin=4.5, bounds=2)
    assert inside.depth[0] == pytest.approx(6, abs=1e-11)
    assert irt.reference(sphere, (0, 0, 5), (0, 0, -1), tmax=3.9).kind[0] == Status.MISS


def test_undecided_says_where() -> None:
    found = irt.reference("sin(z)^2", (0.1, 0.1, -1), (0, 0, 1), bounds=2)
    assert found.kind[0] == Status.UNRESOLVED and found.precision[0] == "mpfr"
    assert found.bracket[0, 0] <= 1 <= found.bracket[0, 1] and np.ptp(found.bracket[0]) < 1e-11
    assert found.depth[0] == found.bracket[0, 0] and math.isnan(found.uncertainty[0])
    assert "1 UNRESOLVED" in repr(found)


def test_time_limit_and_progress() -> None:
    seen: list[float] = []
    found = irt.reference(irt.surfaces["superquadric_200"], size=(64, 64), time_limit=0.2, progress=seen.append)
    assert (found.precision == "none").any() and seen and found.seconds < 5
    unseen = found.precision == "none"
    assert (found.kind[unseen] == Status.UNRESOLVED).all() and (found.bracket[unseen] == (0, np.inf)).all()

    def stop(fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        irt.reference(irt.surfaces["superquadric_200"], size=(64, 64), progress=stop)


@pytest.mark.parametrize("f", ["(x^3 - y*z)^66 - z^2", "(x^2 + y^2 + z^2 - 1)^99", "sin(40 x y)^2 + (z - sin(30 x))^2 + x^40/10^60"])
def test_the_time_limit_stops_a_single_ray(f: str) -> None:
    """Of a degree whose exact coefficients have thousands of digits, or with pieces by the hundred thousand."""
    direction = (0.713, -0.211, 0.6691)
    found = irt.reference(f, [np.multiply(direction, -2) + (0.1, k / 64, -0.2) for k in range(8)], direction, bounds=1.2, time_limit=0.2)
    assert found.seconds < 3
    unseen = found.precision == "none"
    assert (found.kind[unseen] == Status.UNRESOLVED).all() and (found.bracket[unseen] == (0, np.inf)).all()
    # One ray among others that are done at once, whoever has it.
    rays = [(3, 3, 3)] * 64
    for slow in (0, 40):
        rays[slow] = tuple(np.multiply(direction, -2) + (0.1, 0, -0.2))
        assert irt.reference(f, rays, direction, bounds=1.2, time_limit=0.2).seconds < 3
        rays[slow] = (3, 3, 3)


@pytest.mark.parametrize(
    ("f", "kind"),
    [
        ("(2305843009213693951 x - 1/3)^2 (x - 1/2)", Status.TOUCH),  # all of the leading coefficient is a multiple of the prime that tells multiple roots from others
        ("(2305843009213693951 x - 1) (x - 1/2)", Status.HIT),
        ("(x - 1/3)^2 (x^2 + 1)/2305843009213693951", Status.TOUCH),
        ("(3 x^2 - 1)^3 (x - 3/4)", Status.HIT),
        ("(3 x^2 - 1)^2 (x - 3/4)", Status.TOUCH),
        ("((x - 1/3)^2 + 1/10^20) (x - 3/4)", Status.HIT),
    ],
)
def test_multiple_roots_are_told_from_close_ones(f: str, kind: Status) -> None:
    found = irt.reference(f, (-0.8, 0, 0), (1, 0, 0), bounds=1)
    assert found.kind[0] == kind


@pytest.mark.parametrize(
    ("arguments", "keywords"),
    [
        (("x", (0, 0, 1)), {}),
        (("x", (0, 0, 1), (0, 0, 0)), {"bounds": 1}),
        (("x", (0, 0, 1), (0, 0, 1)), {}),
        (("x",), {"origins": (0, 0, 1)}),
        (("x",), {"nonsense": 1}),
        (("x",), {"isovalue": "a"}),
        (("x",), {"isovalue": math.nan}),
        (("x",), {"time_limit": "soon"}),
        (("x",), {"time_limit": 0}),
        (("x",), {"progress": 5}),
        (("x",), {"tmin": 1}),
        (("x", (0, 0, 1), (0, 0, -1)), {"bounds": 1, "camera": irt.Camera((0, 0, 1))}),
        (("x", 2, None, (4, 4), 5), {}),
    ],
)
def test_bad_arguments(arguments: tuple[object, ...], keywords: dict[str, object]) -> None:
    with pytest.raises(irt.ArgumentError):
        irt.reference(*arguments, **keywords)
