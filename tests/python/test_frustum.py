"""The frustum form and its root finders (S2): judged by the reference, never rebuilt, refused where they do not apply."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Status

FINDERS = [name for name in irt.methods() if name.startswith("frustum-")]
PAPER = [f"frustum-{f}" for f in ("lr", "lr-mult", "mr", "mr-mult", "clip", "midpoint")]
# Simple, singular, of high degree, with printed coefficients that cancel.
SURFACES = ["sphere", "cayley", "barth_sextic", "barth_decic", "supersphere_16"]


def _judge(found: irt.Frame | irt.Hits, depth: np.ndarray, truth: irt.Reference) -> None:
    assert not ((found.status == Status.MISS) & truth.hit).any()
    assert not ((found.status == Status.HIT) & (truth.kind == Status.MISS)).any()
    both = (found.status == Status.HIT) & truth.hit
    slack = found.uncertainty[both] + truth.uncertainty[both]
    assert (np.abs(depth[both] - truth.depth[both]) <= slack).all()


def test_all_of_the_paper() -> None:
    assert set(FINDERS) == {*PAPER, "frustum-newton"}


@pytest.mark.parametrize("name", SURFACES)
def test_frames(name: str) -> None:
    surface = irt.surfaces[name]
    truth = irt.reference(surface, size=(48, 48))
    for method in FINDERS:
        for precision in ("single", "auto"):
            frame = irt.render(surface, size=(48, 48), method=method, precision=precision, eps=1e-4)
            _judge(frame, frame.depth, truth)
        # What single precision leaves open has gone to double and to the reference.
        assert (frame.status == truth.kind).all()
        assert frame.stats.wide == 0


AHEAD = irt.Camera((0, 0, 5), target=(0, 0, 0), up=(0, 1, 0), projection="orthographic", height=2)


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("degree", [8, 11])
def test_what_turns_within_a_tile_is_seen(axis: str, degree: int) -> None:
    """Cells are bounded by their first few polynomials across and down, and by the sizes of the others: here all but one is nought."""
    a, b = "1", axis  # Chebyshev polynomials, of the one tile that there is
    for _ in range(degree - 1):
        a, b = b, f"(2*{axis}*{b} - {a})"
    f = f"z^3 - 0.3*z + 0.4*{b}"
    call = dict(bounds=1, camera=AHEAD, size=(16, 16))
    truth = irt.reference(f, **call)
    frame = irt.render(f, method="frustum-newton", precision="single", eps=1e-4, **call)
    _judge(frame, frame.depth, truth)
    assert truth.hit.all() and frame.hit.mean() > 0.9


def test_what_lies_behind_a_sheet_outside_the_bounds_is_seen() -> None:
    """On every ray of a tile there is a root in front of the ball, which hides nothing."""
    f, ball = "(z - 0.9)*(z - 0.1)*(1 + x^2 + y^2 + z^2)^3", irt.Sphere((0, 0, 0), 0.92)
    truth = irt.reference(f, bounds=ball, camera=AHEAD, size=(64, 64))
    frame = irt.render(f, bounds=ball, camera=AHEAD, size=(64, 64), method="frustum-newton", eps=1e-4)
    _judge(frame, frame.depth, truth)
    assert (frame.status == truth.kind).all()
    assert (truth.depth[truth.hit] > 4.5).sum() > 1000 and (truth.depth[truth.hit] < 4.5).sum() > 10


@pytest.mark.parametrize(("name", "eps"), [("decocube", 1e-3), ("chmutov_18", 1e-5), ("chmutov_20", 1e-3)])
def test_tiles_that_double_is_not_enough_for(name: str, eps: float) -> None:
    """Tiles whose cells are less exact than they may be are cut in sums of two doubles, alone, some only in front or behind."""
    surface = irt.surfaces[name]
    truth = irt.reference(surface, size=(80, 80))
    frame = irt.render(surface, size=(80, 80), method="frustum-newton", precision="single", eps=eps)
    _judge(frame, frame.depth, truth)
    assert (frame.status != Status.MISS).sum() >= truth.hit.sum()


def test_trace() -> None:
    rng = np.random.default_rng(2)
    o = rng.normal(size=(500, 3)) * 4
    d = rng.uniform(-1, 1, (500, 3)) - o
    f = "(x^2 + y^2 + z^2)^2 - 3 x y z - x^2 + 0.2"
    truth = irt.reference(f, o, d, bounds=1.5)
    exact = irt.trace(f, o, d, bounds=1.5, method="contract", precision="double", eps=1e-9)
    for method in FINDERS:
        hits = irt.trace(f, o, d, bounds=1.5, method=method, eps=1e-5)
        _judge(hits, hits.t, truth)
        assert (hits.status == truth.kind).all()
        both = hits.hit & exact.hit
        assert np.nanmin((hits.normal * exact.normal).sum(1)[both]) > 1 - 1e-3


def test_normals_are_those_of_the_gradient() -> None:
    surface = irt.surfaces["tangle"]
    form = irt.render(surface, size=(64, 64), method="frustum-lr", eps=1e-6)
    program = irt.render(surface, size=(64, 64), method="contract", eps=1e-6)
    both = (form.status == Status.HIT) & (program.status == Status.HIT)
    assert np.quantile((form.normal * program.normal).sum(-1)[both], 0.02) > 1 - 1e-5


def test_cameras() -> None:
    f = "x^4 + y^4 + z^4 - 1.2 x^2 - 0.3 y + 0.1"
    for camera in (
        irt.Camera((3, 2, 4), projection="orthographic", height=3),
        irt.Camera((0.2, 0.1, 0.3), target=(1, 0, 0)),  # inside the bounds
        irt.Camera((900, 500, 1200), fov=0.2),
    ):
        truth = irt.reference(f, camera=camera, bounds=1.5, size=(40, 40))
        frame = irt.render(f, camera=camera, bounds=1.5, size=(40, 40), method="frustum-clip", eps=1e-4)
        _judge(frame, frame.depth, truth)
        decided = truth.kind != Status.UNRESOLVED
        assert (frame.status == truth.kind)[decided].mean() > 0.995 or not decided.any()
        assert frame.stats.counts["UNRESOLVED"] == 0


def test_another_polynomial_builds_nothing() -> None:
    irt.render("x^3 + y^3 + z^3 - a", params={"a": 0.4}, size=(64, 64), method="frustum-lr")
    for f, a in (("x^3 + y^3 + z^3 - a", 0.7), ("x*y*z - a*x^2 - 0.1", 0.2)):
        frame = irt.render(f, params={"a": a}, size=(64, 64), method="frustum-lr", camera=irt.Camera((2, 3, 4)))
        assert frame.stats.builds == 0
        assert frame.hit.any()


@pytest.mark.parametrize("scale", ["1e30", "1e-30"])
def test_coefficients_of_any_size(scale: str) -> None:
    plain = irt.render("x^2 + y^2 + z^2 - 1", size=(32, 32), method="frustum-lr", bounds=1.5)
    scaled = irt.render(f"{scale}*(x^2 + y^2 + z^2 - 1)", size=(32, 32), method="frustum-lr", bounds=1.5)
    assert (plain.status == scaled.status).all()


def test_leading_terms_may_vanish() -> None:
    frame = irt.render("a*x^5 + x^2 + y^2 + z^2 - 1", params={"a": 0}, size=(32, 32), method="frustum-mr", bounds=1.5)
    sphere = irt.render("x^2 + y^2 + z^2 - 1", size=(32, 32), method="contract", bounds=1.5)
    assert (frame.status == sphere.status).all()


@pytest.mark.parametrize("f", ["sin(x) - y", "x^64 + y^64 - z", "Abs(x) - y", "1/x - y", "x*0 + 3"])
def test_what_is_refused(f: str) -> None:
    with pytest.raises(irt.MethodError, match="contract"):
        irt.render(f, size=(8, 8), method="frustum-lr")


def test_a_named_surface_of_degree_200_is_refused_and_drawn_otherwise() -> None:
    with pytest.raises(irt.MethodError, match="degree 200"):
        irt.render(irt.surfaces["superquadric_200"], size=(8, 8), method="frustum-newton")
    assert irt.render(irt.surfaces["superquadric_200"], size=(8, 8)).stats.method == "contract"


def test_insertions_differ_as_in_the_paper() -> None:
    """S2 table 2: halving takes more steps than zeros of the control polygon, knots more than pieces of what they replace."""
    mean = {
        m: irt.render(irt.surfaces["barth_sextic"], size=(64, 64), method=m, eps=1e-6, precision="double",
                      outputs=("pieces",)).pieces.mean()
        for m in PAPER
    }  # fmt: skip
    assert mean["frustum-midpoint"] > 1.5 * mean["frustum-lr"]
    assert len({round(float(v), 2) for v in mean.values()}) == len(PAPER)


def test_kernel_has_no_formula() -> None:
    a = irt.kernel_source("x^3 + y*z^2 - 1", method="frustum-lr")
    b = irt.kernel_source("x*y*z + 7.25", method="frustum-lr")
    assert a == b
    assert "irt_affine" not in a and "irt_interval" not in a


@pytest.mark.parametrize("method", FINDERS)
def test_what_lies_behind_a_half_space_is_seen(method: str) -> None:
    """A cell in which every ray has a root hides nothing if a half-space takes that root away."""
    bounds = [1.2, irt.HalfSpace((0, 0, 1), 0.2)]
    camera = irt.Camera((0, 0, 5), projection="orthographic", height=2.4)
    frame = irt.render("x^2 + y^2 + z^2 - 1", bounds=bounds, camera=camera, size=(96, 96), method=method)
    truth = irt.reference("x^2 + y^2 + z^2 - 1", bounds=bounds, camera=camera, size=(96, 96))
    _judge(frame, frame.depth, truth)
    assert (frame.status == truth.kind).all()


def test_auto_takes_the_form_where_it_is_fastest() -> None:
    assert irt.explain("x^6 + y^6 - z").startswith("auto takes frustum-newton")
    for f in ("x^16 + y^16 + z^16 - 1", "x + y", "sin(x) - y", "((x^2 + y^2 + z^2 - 1)^4 - x*y*z/10)^2 - 0.01"):
        assert "frustum" not in irt.explain(f)
    long = " + ".join(f"{i + 1}/{j + 7}*x^{i}*y^{j}*z^{16 - i - j}" for i in range(17) for j in range(17 - i))
    assert irt.explain(long + " - 1").startswith("auto takes frustum-newton")
    assert irt.render("x^2*y + z - 0.1", size=(16, 16)).stats.method == "frustum-newton"
    clipped = irt.render("x^2*y + z - 0.1", bounds=[1, irt.Clip("x")], size=(16, 16))
    assert clipped.stats.method == "contract"
    assert irt.trace("x^2*y + z - 0.1", (0, 0, 4), (0, 0, -1), bounds=2).stats.method == "contract"


def test_builds_that_are_waited_for_are_counted() -> None:
    """A kernel in double that is begun behind the second frame: pixels go to the reference until it is there, and where they are too many for that the frame says that it built."""
    code = """
