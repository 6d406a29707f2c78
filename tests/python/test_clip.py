"""Clip regions: half-spaces and formulas, against the reference and where rounding decides."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from formulas import check, formula

import implicitrt as irt
from implicitrt import Clip, HalfSpace, Sphere, Status
from implicitrt.bounds import Bounds
from implicitrt.cli import main

SPHERE = "x^2 + y^2 + z^2 - 1"
METHODS = ["ia", "raa", "contract", "mitchell"]
CAMERA = irt.Camera((1.9, 1.4, 3.2))

# Formula, bounds, parameters.
SCENES: list[tuple[Any, list[Any], dict[str, float]]] = [
    (SPHERE, [2, HalfSpace((1, 1, 0), 0.3)], {}),
    (SPHERE, [Sphere((0, 0, 0), 1.5), HalfSpace((0, 0, 3), 0.5), HalfSpace((-0.3, 1e-20, 0), 0.2)], {}),
    (SPHERE, [2, Clip("x + y - z/3 - h")], {"h": 0.1}),
    (SPHERE, [2, Clip("x*y*z"), Clip("a^2 - (x - 1)^2 - y^2 - z^2")], {"a": 0.6}),
    ("x^2 + y^2 + z^2 + sin(4x) + sin(4y) + sin(4z) - 1", [2.1, Clip("z - 0.1"), HalfSpace((1, 0, 0), 0.5)], {}),
    ("x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 2/5", [1.5, Clip("Abs(x - z) - 1/2"), Sphere((0, 0, 0), 1.2)], {}),
    ("sqrt(x^2 + y^2) - 1 + z^2/4", [2, Clip("log(z + 1)")], {}),  # undefined below z = -1
    ("(z - a)*(x - a)", [2, Clip("sign(x - y)*z")], {"a": 0.125}),
    (SPHERE, [2, Clip("1/x")], {}),
]


@pytest.mark.parametrize("scene", SCENES, ids=range(len(SCENES)))
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("precision", ["single", "double"])
def test_statuses_are_honest(scene: tuple[Any, Any, dict[str, float]], method: str, precision: str) -> None:
    f, bounds, params = scene
    call = {"bounds": bounds, "camera": CAMERA, "size": (40, 30), "params": params}
    truth = irt.reference(f, **call)
    frame = irt.render(f, **call, method=method, precision=precision)
    assert truth.hit.sum() > 20 and (truth.kind == Status.MISS).sum() > 20
    assert (truth.kind == Status.UNRESOLVED).mean() < 0.02
    assert not ((truth.kind == Status.MISS) & (frame.status == Status.HIT)).any()
    assert not (truth.hit & (frame.status == Status.MISS)).any()
    proven = (frame.status == Status.HIT) & truth.hit
    assert (np.abs(frame.depth[proven] - truth.depth[proven]) <= (frame.uncertainty + truth.uncertainty)[proven]).all()
    assert proven.sum() > 0.9 * truth.hit.sum()
    fast = irt.render(f, **call, method=method, precision=precision, rounding="fast")
    assert (fast.hit == truth.hit).mean() > 0.98


@pytest.mark.parametrize("seed", range(0, 2000, 367))
def test_random_formulas_clipped_by_random_formulas(seed: int) -> None:
    bounds = [1.5, Clip(formula(seed + 1)), HalfSpace((seed % 5 - 2, 1, seed % 3 - 1), 0.75)]
    counts = check(formula(seed), 100, seed, tuple(METHODS), (1e-2, 1e-5), bounds)
    for c in counts.values():
        assert c["undecided"] > 0 or c["hits"] >= 0.95 * c["simple"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("kind", ["half-space", "clip"])
def test_roots_at_the_boundary(method: str, precision: str, kind: str) -> None:
    """A root just outside the region is no hit, and one just inside no miss, however rounding falls."""
    rng = np.random.default_rng(7)
    decided = 0
    for _ in range(8):
        off = float(rng.choice([-1, 1]) * 10.0 ** rng.uniform(-17, -3))
        place = rng.uniform(-1, 1, 3)
        normal = rng.normal(size=3)
        offset = float(normal @ place) + off
        direction = rng.normal(size=3)
        o = place - rng.uniform(0.1, 100) * direction + np.zeros((64, 1))
        d = place + rng.normal(size=(64, 3)) * 1e-7 - o
        call: dict[str, Any] = {"params": {"p": float(place[0])}, "bounds": [3, HalfSpace(normal, offset)]}
        if kind == "clip":
            call["bounds"] = [3, Clip("a*x + b*y + c*z - d")]
            call["params"] |= dict(zip("abcd", [*normal.tolist(), offset], strict=True))
        truth = irt.reference("x - p", o, d, **call)
        found = irt.trace("x - p", o, d, method=method, precision=precision, eps=1e-6, **call)
        assert not ((truth.kind == Status.MISS) & (found.status == Status.HIT)).any()
        assert not (truth.hit & (found.status == Status.MISS)).any()
        decided += int((truth.kind != Status.UNRESOLVED).sum())
        # Rays inside the boundary plane, or nearly.
        along = np.cross(normal, direction) + rng.choice([0, 1e-9], (64, 1)) * rng.normal(size=(64, 3))
        truth = irt.reference("x - p", o, along, **call)
        found = irt.trace("x - p", o, along, method=method, precision=precision, **call)
        assert not ((truth.kind == Status.MISS) & (found.status == Status.HIT)).any()
        assert not (truth.hit & (found.status == Status.MISS)).any()
    assert decided > 300


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rounding", ["outward", "fast"])
def test_the_march_goes_on_behind_a_root_that_does_not_count(device: str, method: str, rounding: str) -> None:
    call: dict[str, Any] = {"method": method, "rounding": rounding, "device": device, "eps": 1e-4}
    through = irt.trace(SPHERE, (0.1, 0.2, 3), (0, 0, -1), bounds=[2, Clip("z")], **call)
    assert through.status[0] == Status.HIT and through.t[0] == pytest.approx(3 + 0.95**0.5, abs=1e-3)
    assert irt.trace(SPHERE, (0.1, 0.2, 3), (0, 0, -1), bounds=[2, HalfSpace((0, 0, 1), 0)], **call).t[
        0
    ] == pytest.approx(through.t[0], abs=2e-4)
    assert irt.trace(SPHERE, (0.1, 0.2, 3), (0, 0, -1), bounds=[2, Clip("x")], **call).status[0] == Status.MISS


def test_a_root_on_the_boundary_is_a_touch() -> None:
    """Whether g <= 0 there cannot be proven, and that it is not cannot either."""
    for method in METHODS:
        assert (
            irt.trace("z - x", (0.5, 0.1, 2), (0, 0, -1), bounds=[3, Clip("z - x")], method=method).status[0]
            == Status.TOUCH
        )
    assert irt.reference("z - x", (0.5, 0.1, 2), (0, 0, -1), bounds=[3, Clip("z - x")]).kind[0] == Status.UNRESOLVED


def test_a_clip_that_is_zero_counts() -> None:
    call: dict[str, Any] = {"bounds": [2, Clip("Max(x, 0)")], "camera": CAMERA, "size": (24, 18)}
    truth = irt.reference(SPHERE, **call)
    assert truth.hit.sum() > 20 and (truth.kind != Status.UNRESOLVED).all()
    for method in METHODS:
        frame = irt.render(SPHERE, **call, method=method)
        assert np.array_equal(frame.hit, truth.hit) and (frame.status[truth.hit] == Status.HIT).mean() > 0.9


def test_moving_a_region_compiles_nothing() -> None:
    call: dict[str, Any] = {"camera": CAMERA, "size": (32, 24)}
    first = irt.render(SPHERE, bounds=[2, HalfSpace((1, 1, 0), 0.3), Clip("x - h")], params={"h": 0.1}, **call)
    second = irt.render(SPHERE, bounds=[3, HalfSpace((0, 2, 1), 0.9), Clip("x - h")], params={"h": 0.5}, **call)
    assert second.stats.builds == 0 and second.hit.sum() > first.hit.sum() > 0
    assert second.params == {"h": 0.5} and second.bounds.half_spaces[0].offset == 0.9


def test_renaming_parameters_compiles_nothing() -> None:
    """Names are no part of a kernel's source: symbols are numbered."""
    builds = []
    for a, h in (("gap", "hue"), ("quux", "secret_name")):
        call: dict[str, Any] = {"bounds": [2, Clip(f"x - 3*{h}")], "params": {a: 0.5, h: 0.1}, "size": (8, 8)}
        builds.append(irt.render(f"x*y + {a}*z + 1/7", method="contract", **call).stats.builds)
        source = irt.kernel_source(f"x*y + {a}*z + 1/7", method="contract", bounds=call["bounds"])
        assert a not in source and h not in source
    assert builds == [1, 0]


