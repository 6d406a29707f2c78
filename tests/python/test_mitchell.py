"""Mitchell's method (S3) in both algebras: what its derivatives bring, and what they cannot isolate."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Status

BOTH = [irt.Mitchell("ia"), irt.Mitchell("raa")]
SIZE = (40, 40)


def _ray(f: str, method: object, **keywords: object) -> irt.Hits:
    """From x = -2 to x = 2, along the axis y = 1/3, z = 1/7."""
    return irt.trace(f, (-2, 1 / 3, 1 / 7), (1, 0, 0), tmax=4, method=method, **keywords)  # type: ignore[arg-type]


@pytest.mark.parametrize("method", BOTH)
@pytest.mark.parametrize("name", ["barth_sextic", "steiner", "sin_blob", "superquadric"])
def test_widths_and_precisions_agree_with_the_reference(name: str, method: irt.Mitchell) -> None:
    surface = irt.surfaces[name]
    truth = irt.reference(surface, size=SIZE)
    for device, precision, eps in ((":1", "single", 1e-3), (None, "single", 1e-3), (None, "double", 1e-9)):
        frame = irt.render(surface, size=SIZE, method=method, device=device, precision=precision, eps=eps)
        assert frame.stats.proven and frame.stats.method == "mitchell" and frame.stats.algebra == method.algebra
        assert not ((truth.kind == Status.HIT) & (frame.status != Status.HIT)).any()
        assert not ((truth.kind == Status.MISS) & frame.hit).any()
        hit = (frame.status == Status.HIT) & truth.hit
        assert (np.abs(frame.depth - truth.depth)[hit] <= frame.uncertainty[hit] + 1e-12).all()
    assert frame.stats.wide == 0


@pytest.mark.parametrize("method", BOTH)
def test_digits_cost_little_once_a_root_is_isolated(method: irt.Mitchell) -> None:
    def pieces(m: object, eps: float) -> float:
        frame = irt.render(irt.surfaces["barth_sextic"], size=SIZE, method=m, precision="double", eps=eps, outputs=("pieces",))
        assert frame.stats.wide == 0
        return float(frame.pieces.mean())

    assert pieces(method, 1e-10) <= 1.25 * pieces(method, 1e-3)
    assert pieces("raa", 1e-10) >= 1.5 * pieces("raa", 1e-3)  # as bisection's do not


# Along x from -2 to 2: formula, status, and t where there is a root.
ALONG_X = [
    ("x", Status.HIT, 2.0), ("x - 1", Status.HIT, 3.0), ("x - 2", Status.TOUCH, 4.0), ("x + 2", Status.TOUCH, 0.0),  # on ends of pieces
    ("x^3", Status.HIT, 2.0), ("(x - 1/3)^3", Status.HIT, 7 / 3), ("(x - 1/3)^2", Status.TOUCH, 7 / 3), ("(x - 1/3)^2 + 1/10^4", Status.MISS, 0.0),
    ("1/x", Status.UNRESOLVED, 2.0), ("1/x + 2", Status.HIT, 1.5), ("tan(2 x) - 10", Status.HIT, 2 + (np.arctan(10) - np.pi) / 2),
    ("sign(x - 1/5)", Status.TOUCH, 2.2), ("Piecewise((x + 3, x < 0), (x - 3, True))", Status.TOUCH, 2.0), ("log(x) + 1/2", Status.HIT, 2 + np.exp(-0.5)),
    ("sqrt(x - 1) - 1/2", Status.HIT, 3.25), ("cbrt(x - 1/3)", Status.HIT, 7 / 3), ("Abs(x) - 1/9", Status.HIT, 2 - 1 / 9),
    ("Min(x, 3 x)", Status.HIT, 2.0), ("Max(x - 1/10, 0)", Status.TOUCH, 0.0), ("10^6 x (x - 1/10^4)", Status.HIT, 2.0),
]  # fmt: skip


@pytest.mark.parametrize("method", BOTH)
def test_roots_of_every_kind(method: irt.Mitchell) -> None:
    # One kernel for all: each formula has its own y.
    f = "Piecewise(" + ", ".join(f"({c}, y < {i + 1})" for i, (c, _, _) in enumerate(ALONG_X)) + ", (1, True))"
    hits = irt.trace(f, [(-2, i + 0.5, 0) for i in range(len(ALONG_X))], (1, 0, 0), tmax=4, bounds=99, method=method, eps=1e-5)
    for (c, status, t), found, at in zip(ALONG_X, hits.status, hits.t, strict=True):
        assert found == status, c
        assert status == Status.MISS or at == pytest.approx(t, abs=1e-4), c
    assert _ray("1/(x - 1/9)", method).status == [Status.MISS]  # whose numerator is seen, where it is no case of a Piecewise


@pytest.mark.parametrize("method", BOTH)
def test_clip_regions_need_the_bracket_inside(method: irt.Mitchell) -> None:
    keywords = {"bounds": [1.5, irt.Clip("x - y/2")], "size": SIZE}
    f = "x^2 + y^2 + z^2 - 1"
    frame, truth = irt.render(f, method=method, **keywords), irt.reference(f, **keywords)  # type: ignore[arg-type]
    assert not (truth.hit & (frame.status == Status.MISS)).any() and not ((truth.kind == Status.MISS) & (frame.status == Status.HIT)).any()
    assert (frame.status == truth.kind).mean() > 0.99
    fast = irt.render(f, method=method, rounding="fast", **keywords)  # type: ignore[arg-type]
    assert not fast.stats.proven and (fast.status == truth.kind).mean() > 0.98


@pytest.mark.parametrize("method", BOTH)
def test_powers_without_a_rule_for_their_derivative(method: irt.Mitchell) -> None:
    f = "(x + 3)^(1 + 1/10^20) - 7/2"
    assert "IA irt_along" not in irt.kernel_source(f, method) and "IA irt_along" in irt.kernel_source("x^2 - y", method)
    hits = _ray(f, method)
    assert hits.status == [Status.HIT] and hits.t[0] == pytest.approx(2.5, abs=1e-3)


def test_its_algebra() -> None:
    assert irt.Mitchell() == irt.Mitchell("raa") and irt.render("x", method="mitchell", size=(8, 8)).stats.algebra == "raa"
    for method in BOTH:
        assert ("---- affine.cl" in irt.kernel_source("x^2*y - z", method)) == (method.algebra == "raa")
    with pytest.raises(irt.ArgumentError, match="algebra"):
        irt.Mitchell("aa")