import implicitrt as irt
from implicitrt.devices import open_device
def draw(f):
    s = irt.render(f, bounds=2, camera=irt.Camera((3, 3, 4)), size=(640, 480)).stats
    print(s.builds, s.by_reference)
steiner, heart = "x^2*y^2 - x^2*z^2 + y^2*z^2 - x*y*z", "(x^2 + y^2 - 1)^3 - z^2*x^3"
draw(steiner), draw(steiner), open_device(None).finish(), draw(steiner)
draw("x^6 + y^6 + z^6 - 1"), draw(heart), draw(heart)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    builds, referred = zip(*(map(int, line.split()) for line in done.stdout.split("\n") if line), strict=True)
    assert builds == (1, 0, 0, 1, 1, 0)
    assert referred[0] == referred[1] > 64 > referred[2]


def test_auto_says_how_it_reaches_eps() -> None:
    coarse, fine, finest = (irt.render("x^2*y + z - 0.1", size=(16, 16), eps=eps).stats.reason for eps in (1e-3, 1e-6, 1e-12))
    assert "double" not in coarse and "narrowed down in double" in fine and "does not resolve eps" in finest
    assert "drown" in irt.render(irt.surfaces["chmutov_20"], size=(8, 8)).stats.reason
    assert irt.render("x^2*y + z - 0.1", size=(16, 16), eps=1e-12, method="ia").stats.reason == "asked for"


