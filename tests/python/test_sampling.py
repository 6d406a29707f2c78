"""Methods that sample (S3, S4): how often they are right, what they miss, and that they say so."""

from __future__ import annotations

import numpy as np
import pytest
from formulas import check, formula

import implicitrt as irt
from implicitrt import Status

METHODS = [name for name, m in irt.methods().items() if m.guarantee == "sampled"]
SIGN = [m for m in METHODS if "taylor" not in m]
TAYLOR = [m for m in METHODS if "taylor" in m]
# Of the pixels: what may be missed or found elsewhere at the steps that methods take by themselves. The worst is 0.09 %.
TOLERANCE = 0.002
SIZE = (48, 48)


def _judge(frame: irt.Frame, truth: irt.Reference) -> None:
    assert not frame.stats.proven and frame.stats.guarantee == "sampled"
    assert np.isnan(frame.uncertainty).all()
    assert not ((frame.status == Status.HIT) & (truth.kind == Status.MISS)).any()
    assert (truth.hit & (frame.status == Status.MISS)).mean() <= TOLERANCE
    both = frame.hit & truth.hit
    assert (np.abs(frame.depth[both] - truth.depth[both]) > frame.bounds.default_eps).mean() <= TOLERANCE


def _ray(f: str, method: object, **keywords: object) -> irt.Hits:
    """From x = -2 to x = 2, along the axis y = 1/3, z = 1/7."""
    return irt.trace(f, (-2, 1 / 3, 1 / 7), (1, 0, 0), tmax=4, method=method, **keywords)  # type: ignore[arg-type]


def test_all_of_the_papers() -> None:
    assert METHODS == ["marching-sign", "marching-taylor", "adaptive-sign", "adaptive-taylor", "sampled-newton"]
    for method in (irt.Marching(), irt.Marching("taylor"), irt.Marching(adaptive=True), irt.Marching("taylor", True), irt.SampledNewton()):
        assert _ray("x - 1/2", method).status == [Status.HIT]
        assert "steps" in irt.methods()[method.name].options


@pytest.mark.parametrize("name", ["barth_sextic", "torus", "blobby_molecule"])
@pytest.mark.parametrize("method", METHODS)
def test_frames_agree_with_the_reference(method: str, name: str) -> None:
    surface = irt.surfaces[name]
    _judge(irt.render(surface, size=SIZE, method=method), irt.reference(surface, size=SIZE))


@pytest.mark.parametrize("method", METHODS)
def test_widths_and_precisions(method: str) -> None:
    surface = irt.surfaces["tangle"]
    truth = irt.reference(surface, size=SIZE)
    for device in (":1", None):
        _judge(irt.render(surface, size=SIZE, method=method, device=device), truth)
        fine = irt.render(surface, size=SIZE, method=method, device=device, eps=1e-10)
        # What single precision does not resolve is done in double, all of it, once.
        assert fine.stats.precision == "double" and fine.stats.escalated == 0
        _judge(fine, truth)
        both = fine.hit & truth.hit
        assert np.abs(fine.depth[both] - truth.depth[both]).max() <= 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_thin_features_are_missed_with_few_steps_and_found_with_more(method: str) -> None:
    f = "1/10^6 - (x - 1/2)^2"  # above zero for a two thousandth of the ray
    assert (_ray(f, method, steps=4000).status == Status.HIT).all()
    if method in SIGN:
        assert (_ray(f, method, steps=7).status == Status.MISS).all()
    assert _ray("x - 1/2", method, steps=1).t == pytest.approx(2.5, abs=1e-3)


def test_double_sheets_have_no_change_of_sign_but_tangents_that_lead_to_zero() -> None:
    f = "(x^2 + y^2 + z^2 - 1)^2"
    truth = _ray(f, "contract").t[0]
    for method in METHODS:
        hits = _ray(f, method)
        if method in SIGN:
            assert (hits.status == Status.MISS).all()
        else:
            assert (hits.status == Status.TOUCH).all()
            assert hits.t[0] == pytest.approx(truth, abs=2e-3)
        # A near miss is none, as far as eps tells.
        assert (_ray(f + " + 1/10^4", method).status == Status.MISS).all()


# Along x from -2 to 2: formula, status, and t where there is a root.
ALONG_X = [
    ("1/x", Status.MISS, 0.0), ("1/(x - 1/9)^3", Status.MISS, 0.0), ("1/x + 2", Status.HIT, 1.5), ("1/x - 2", Status.HIT, 2.5),
    ("tan(2 x) - 10", Status.HIT, 2 + (np.arctan(10) - np.pi) / 2), ("floor(x) + 1/3", Status.TOUCH, 2.0), ("sign(x - 1/5)", Status.TOUCH, 2.2),
    ("Piecewise((x - 3, x < 1), (1, True))", Status.TOUCH, 3.0), ("Piecewise((x + 3, x < 0), (x - 3, True))", Status.TOUCH, 2.0), ("log(x) + 1/2", Status.HIT, 2 + np.exp(-0.5)),
    ("sqrt(x - 1) - 1/2", Status.HIT, 3.25), ("cbrt(x - 1/3)", Status.HIT, 7 / 3), ("tanh(10^5 (x - 1/3))", Status.HIT, 7 / 3),
    ("sqrt((x - 1)(x + 1)) + sign(1/2 - x)", Status.HIT, 2 + np.sqrt(2)),  # undefined between -1 and 1
    # Zeros that samples meet exactly, and those at the ends.
    ("Max(Abs(x) - 1/10, 0)", Status.TOUCH, 1.9), ("Max(x - 1/10, 0) + Min(x + 1/10, 0)", Status.HIT, 1.9), ("Max(0, x)", Status.TOUCH, 0.0),
    ("Min(0, x)", Status.TOUCH, 2.0), ("x + 2", Status.TOUCH, 0.0), ("x - 2", Status.TOUCH, 4.0),
]  # fmt: skip
@pytest.mark.parametrize("method", METHODS)
def test_poles_jumps_gaps_and_zeros_on_samples(method: str) -> None:
    # One kernel for all: each formula has its own y.
    f = "Piecewise(" + ", ".join(f"({c}, y < {i + 1})" for i, (c, _, _) in enumerate(ALONG_X)) + ", (1, True))"
    origins = [(-2, i + 0.5, 0) for i in range(len(ALONG_X))]
    hits = irt.trace(f, origins, (1, 0, 0), tmax=4, method=method, eps=1e-4)
    for (c, status, t), found, at in zip(ALONG_X, hits.status, hits.t, strict=True):
        assert found == status, c
        assert status == Status.MISS or at == pytest.approx(t, abs=0.05), c  # plateaus are met at samples


