"""Closed forms (S3, S4): polynomials of degree 4 at most and trees of them, judged by the reference and by exact roots."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Rational, Status

x, y, z = irt.symbols("x y z")
# Degree 1 to 4: plain, singular, self-crossing, touching, with sheets a millionth apart.
SURFACES = ["sphere", "cayley", "ding_dong", "klebsch", "whitney", "torus", "tooth", "steiner", "kummer", "double_plane", "nested_spheres_tiny_gap"]
VIEWS = {
    "orthographic": irt.Camera((3, 2, 4), projection="orthographic", height=3),
    "inside": irt.Camera((0.2, 0.1, 0.3), target=(1, 0, 0), fov=70),
    "far": irt.Camera((48000, 36000, 80000), fov=0.0016),
}


def _judge(found: irt.Frame | irt.Hits, depth: np.ndarray, truth: irt.Reference, error: float) -> None:
    decided = truth.kind != Status.UNRESOLVED
    same = (found.hit == truth.hit)[decided]
    assert same.mean() >= 0.999, f"{(~same).sum()} of {same.size}"
    both = found.hit & truth.hit
    assert np.quantile(np.abs(depth[both] - truth.depth[both]), 0.99) <= error
    assert not found.stats.proven
    assert np.isnan(found.uncertainty).all()


@pytest.mark.parametrize("name", SURFACES)
def test_frames(name: str) -> None:
    surface = irt.surfaces[name]
    truth = irt.reference(surface, size=(40, 40))
    for precision, error in (("auto", 1e-5), ("double", 1e-9)):
        frame = irt.render(surface, size=(40, 40), method="analytic", precision=precision)
        _judge(frame, frame.depth, truth, error)
        assert (frame.status == truth.kind).mean() >= 0.999
    as_tree = irt.render(surface, size=(40, 40), method=irt.CsgAnalytic())
    assert (as_tree.status == truth.kind).mean() >= 0.999


def test_widths_and_drivers(device: str) -> None:
    f = "(x^2 + y^2 + z^2 + 15/100)^2 - x^2 - y^2"
    truth = irt.reference(f, bounds=1.2, size=(33, 24))
    for precision in ("single", "double"):
        frame = irt.render(f, bounds=1.2, size=(33, 24), method=irt.Analytic(), precision=precision, device=device)
        _judge(frame, frame.depth, truth, 1e-5)
    g = irt.r_subtraction(1 - x**4 - y**4 - z**4, Rational(11, 10) - x**2 - y**2 - z**2)
    frame = irt.render(g, bounds=1.2, size=(33, 24), method="csg-analytic", device=device)
    _judge(frame, frame.depth, irt.reference(g, bounds=1.2, size=(33, 24)), 1e-5)


@pytest.mark.parametrize("view", VIEWS)
def test_views_and_bounds(view: str) -> None:
    f = "x^4 + y^4 + z^4 - 1.2 x^2 - 0.3 y + 0.1"
    for bounds in (1.5, [irt.Sphere((0, 0.1, 0), 1.2), irt.HalfSpace((0.2, 1, 0.3), 0.3)]):
        truth = irt.reference(f, camera=VIEWS[view], bounds=bounds, size=(40, 40))
        for method in ("analytic", "csg-analytic"):
            frame = irt.render(f, camera=VIEWS[view], bounds=bounds, size=(40, 40), method=method)
            _judge(frame, frame.depth, truth, 1e-5 if view != "far" else 1e-2)
            assert truth.hit.any() or view == "inside"


def test_a_root_at_the_start_counts() -> None:
    for method in ("analytic", "csg-analytic"):
        hits = irt.trace("x^2 + y^2 + z^2 - 1", [(1, 0, 0), (0, 0, 0)], (1, 0, 0), bounds=2, method=method)
        assert hits.status.tolist() == [Status.TOUCH, Status.HIT]  # rounding hides on which side of the sphere the first one starts
        assert np.abs(hits.t - [0, 1]).max() < 1e-6


def test_odd_roots_hit_and_even_roots_touch() -> None:
    ray = {"origins": (-2, 0, 0), "directions": (1, 0, 0), "bounds": 2}
    for f, status, t in (
        ("(x - 1/2)^3", Status.HIT, 2.5), ("(x - 1/2)^2", Status.TOUCH, 2.5), ("(x - 1/2)^4", Status.TOUCH, 2.5),
        ("(x + 1)^2 (x - 1)", Status.TOUCH, 1), ("(x + 1)^3 (x - 1)", Status.HIT, 1), ("(x^2 - 1)^2", Status.TOUCH, 1), ("x^4 - x^2", Status.HIT, 1),
        ("x^2 + 1/1000", Status.MISS, np.inf), ("y", Status.TOUCH, 0), ("y + 1", Status.MISS, np.inf), ("x^4 + x^2 - 1/2", Status.HIT, None),
        ("x^4 - 4x^2 + x + 1", Status.HIT, None), ("x^3 - 3x + 1", Status.HIT, None),
    ):  # fmt: skip
        hits = irt.trace(f, method="analytic", precision="double", **ray)
        assert hits.status[0] == status, f
        exact = irt.reference(f, (-2, 0, 0), (1, 0, 0), bounds=2).depth[0] if t is None else t
        # Rounding hides a root of order n within the n-th root of an ulp.
        assert hits.t[0] == exact or abs(hits.t[0] - exact) < (1e-12 if t is None else 1e-3), f


COEFFICIENTS = dict.fromkeys("abcde", 0.0)


@pytest.mark.parametrize(("precision", "ulp"), [("single", 2.0**-23), ("double", 2.0**-52)])
def test_every_root_of_random_polynomials(precision: str, ulp: float) -> None:
    """Clustered, of very unequal size, with leading coefficients that vanish: within some ulps of what their conditioning allows."""
    rng = np.random.default_rng(3)
    worst = []
    for k in range(120):
        kind, degree = k % 4, 2 + k // 4 % 3
        roots = rng.uniform(-0.9, 0.9, degree)
        if kind == 1:
            roots = roots[0] + rng.uniform(-1, 1, degree) * 1e-2
        if kind == 2:
            roots = np.sign(roots) * 10.0 ** rng.uniform(-3, 0, degree) * 0.9
        if kind == 3:
            roots[-1] *= 10.0 ** rng.uniform(2, 9)  # the leading coefficient vanishes beside the others
        roots = np.sort(roots)
        c = np.poly(roots)[::-1]
        c /= np.abs(c).max()
        if precision == "single":
            c = c.astype(np.float32).astype(np.float64)
        values = COEFFICIENTS | dict(zip("abcde", c, strict=False))
        if np.abs(np.polyval(np.polyder(c[::-1]), roots)).min() < 1e3 * ulp:
            continue
        # Roots of the polynomial as rounded: the derivative says how far they moved.
        slope = np.polyval(np.polyder(c[::-1]), roots)
        true = roots - np.polyval(c[::-1], roots) / slope
        inner = np.flatnonzero(np.abs(true) < 0.95)
        starts = np.array([-1.0 if i == 0 else 0.5 * (true[i - 1] + true[i]) for i in inner])
        starts = np.maximum(starts, -1.0)
        hits = irt.trace("a + b x + c x^2 + d x^3 + e x^4", (-1, 0, 0), (1, 0, 0), tmin=starts + 1, bounds=1, method="analytic",
                         precision=precision, params=values)  # fmt: skip
        assert hits.hit.all(), (kind, roots)
        conditioned = ulp * (2 + np.abs(c).sum() / np.abs(slope[inner]))
        worst.append((np.abs(hits.t - 1 - true[inner]) / conditioned).max())
    assert len(worst) > 60
    assert max(worst) < 16, max(worst)


def test_parameters_are_arguments() -> None:
    for method in ("analytic", "csg-analytic"):
        for a in (0.5, -0.5, 0.7):
            f = "x^2/a + sqrt(a + 1) y^2 + z^2 - 1"
            frame = irt.render(f, params={"a": a}, size=(24, 24), method=method, precision="double")
            assert (frame.status == irt.reference(f, params={"a": a}, size=(24, 24)).kind).all()
        assert frame.stats.builds == 0


def test_powers_that_cancel() -> None:
    """Of degree 2, though its parts are of degree 6: only the coefficients that count are computed."""
    f = "(x^3 + 1)^2 - x^6 - 2 x^3 + x^2 + y^2 + z^2 - 2"
    truth = irt.reference("x^2 + y^2 + z^2 - 1", size=(32, 32), bounds=1.5)
    assert (irt.render(f, size=(32, 32), bounds=1.5, method="analytic").hit == truth.hit).all()


def test_isovalues() -> None:
    truth = irt.reference("x^2 + y^2 + z^2 - 1", size=(24, 24), bounds=1.5)
    frame = irt.render("x^2 + y^2 + z^2", isovalue=1, size=(24, 24), bounds=1.5, method="analytic")
    assert (frame.status == truth.kind).all()
    with pytest.raises(irt.MethodError, match="isovalue"):
        irt.render("Max(x, y)", isovalue=1, size=(8, 8), method="csg-analytic")


@pytest.mark.parametrize(
    ("f", "message"),
    [("x^5 - y", "degree is 5.*frustum-lr.*contract"), ("sin(x) - y", "none.*contract"), ("Max(x, y)", "csg-analytic"), ("1/x - y", "contract")],
)
def test_what_analytic_refuses(f: str, message: str) -> None:
    with pytest.raises(irt.MethodError, match=message):
        irt.render(f, size=(8, 8), method="analytic")


@pytest.mark.parametrize(
    ("f", "message"), [("Max(x^5, y)", "degree 5.*contract"), ("Max(sin(x), y)", "not sin"), ("x + y + sqrt(x^2 + z^2)", "not Add"), ("Abs(x) - y", "not Add")]
)
def test_what_csg_analytic_refuses(f: str, message: str) -> None:
    with pytest.raises(irt.MethodError, match=message):
        irt.render(f, size=(8, 8), method="csg-analytic")


def test_too_many_leaves() -> None:
    with pytest.raises(irt.LimitError, match="64"):
        irt.render(irt.Max(*(x + k * y for k in range(70))), size=(8, 8), method="csg-analytic")


def test_clips_are_refused() -> None:
    for method in ("analytic", "csg-analytic"):
        with pytest.raises(irt.MethodError, match="irt.Clip"):
            irt.render("x^2 + y^2 + z^2 - 1", bounds=[1.5, irt.Clip("x")], size=(8, 8), method=method)


def test_kernels_have_no_enclosures() -> None:
    for method in ("analytic", "csg-analytic"):
        source = irt.kernel_source("Max(x, y)" if method == "csg-analytic" else "x^4 - y", method=method)
        assert "irt_affine" not in source and "irt_interval" not in source and "LOWER(v, n)" in source
        assert "ia_add" not in source and "ra_add" not in source


@pytest.mark.parametrize("method", ["analytic", "csg-analytic"])
@pytest.mark.parametrize("factor", ["10^20", "10^(-25)", "10^35", "10^(-300)"])
@pytest.mark.parametrize("f", ["x^2 + y^2 + z^2 - 1", "x^3 + y^2 - z", "x^4 + y^4 + z^2 - 1"])
def test_a_factor_changes_nothing(f: str, factor: str, method: str) -> None:
    """Squares of coefficients left the range of floats: wrong depths and misses, which nothing noticed."""
    frame = irt.render(f"{factor}*({f})", size=(20, 20), method=method)
    truth = irt.reference(f, size=(20, 20), camera=frame.camera, bounds=frame.bounds)
    assert (frame.status == truth.kind).all()
    assert np.abs(frame.depth - truth.depth)[truth.hit].max() < 1e-5


@pytest.mark.parametrize("method", ["analytic", "csg-analytic"])
def test_triple_roots_go_to_double(method: str) -> None:
    """Where rounding hides a root by more than eps it is a TOUCH: it was a HIT three times eps away."""
    f = "(x + y/2 + z/3)^3"
    single, auto = (irt.render(f, size=(20, 20), method=method, precision=p, eps=1e-3) for p in ("single", "auto"))
    truth = irt.reference(f, size=(20, 20), camera=auto.camera, bounds=auto.bounds)
    assert not (single.status == irt.Status.HIT).any() and (single.hit[truth.hit]).all()
    assert (auto.status == irt.Status.HIT)[truth.hit].all()
    assert np.abs(auto.depth - truth.depth)[truth.hit].max() < 1e-3