def test_auto_marches_on_where_the_form_decides_little() -> None:
    with pytest.raises(irt.MethodError, match="range of doubles"):
        irt.render("1e280*(x^2 + y^2 + z^2 + 1)^7", bounds=1000, size=(16, 16), method="frustum-newton")
    # All zeros are double: nothing but TOUCH, and no pixel is worth the reference.
    double = irt.render("(x^2 + y^2 + z^2 - 1)^2", bounds=1.2, size=(96, 96))
    marched = irt.render("(x^2 + y^2 + z^2 - 1)^2", bounds=1.2, size=(96, 96), method="contract")
    assert double.stats.counts["TOUCH"] > 1024
    assert (double.status == marched.status).mean() > 0.99


@pytest.mark.parametrize("method", FINDERS)
def test_a_previous_frame_changes_nothing_but_the_order_of_work(method: str) -> None:
    """S2 section 4.2, frame coherence: a camera that moves a little and leaps, a parameter that moves, and a frame in which all is gone."""
    f = "x^4 + y^4 + z^4 - 5*(x^2 + y^2 + z^2) + a"
    previous = None
    for a, origin in ((11, (5, 4, 6)), (11, (5.1, 4, 5.9)), (11, (-4, 5, -6)), (12.4, (-4, 5, -6)), (40, (-4, 5, -6)), (11, (-4, 5, -6))):
        call = {"params": {"a": a}, "bounds": 2.5, "camera": irt.Camera(origin), "size": (61, 40), "method": method}
        plain, seeded = irt.render(f, **call), irt.render(f, **call, previous=previous)
        assert (plain.status == seeded.status).all()
        both = plain.status == Status.HIT
        assert (np.abs(plain.depth[both] - seeded.depth[both]) <= (plain.uncertainty + seeded.uncertainty)[both]).all()
        truth = irt.reference(f, **call)
        _judge(seeded, seeded.depth, truth)
        previous = seeded


