"""render and trace: geometry, statuses, outputs, parameters, errors."""

from __future__ import annotations

import math
import threading
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Status

SPHERE = "x^2 + y^2 + z^2 = 1"


def _sphere_depth(camera: irt.Camera, size: tuple[int, int]) -> np.ndarray:
    origins, directions = camera.rays(size)
    b = (origins * directions).sum(axis=2)
    c = (origins**2).sum(axis=2) - 1
    root = b * b - c
    return np.where(root >= 0, -b - np.sqrt(np.maximum(root, 0)), np.inf)


@pytest.mark.parametrize("method", ["ia", "raa", "contract", "mitchell"])
@pytest.mark.parametrize("rounding", ["outward", "fast"])
def test_sphere(device: str, method: str, rounding: str) -> None:
    camera = irt.Camera((2, 1.5, 3))
    frame = irt.render(SPHERE, camera=camera, size=(61, 45), method=method, rounding=rounding, eps=1e-4, device=device)
    expected = _sphere_depth(camera, (61, 45))
    both = np.isfinite(frame.depth) & np.isfinite(expected)
    assert (np.isfinite(frame.depth) == np.isfinite(expected)).mean() > 0.998
    assert np.abs(frame.depth - expected)[both].max() < 2e-3  # grazing rays
    assert np.median(np.abs(frame.depth - expected)[both]) < 1e-4
    assert frame.rgb.shape == (45, 61, 3) and frame.rgb.dtype == np.uint8
    assert frame.normal.shape == (45, 61, 3) and frame.normal.dtype == np.float32
    assert np.abs(frame.normal - frame.points)[frame.hit].max() < 5e-3
    assert frame.stats.proven == (rounding == "outward")
    if rounding == "outward":
        hit = frame.status == Status.HIT
        assert (np.abs(frame.depth - expected)[hit] <= frame.uncertainty[hit]).all()
        assert not np.isfinite(expected[frame.status == Status.MISS]).any()
    else:
        assert np.isnan(frame.uncertainty).all()


@pytest.mark.parametrize(
    ("formula", "bounds"),
    [("z - sin(8*r)/(4*r)", 2), ("z - log(1 + r)", 2), ("z - r^y/4", 2), ("x^200 + y^200 + z^200 - 1", 1.2)],
)
def test_contraction_goes_by_forms_of_what_has_ranges_too(formula: str, bounds: float) -> None:
    f = irt.parse(formula).subs("r", irt.parse("sqrt(x^2 + y^2 + 1/10)"))
    looks = [
        irt.render(f, bounds=bounds, size=(48, 48), method=m, eps=1e-3, precision="single", outputs=("pieces",)).pieces.mean()
        for m in ("contract", "ia")
    ]
    assert looks[0] < 0.6 * looks[1]


def test_double_precision(device: str) -> None:
    camera = irt.Camera((2, 1.5, 3))
    frame = irt.render(SPHERE, camera=camera, size=(17, 13), precision="double", eps=1e-9, device=device)
    expected = _sphere_depth(camera, (17, 13))
    assert frame.depth.dtype == np.float64
    hit = frame.status == Status.HIT
    assert hit.sum() > 10
    assert np.abs(frame.depth - expected)[hit].max() < 1e-8


def test_orthographic() -> None:
    camera = irt.Camera((0, 0, 5), projection="orthographic", height=3)
    frame = irt.render(SPHERE, camera=camera, size=(40, 30), eps=1e-4)
    expected = _sphere_depth(camera, (40, 30))
    hit = frame.status == Status.HIT
    assert hit.sum() > 300
    assert (np.abs(frame.depth - expected)[hit] <= frame.uncertainty[hit]).all()


def test_far_camera_loses_nothing() -> None:
    camera = irt.Camera((0, 0, 1e5), fov=0.0015)
    frame = irt.render(SPHERE, camera=camera, size=(32, 32), eps=1e-3)
    expected = _sphere_depth(camera, (32, 32))
    hit = frame.status == Status.HIT
    assert frame.depth.dtype == np.float64
    assert hit.sum() > 300
    assert np.abs(frame.depth - expected)[hit].max() < 1e-3


def test_eye_inside_the_bounds_and_on_the_surface() -> None:
    inside = irt.render(SPHERE, camera=irt.Camera((0, 0, 0.5), target=(0, 0, -1)), size=(16, 16))
    assert (inside.status == Status.HIT).all()
    on = irt.trace("z", [0, 0, 0], [0, 0, 1], bounds=1)
    assert on.hit[0] and on.t[0] <= 1e-3