@pytest.mark.parametrize("method", METHODS)
def test_roots_outside_the_clip_region_are_passed_by(method: str) -> None:
    bounds = [1.3, irt.Sphere((0, 0, 0), 1.25), irt.HalfSpace((0, 0, 1), 0.6), irt.Clip("1/4 - x^2 - a y^2")]
    keywords: dict[str, object] = {"bounds": bounds, "size": SIZE, "params": {"a": 1}}
    f = "x^2 + y^2 + z^2 - 1"
    _judge(irt.render(f, method=method, **keywords), irt.reference(f, **keywords))  # type: ignore[arg-type]
    if method in TAYLOR:
        double = irt.render(f"({f})^2", method=method, **keywords)  # type: ignore[arg-type]
        assert (double.status == irt.reference(f"({f})^2", **keywords).kind).mean() >= 1 - TOLERANCE  # type: ignore[arg-type]


def test_kernels_sample_and_nothing_else() -> None:
    for method in METHODS:
        text = irt.kernel_source("x^2 + sin(y) - z^4", method, outputs=())
        assert not any(word in text for word in ("interval.cl", "affine.cl", "form.cl", "typedef IA", "enclose(", "normal.cl", "F irt_region"))
        assert ("irt_gradient" in text) == method.startswith("adaptive")
    assert "F irt_region" in irt.kernel_source("x", "marching-sign", bounds=[1, irt.Clip("y")])


def test_steps_are_arguments() -> None:
    irt.render("x - a", method="marching-sign", params={"a": 0.1}, size=(16, 16))
    again = irt.render("x - a", method="marching-sign", params={"a": 0.2}, size=(16, 16), steps=50)
    assert again.stats.builds == 0
    with pytest.raises(irt.ArgumentError, match="steps are for methods that sample"):
        irt.render("x", method="raa", steps=10)
    with pytest.raises(irt.ArgumentError, match="twice"):
        irt.render("x", method=irt.Marching(steps=5), steps=10)
    for wrong in (0, -1, 2.5, True, "10", 1 << 30):
        with pytest.raises(irt.ArgumentError, match="steps must be"):
            irt.render("x", method="marching-sign", steps=wrong)  # type: ignore[arg-type]
        with pytest.raises(irt.ArgumentError, match="steps must be"):
            irt.SampledNewton(steps=wrong)  # type: ignore[arg-type]
    for build in (lambda: irt.Marching("both"), lambda: irt.Marching(adaptive=2), lambda: irt.Bisection(stack=True)):  # type: ignore[arg-type]
        with pytest.raises(irt.ArgumentError):
            build()


def test_a_spent_budget_is_unresolved() -> None:
    assert (_ray("x - 1", "marching-sign", max_pieces=20).status == Status.UNRESOLVED).all()


def test_compare_counts_what_is_missed() -> None:
    f = "(x^2 + y^2 + z^2 - 1)^2"
    chart = irt.compare(f, ["marching-sign", "marching-taylor", "contract"], 1e-2, (24, 24), runs=1)
    missed = {p.method: p.wrong_misses for p in chart}
    assert missed["marching-sign"] > 10 and missed["marching-taylor"] == missed["contract"] == 0
    assert "marching-sign" not in {p.method for p in chart.pareto(next(iter(chart)).formula)}


def test_bisection_with_a_stack() -> None:
    surface = irt.surfaces["barth_sextic"]
    truth, frames = irt.reference(surface, size=SIZE), {}
    for method in ("ia", irt.Bisection("ia", stack=True)):
        frame = frames[method] = irt.render(surface, size=SIZE, method=method, eps=1e-4)
        assert frame.stats.proven and (frame.status == truth.kind).all() and frame.stats.wide == 0
    for seed in (3, 17, 24, 38, 59, 77):  # a pole, a jump, an edge of a domain, a clip formula's operators
        check(formula(seed), 120, seed, ("ia-stack",), (1e-2, 1e-5))
    clipped = {"bounds": [1.5, irt.Clip("x - y")], "size": SIZE}
    found = irt.render("x^2 + y^2 + z^2 - 1", method="ia-stack", **clipped)
    assert (found.status == irt.reference("x^2 + y^2 + z^2 - 1", **clipped).kind).mean() > 0.99
    fast = irt.render(surface, size=SIZE, method="ia-stack", rounding="fast")
    assert not fast.stats.proven and not (truth.hit & (fast.status == Status.MISS)).any()