def test_a_previous_frame_saves_cuts() -> None:
    call = {"method": "frustum-midpoint", "size": (64, 64), "outputs": ("pieces",), "precision": "double"}
    plain = irt.render(irt.surfaces["barth_decic"], **call)
    assert irt.render(irt.surfaces["barth_decic"], **call, previous=plain).pieces.mean() < plain.pieces.mean()


def test_previous_frames_that_do_not_fit() -> None:
    f, call = irt.parse("x^2 + y^2 + a*z^2 - 1"), {"size": (24, 16), "params": {"a": 1}}
    previous = irt.render(f, method="frustum-lr", **call)
    assert previous.formula == f
    # auto and isovalue, bounds and method may change.
    assert irt.render(f, previous=previous, isovalue=0.5, bounds=1.5, **call).hit.any()
    assert irt.render("sin(x) - y", size=(24, 16), previous=irt.render("sin(x) - y", size=(24, 16))).hit.any()
    with pytest.raises(irt.MethodError, match="frustum-lr"):
        irt.render(f, previous=previous, method="contract", **call)
    with pytest.raises(irt.ArgumentError, match="another formula"):
        irt.render("x^2 + y^2 + z^2 - 1", size=(24, 16), previous=previous)
    with pytest.raises(irt.ArgumentError, match="24 x 16"):
        irt.render(f, previous=previous, **call | {"size": (16, 24)})
    with pytest.raises(irt.ArgumentError, match="must be a Frame"):
        irt.render(f, previous=previous.depth, **call)  # type: ignore[arg-type]