def test_bounds_clip() -> None:
    ball = irt.render("z", bounds=irt.Sphere((0, 0, 0), 1), camera=irt.Camera((0, 0, 5)), size=(64, 64))
    radius = np.linalg.norm(ball.points[ball.hit], axis=1)
    assert radius.max() <= 1 + 1e-3
    both = irt.render(
        "z",
        bounds=[((-0.5, 2), (-2, 2), (-2, 2)), irt.Sphere((0, 0, 0), 1)],
        camera=irt.Camera((0, 0, 5)),
        size=(64, 64),
    )
    assert both.points[both.hit][:, 0].min() >= -0.5 - 1e-3
    assert both.hit.sum() < ball.hit.sum()


@pytest.mark.parametrize("method", ["ia", "raa", "contract", "mitchell"])
@pytest.mark.parametrize("precision", ["single", "double"])
def test_roots_at_the_bounds(method: str, precision: str) -> None:
    """A root just outside the bounds is no hit, and one just inside no miss, however rounding falls."""
    rng = np.random.default_rng(3)
    n = 4000
    off = rng.choice([-1, 1], n) * 10.0 ** rng.uniform(-17, -4, n)
    place = np.stack([rng.uniform(-1, 1, n), 2 + off, rng.uniform(-1, 1, n)], -1)
    direction = rng.normal(size=(n, 3))
    distance = rng.uniform(0.1, 100, n)[:, None]
    bounds = ((-3, 3), (-3, 2), (-3, 3))
    for k in range(0, n, 500):  # planes through a place at the face, and rays that pass close by
        o = place[k] - distance[k] * direction[k] + np.zeros((64, 1))
        d = place[k] + rng.normal(size=(64, 3)) * 1e-7 - o
        for f, at in (("x - p", place[k, 0]), ("y - p", place[k, 1])):
            call = {"bounds": bounds, "params": {"p": float(at)}}
            found = irt.trace(f, o, d, method=method, precision=precision, eps=1e-6, **call)
            truth = irt.reference(f, o, d, **call)
            assert not ((truth.kind == Status.MISS) & (found.status == Status.HIT)).any()
            assert not (truth.hit & (found.status == Status.MISS)).any()


def test_parameters_compile_nothing() -> None:
    first = irt.render("x^2 + y^2 + z^2 - a^2", params={"a": 0.5}, size=(32, 32), isovalue=0.0)
    second = irt.render("x^2 + y^2 + z^2 - a^2", params={"a": 1.25}, size=(32, 32), isovalue=0.1)
    assert second.stats.builds == 0
    assert second.hit.sum() > first.hit.sum() > 0
    by_hand = irt.render(f"x^2 + y^2 + z^2 - {1.25**2 + 0.1!r}", size=(32, 32))
    assert np.array_equal(second.hit, by_hand.hit)
    assert irt.render("x^2 + y^2 + z^2", size=(32, 32), isovalue=0.25).hit.any()


def test_outputs_and_transparency() -> None:
    frame = irt.render(SPHERE, size=(8, 8), outputs=())
    with pytest.raises(irt.ArgumentError, match="outputs"):
        _ = frame.rgb
    clear = irt.render(SPHERE, size=(8, 8), background=None)
    assert set(np.unique(clear.rgba[..., 3])) <= {0, 255} and clear.rgba[0, 0, 3] == 0


@pytest.mark.parametrize("method", ["ia", "raa", "contract", "mitchell"])
@pytest.mark.parametrize("formula", ["1/x + y", "y - tan(3x)/2", "z + x/(y^2 - 1/4)", "1/(x - y) - 2/(z + x)"])
def test_poles_of_quotients_are_seen_through(formula: str, method: str) -> None:
    frame = irt.render(formula, bounds=1.5, size=(40, 40), method=method, outputs=())
    truth = irt.reference(formula, bounds=1.5, size=(40, 40))
    assert (frame.status == Status.UNRESOLVED).mean() < 0.02
    assert not (truth.hit & (frame.status == Status.MISS)).any()
    assert not ((truth.kind == Status.MISS) & (frame.status == Status.HIT)).any()
    assert truth.hit.any() and (frame.status == Status.MISS).any()


@pytest.mark.parametrize("method", ["ia", "raa", "contract", "mitchell"])
@pytest.mark.parametrize("formula", ["x + 1e300", "x^2 + 1e39", "x - 1e300*y + 1e300", "1e300 - 1e300*x^2 + z"])
def test_constants_past_the_largest_real(formula: str, method: str) -> None:
    frame = irt.render(formula, size=(24, 24), method=method, outputs=())
    truth = irt.reference(formula, size=(24, 24))
    assert not (truth.hit & (frame.status == Status.MISS)).any()
    assert not ((truth.kind == Status.MISS) & (frame.status == Status.HIT)).any()