def test_kernels_hold_only_the_regions_in_use() -> None:
    plain = irt.kernel_source(SPHERE)
    assert "*outside" not in plain.split("enclosure_")[0] and "#define IRT_HALF_SPACES 0" in plain
    cut = irt.kernel_source(SPHERE, bounds=[2, Clip("sin(x) - h"), HalfSpace((1, 0, 0), 0)])
    assert "ia_sin" in cut and "bounds of parameter 0" in cut and "#define IRT_HALF_SPACES 1" in cut


def test_bounds_with_regions() -> None:
    region = Bounds.of([2, HalfSpace((0, 0, 2), 1), Clip("x - y"), Clip("x - y"), Clip("z")])
    assert region.upper == (2.0, 2.0, 2.0) and len(region.clips) == 3
    assert region.clip == irt.Max(irt.parse("x - y"), irt.z)
    assert Bounds.of([region, 1]).half_spaces == region.half_spaces
    assert "HalfSpace(normal=(0.0, 0.0, 2.0), offset=1.0)" in repr(region) and "Clip(g=z)" in repr(region)
    assert HalfSpace((0, 0, 12), 6).scaled() == (0, 0, 1.5, 0.75)


@pytest.mark.parametrize("value", [HalfSpace((1, 0, 0), 1), Clip("x"), [HalfSpace((1, 0, 0), 1), Clip("x")]])
def test_unbounded_regions_are_refused(value: Any) -> None:
    with pytest.raises(irt.ArgumentError, match="infinite"):
        irt.render(SPHERE, bounds=value)