def test_pixels_that_the_reference_decided_are_told() -> None:
    frame = irt.render(irt.surfaces["barth_decic"], size=(64, 64), method="frustum-mr")
    assert 0 < frame.stats.by_reference < frame.stats.escalated
    assert irt.render("x^2 + y^2 + z^2 - 1", size=(16, 16), method="frustum-mr").stats.by_reference == 0


def test_nothing_is_built_twice_for_a_degree() -> None:
    """Not for another polynomial, a moved camera, or a moved slider; the passes in double included."""
    call = {"size": (96, 96), "method": "frustum-newton", "eps": 1e-4}
    decic = irt.render(irt.surfaces["barth_decic"], **call)
    assert decic.stats.escalated > 64
    camera = irt.Camera((-4, 5, 6))
    frames = [irt.render(irt.surfaces["barth_decic"].expr, bounds=1.9, camera=camera, **call)]
    frames += [irt.render("x^10 + a*y^6*z^4 + z^10 - x*y - 0.3", params={"a": a}, camera=camera, **call) for a in (0.5, 3)]
    assert [f.stats.builds for f in frames] == [0, 0, 0]
    assert frames[0].stats.escalated > 64


@pytest.mark.parametrize("method", [n for n in irt.methods() if n.startswith("frustum")])
def test_where_eps_cannot_be_reached_hits_are_wider(method: str) -> None:
    frame = irt.render("x^4 + y^4 + z^4 - 1", size=(32, 32), precision="single", eps=1e-8, method=method, outputs=())
    assert frame.stats.counts["UNRESOLVED"] == 0 and frame.stats.counts["HIT"] > 80
    assert frame.stats.wide > 80


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("method", FINDERS)
def test_what_precision_cannot_tell_from_zero_touches(method: str, precision: str) -> None:
    """The floor of the precision is TOUCH, a spent budget UNRESOLVED (a budget that the caller sets keeps the reference out)."""
    call = {"bounds": 1.5, "method": method, "precision": precision, "eps": 1e-4}
    tangent = [("(x - 0.3)^2 + y", (0, 0, 0.2), (1, 0, 0), 0.3), ("x^2 + y^2 + z^2 - 1", (1, 0, -4), (0, 0, 1), 4), ("x^2 + y^2 - z - x*y^3", (0, 0, 0), (1, 0, 1), 0)]
    for f, origin, direction, t in tangent:
        hits = irt.trace(f, origin, direction, max_pieces=10**6, **call)
        assert hits.status[0] == Status.TOUCH
        assert np.isnan(hits.uncertainty[0]) and abs(hits.t[0] - t) < 0.02
        spent = irt.trace(f, origin, direction, max_pieces=1, **call)
        assert spent.status[0] == Status.UNRESOLVED
        assert spent.t[0] <= t + 1e-6
    # A ray within the surface, from its start on.
    assert irt.trace("z*(x + 3)", (-4, 0, 0), (1, 0, 0), max_pieces=10**6, **call).status[0] == Status.TOUCH
    # Coefficients beyond all reals say nothing.
    assert irt.trace("1e308*(x^2 + y^2 + z^2 + 1)*(x^2 + 9)*(z - x)", (0, 0, 4), (0, 0, -1), max_pieces=10**6, **call).status[0] == Status.UNRESOLVED