def test_poles_with_an_isovalue() -> None:
    at = [irt.trace("1/x", [[-1, 0.1, 0.2]], [[1, 0, 0]], tmax=3, bounds=2, isovalue=v) for v in (2, 4)]
    assert np.allclose([hits.t[0] for hits in at], [1.5, 1.25], atol=1e-3)
    assert [hits.status[0] for hits in at] == [Status.HIT, Status.HIT] and at[1].stats.builds == 0


def test_poles_and_jumps_are_no_hits() -> None:
    pole = irt.trace("1/x", [[-1, 0.1, 0.2]], [[1, 0, 0]], tmax=2, bounds=2)
    assert pole.status[0] == Status.MISS
    jump = irt.trace("sign(x)", [[-1, 0.1, 0.2]], [[1, 0, 0]], tmax=2, bounds=2)
    assert jump.status[0] == Status.TOUCH
    assert irt.trace("log(x) + 5", [[-1, 0.1, 0.2]], [[1, 0, 0]], tmax=2, bounds=2).hit[0]


def test_even_root_is_a_touch() -> None:
    assert irt.trace("(z - 1/3)^2", [0, 0, 2], [0, 0, -1], bounds=1).status[0] == Status.TOUCH


def test_budgets() -> None:
    spent = irt.render("sin(40*x)*sin(40*y)*sin(40*z) + 0.9999", size=(16, 16), method="ia", max_pieces=20)
    assert spent.stats.counts["UNRESOLVED"] > 0 and "UNRESOLVED" in repr(spent)
    late = irt.render(SPHERE, size=(64, 64), time_limit=1e-9)
    assert late.stats.counts["UNRESOLVED"] >= 64 * 64 - 16  # one packet may run before the clock is looked at


def test_progress_must_be_callable() -> None:
    with pytest.raises(irt.ArgumentError, match="progress must be"):
        irt.render(SPHERE, size=(4, 4), progress=5)  # type: ignore[arg-type]


def test_trace_shapes() -> None:
    none = irt.trace(SPHERE, np.zeros((0, 3)), np.zeros((0, 3)), bounds=2)
    assert none.t.shape == (0,) and none.normal.shape == (0, 3)
    rays = irt.trace(SPHERE, (0, 0, 3), np.array([[0, 0, -1], [0, 0, -2], [0, 1, 0]], dtype=np.float32), bounds=2)
    assert rays.t == pytest.approx([2, 1, math.inf], abs=1e-3)
    assert rays.points[0] == pytest.approx([0, 0, 1], abs=1e-3)
    finite = irt.trace(SPHERE, (0, 0, 3), (0, 0, -1), tmax=10)
    assert finite.t[0] == pytest.approx(2, abs=1e-2)
    assert irt.trace(SPHERE, (0, 0, 3), (0, 0, -1), tmin=2.5, bounds=2).t[0] == pytest.approx(4, abs=1e-3)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: irt.render("x^2 + a", size=(4, 4)), irt.ArgumentError, "'a' has no value; give it as params={'a': ...}"),
        (lambda: irt.render("x", outputs=None), irt.ArgumentError, "outputs"),
        (lambda: irt.kernel_source("x", outputs=("nonsense",)), irt.ArgumentError, "outputs"),
        (lambda: irt.kernel_source("x", outputs=(1,)), irt.ArgumentError, "outputs"),
        (lambda: irt.kernel_source("x", params=5), irt.ArgumentError, "params"),
        (lambda: irt.render("x", method=irt.Bisection(np.zeros(3))), irt.ArgumentError, "algebra"),
        (lambda: irt.render("x", method=irt.Contraction(np.zeros(3))), irt.ArgumentError, "beams"),
        (lambda: irt.render("x", device="pocl:²"), irt.DeviceError, "pocl"),
        (lambda: irt.surfaces[[1]], irt.ArgumentError, "no surface"),
        (lambda: irt.trace("x", (0, 0, 3), (0, 0, -1e30), bounds=2), irt.ArgumentError, "direction is 1e"),
        (lambda: irt.trace("x", (0, 0, 1e25), (0, 0, -1), bounds=2), irt.ArgumentError, "away from the bounds"),
        (lambda: irt.render("a*x", params={"b": 1, "a": 1}), irt.ArgumentError, "unknown parameter 'b'"),
        (lambda: irt.render("a*x", params={"a": math.nan}), irt.ArgumentError, "finite"),
        (lambda: irt.render("x", method="rai"), irt.ArgumentError, "'raa'"),
        (lambda: irt.render("x", size=(0, 4)), irt.ArgumentError, "at least"),
        (lambda: irt.render("x", size=(10**6, 10**6)), irt.LimitError, "limit"),
        (lambda: irt.render("x", eps=-1), irt.ArgumentError, "eps"),
        (lambda: irt.render("x", bounds=((1, 0), (0, 1), (0, 1))), irt.ArgumentError, "empty"),
        (lambda: irt.render("x", color="blurple"), irt.ArgumentError, "colour"),
        (lambda: irt.render("x", precision="half"), irt.ArgumentError, "precision"),
        (lambda: irt.render("x < y"), irt.ExpressionError, "condition"),
        (lambda: irt.trace("x", (0, 0, 0), (0, 0, 0), bounds=1), irt.ArgumentError, "zero vector"),
        (lambda: irt.trace("x", (0, 0, 0), (1, 0, 0)), irt.ArgumentError, "infinite"),
        (lambda: irt.trace("x", np.zeros((2, 3)), np.ones((3, 3)), bounds=1), irt.ArgumentError, "lengths"),
        (lambda: irt.render("x", device="no such device"), irt.DeviceError, "no such device"),
        (lambda: irt.render("log(-1 - cos(1)) + x", size=(4, 4)), irt.ExpressionError, "no value"),
    ],
)  # fmt: skip
def test_errors_say_what_to_do(call, error, words) -> None:
    with pytest.raises(error, match=words):
        call()