@pytest.mark.parametrize(
    ("normal", "offset"), [((0, 0, 0), 1), ((1, 0), 1), ((1, 0, float("nan")), 1), ((1, 0, 0), "x"), ((1, 0, 0), 1e16)]
)
def test_bad_half_spaces_are_refused(normal: Any, offset: Any) -> None:
    with pytest.raises(irt.ArgumentError, match="half-space"):
        HalfSpace(normal, offset)


def test_bad_clips_are_refused() -> None:
    with pytest.raises(irt.ExpressionError):
        Clip("x <")
    with pytest.raises(irt.ArgumentError, match="'h' has no value"):
        irt.render(SPHERE, bounds=[2, Clip("x - h")])


def test_methods_that_know_no_clip_refuse_it(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = sys.modules["implicitrt.methods"].ENTRIES
    deaf = {**entries, "contract": dataclasses.replace(entries["contract"], clips=False)}
    monkeypatch.setattr(sys.modules["implicitrt.request"], "ENTRIES", deaf)
    monkeypatch.setattr(sys.modules["implicitrt.methods"], "ENTRIES", deaf)
    with pytest.raises(irt.MethodError, match="contract knows boxes"):
        irt.render(SPHERE, bounds=[2, Clip("x")], method="contract")
    assert irt.render(SPHERE, bounds=[2, HalfSpace((1, 0, 0), 0)], method="contract", size=(16, 16)).hit.any()


def test_compare_and_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = irt.compare(
        SPHERE, METHODS, eps=1e-2, size=(24, 24), runs=1, bounds=[2, Clip("x - 1/4"), HalfSpace((0, 1, 0), 0.5)]
    )
    assert all(p.wrong_misses == p.wrong_hits == 0 for p in found) and len(found) == len(METHODS)
    arguments = ["render", SPHERE, "-o", str(tmp_path / "a.npz"), "--size", "32", "--camera", "0,0,4"]
    regions = ["2", "sphere:0,0,0,1.5", "halfspace:1,0,0,0", "clip:y-h"]
    assert main([*arguments, "--param", "h=0", *(word for r in regions for word in ("--bounds", r))]) == 0
    hit = np.isfinite(np.load(tmp_path / "a.npz")["depth"])
    assert hit[16:, :16].any() and not hit[:15].any() and not hit[:, 17:].any()
    capsys.readouterr()
    for text, words in (
        ("halfspace:1,0", "no bounds"),
        ("clip:x", "infinite"),
        ("1,2", "no bounds"),
        ("clip:sen(x)", "sin"),
    ):
        assert main([*arguments, "--bounds", text]) == 1
        assert words in capsys.readouterr().err


@pytest.mark.parametrize("method", ["contract", "raa", "ia", "frustum-newton"])
def test_rays_within_a_plane_of_the_bounds_count(method: str) -> None:
    half = [2.0, HalfSpace((1, 0, 0), 0)]
    sphere = irt.trace(SPHERE, [(0, 0, 5), (0.5, 0, 5), (-0.5, 0, 5)], (0, 0, -1), bounds=half, method=method)
    assert [Status(s) != Status.MISS for s in sphere.status] == [True, False, True]
    plane = irt.trace("z", [(0, 0, 5), (2, 0, 5), (2.001, 0, 5)], (0, 0, -1), bounds=2, method=method)
    assert [Status(s) != Status.MISS for s in plane.status] == [True, True, False]


@pytest.mark.parametrize("method", ["contract", "frustum-newton"])
@pytest.mark.parametrize(
    "bounds",
    [
        Sphere((0.1, 0.2, 0.3), 1.37),
        [Sphere((0.3, 0.1, 0), 1.2), 3.0],  # the ball lies in the box
        [Sphere((0.3, 0.1, 0), 1.2), 1.0],  # and here it does not
        [16.0, HalfSpace((0, 0, 1), 1.1), HalfSpace((0, 0, -1), 0.9)],  # no pixel reaches the box
    ],
)
def test_boxes_that_cut_nothing_and_boxes_that_do(bounds: Any, method: str) -> None:
    f = irt.surfaces["barth_sextic"].expr
    view = {"bounds": bounds, "camera": irt.Camera((0.3, 0.2, 6), target=(0, 0, 0), fov=30), "size": (40, 40)}
    frame, truth = irt.render(f, method=method, eps=1e-4, **view), irt.reference(f, **view)
    assert truth.hit.sum() > 40 and (truth.kind == Status.MISS).sum() > 40
    proven = (frame.status == Status.HIT) & truth.hit
    assert not ((truth.kind == Status.MISS) & (frame.status == Status.HIT)).any()
    assert not (truth.hit & (frame.status == Status.MISS)).any() and proven.sum() > 0.95 * truth.hit.sum()
    assert (np.abs(frame.depth[proven] - truth.depth[proven]) <= (frame.uncertainty + truth.uncertainty)[proven]).all()


@pytest.mark.parametrize("method", [m for m in irt.methods() if m.startswith("frustum-")])
def test_batches_of_rays_are_clipped_by_formulas(method: str) -> None:
    rng = np.random.default_rng(5)
    through, direction = rng.uniform(-1, 1, (120, 3)), rng.normal(size=(120, 3)) * 2.0 ** rng.integers(-8, 9, (120, 1))
    call = {"bounds": [1.6, Clip("x + y*z - k")], "params": {"k": 0.1}}
    near = np.where(rng.random(120) < 0.2, 1.0, 0.0)
    origin = through - 2 * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    hits = irt.trace("x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 0.4", origin, direction, tmin=near, method=method, eps=1e-4, **call)
    truth = irt.reference("x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 0.4", origins=origin, directions=direction, tmin=near, **call)
    whole = irt.trace("x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 0.4", origin, direction, tmin=near, method=method, bounds=1.6)
    assert truth.hit.sum() > 20 and (hits.hit != whole.hit).any()
    assert not (truth.hit & (hits.status == Status.MISS)).any() and not ((truth.kind == Status.MISS) & (hits.status == Status.HIT)).any()
    found = truth.hit & (hits.status == Status.HIT)
    assert found.sum() > 0.95 * truth.hit.sum()
    assert (np.abs(hits.t - truth.depth)[found] <= (hits.uncertainty + truth.uncertainty)[found]).all()
    assert np.isfinite(hits.normal[found]).all()