@pytest.mark.parametrize("method", FINDERS)
def test_frames_touch_double_surfaces(method: str) -> None:
    call = {"bounds": 1.2, "size": (32, 32), "method": method, "eps": 1e-4}
    truth = irt.reference("x^2 + y^2 + z^2 - 1", bounds=1.2, size=(32, 32))
    for precision in ("single", "double"):
        frame = irt.render("(x^2 + y^2 + z^2 - 1)^2", precision=precision, max_pieces=10**6, **call)
        assert not (frame.status == Status.HIT).any()
        # Off the silhouette all of it is at the floor of the precision. Methods with room for so many knots may have spent it.
        inner = truth.hit & (np.hypot(*np.meshgrid(np.arange(32) - 15.5, np.arange(32) - 15.5)) < 8)
        assert inner.sum() > 50
        assert (frame.status[inner] >= Status.TOUCH).all()
        assert (frame.status[inner] == Status.TOUCH).mean() > (0.8 if "-mr" in method else 0.999)
        assert (np.abs(frame.depth[inner] - truth.depth[inner]) < (0.2 if "-mr" in method else 0.02)).all()
        assert (frame.status == Status.MISS).sum() > 100
        assert frame.stats.by_reference == 0
    assert irt.render("(x^2 + y^2 + z^2 - 1)^2", max_pieces=1, **call).stats.counts["UNRESOLVED"] > 100


@pytest.mark.parametrize("name", ["sphere", "cayley", "barth_sextic", "labs_7", "barth_decic"])
def test_roots_are_refined_in_double(name: str) -> None:
    """Below what single precision resolves it proves brackets, and double narrows each down at once."""
    surface = irt.surfaces[name]
    low, high = surface.bounds.lower, surface.bounds.upper
    eps = 2.0**-21 * max(b - a for a, b in zip(low, high, strict=True))
    frame = irt.render(surface, size=(163, 101), method="frustum-newton", eps=eps)  # packets have lanes past the last column
    truth = irt.reference(surface, camera=frame.camera, size=(163, 101))
    hit, both = frame.status == Status.HIT, (frame.status == Status.HIT) & truth.hit
    assert frame.stats.precision == "single and double"
    assert truth.uncertainty[both].max() <= 1e-11
    _judge(frame, frame.depth, truth)
    assert (2 * frame.uncertainty[hit] <= eps).all() and hit.sum() > 0.98 * truth.hit.sum()
    again = irt.render(surface, size=(163, 101), method="frustum-newton", eps=eps, previous=frame)
    assert (again.status == frame.status).all() and np.abs(again.depth[both] - frame.depth[both]).max() <= eps
    # Few need a pass of their own.
    assert frame.stats.escalated < 0.02 * hit.sum()


def test_small_pictures_are_searched_in_double() -> None:
    """Cells to refine roots by take longer than that there (docs/performance.md)."""
    surface = irt.surfaces["chmutov_8"]
    for size, precision in (((64, 64), "double"), ((128, 128), "single and double")):
        frame = irt.render(surface, size=size, method="frustum-newton", eps=1e-6, outputs=())
        assert frame.stats.precision == precision and frame.stats.wide == 0


@pytest.mark.parametrize("method", ["frustum-newton", "frustum-lr"])
@pytest.mark.parametrize("precision", ["auto", "double"])
def test_brackets_far_from_the_origin_hold_the_roots_of_the_camera_s_rays(precision: str, method: str) -> None:
    """Rays of orthographic views are rounded where they begin, which near silhouettes moves roots by more than brackets are wide."""
    c = 1e8
    f, bounds = "(x - 10^8)^2 + y^2 + (z - 10^8)^2 - 1", ((c - 1.5, c + 1.5), (-1.5, 1.5), (c - 1.5, c + 1.5))
    camera = irt.Camera((c - 4.25, -6.125, c - 3.875), (c, 0, c), projection="orthographic", height=3.2)
    truth = irt.reference(f, bounds, camera, (250, 200))
    frame = irt.render(f, bounds, camera, (250, 200), method=method, precision=precision, eps=2e-6, outputs=())
    hit = frame.status == irt.Status.HIT
    assert (hit & truth.hit).sum() > 10_000 and not ((frame.status == irt.Status.MISS) & truth.hit).any() and not (hit & (truth.kind == irt.Status.MISS)).any()
    both = hit & truth.hit
    assert (truth.bracket[both][:, 1] >= (frame.depth - frame.uncertainty)[both]).all() and (truth.bracket[both][:, 0] <= (frame.depth + frame.uncertainty)[both]).all()