def test_threads_render_the_same() -> None:
    alone = irt.render("barth_sextic" and irt.surfaces["barth_sextic"], size=(96, 96))
    frames: list[irt.Frame] = []
    threads = [
        threading.Thread(target=lambda: frames.append(irt.render(irt.surfaces["barth_sextic"], size=(96, 96))))
        for _ in range(4)
    ]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert len(frames) == 4
    assert all(np.array_equal(f.depth, alone.depth) and np.array_equal(f.rgb, alone.rgb) for f in frames)


def test_save(tmp_path: Path) -> None:
    from PIL import Image

    frame = irt.render(SPHERE, size=(20, 10))
    frame.save(tmp_path / "a.png")
    assert np.array_equal(np.asarray(Image.open(tmp_path / "a.png")), frame.rgb)
    frame.save(tmp_path / "a.npz")
    stored = np.load(tmp_path / "a.npz")
    assert np.array_equal(stored["depth"], frame.depth)
    with pytest.raises(irt.ArgumentError, match="png or .npz"):
        frame.save(tmp_path / "a.bmp")
    with pytest.raises(OSError):
        frame.save(tmp_path / "missing" / "a.png")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "a.png"]
    assert np.asarray(frame).shape == (10, 20, 3)
    assert frame._repr_png_()[:4] == b"\x89PNG"


@pytest.mark.parametrize("formula", ["x^2 + y^2 + z^2 - 1", "sin(x) - y"])
def test_kernel_source_is_of_what_render_takes(formula: str) -> None:
    taken = irt.render(formula, size=(4, 4)).stats.method
    assert irt.kernel_source(formula) == irt.kernel_source(formula, method=taken)


def test_kernel_source_is_readable_and_minimal() -> None:
    source = irt.kernel_source("a*x^2 + y", method="ia", outputs=())
    assert "#pragma OPENCL FP_CONTRACT OFF" in source
    assert (
        "bounds of parameter 0" in source and "ra_mul" not in source and "irt_gradient(F" not in source and "encode" not in source
    )
    assert "native_" not in source


@pytest.mark.parametrize("method", ["contract", "adaptive-sign", "sampled-newton"])
@pytest.mark.parametrize("f", ["z - Piecewise((1/x, y > 5), (x/8 + y/4, True))", "Max(z - x/8 - y/4, sqrt(Abs(x)) - 9)"])
def test_a_pole_of_what_is_not_chosen_spoils_no_normal(f: str, method: str) -> None:
    """At x = 0 the derivative of the other branch is infinite, and its share of the gradient nothing."""
    hits = irt.trace(f, (0, 0, 3), (0, 0, -1), bounds=2, method=method, eps=1e-4)
    assert hits.status[0] == Status.HIT
    assert hits.normal[0] == pytest.approx(np.array([-1, -2, 8]) / 69**0.5, abs=1e-6)
