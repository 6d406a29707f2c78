"""R-functions (S4): what they mean, how they are recognised, and what csg-analytic makes of trees of them."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Expr, Rational, Status
from implicitrt.set_operations import set_form

x, y, z = irt.symbols("x y z")


def _ball(cx: object, cy: object, cz: object, r: object) -> Expr:
    return irt.sympify(r) ** 2 - (x - cx) ** 2 - (y - cy) ** 2 - (z - cz) ** 2


A, B, C, SLAB = _ball(0, 0, 0, 1), _ball(Rational(1, 2), Rational(1, 3), 0, Rational(3, 4)), _ball(0, 0, Rational(9, 10), Rational(1, 2)), Rational(3, 10) - y
HALVES = [irt.Min(s * x, 1 - s * x, 1 - y, 1 + y, 1 - z, 1 + z) for s in (1, -1)]
TREES = {
    "union": (irt.r_union(A, B), irt.Max(A, B)),
    "intersection": (irt.r_intersection(A, B), irt.Min(A, B)),
    "subtraction": (irt.r_subtraction(A, B), irt.Min(A, -B)),
    "nested": (irt.r_intersection(irt.r_subtraction(irt.r_union(A, C), B), SLAB), irt.Min(irt.Max(A, C), -B, SLAB)),
    "monomial": (irt.r_intersection(A, 2 * x), irt.Min(A, 2 * x)),
    "negated": (-irt.r_union(A, -C), irt.Min(-A, C)),
    "mixed": (irt.Max(irt.r_subtraction(A, B), irt.Min(C, SLAB)), irt.Max(irt.Min(A, -B), irt.Min(C, SLAB))),
    "shifted": (1 - 2 * irt.Max(-A, y - Rational(4, 10)), irt.Min(1 + 2 * A, Rational(18, 10) - 2 * y)),
    "quartic": (irt.r_subtraction(1 - x**4 - y**4 - z**4, _ball(0, 0, 0, Rational(21, 20))), irt.Min(1 - x**4 - y**4 - z**4, -_ball(0, 0, 0, Rational(21, 20)))),
    "same leaf": (irt.Max(A, irt.Min(A, B)), irt.Max(A, irt.Min(A, B))),
    "common face": (irt.Max(*HALVES), irt.Max(*HALVES)),
}  # fmt: skip


@pytest.mark.parametrize("name", TREES)
def test_trees(name: str) -> None:
    f, plain = TREES[name]
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 2000))
    # The same solid, and so recognised.
    for g in (plain, set_form(f, None)):
        assert (np.sign(f.evaluate(*points)) == np.sign(g.evaluate(*points))).all()
    truth = irt.reference(plain, size=(40, 40), bounds=1.6)
    decided = truth.kind != Status.UNRESOLVED
    for precision in ("single", "auto"):
        frame = irt.render(f, size=(40, 40), bounds=1.6, method="csg-analytic", precision=precision)
        assert (frame.hit == truth.hit)[decided].mean() >= 0.999
        both = frame.hit & truth.hit
        assert np.quantile(np.abs(frame.depth[both] - truth.depth[both]), 0.99) < 1e-5
    # Normals are those of the leaf that shows.
    judge = irt.render(plain, size=(40, 40), bounds=1.6, method="contract")
    both = (frame.status == Status.HIT) & (judge.status == Status.HIT)
    assert np.quantile((frame.normal * judge.normal).sum(-1)[both], 0.03) > 1 - 1e-4


def test_signs_follow_the_convention_of_s4() -> None:
    inside_a, inside_b, nowhere = (-0.9, 0.0, 0.0), (1.1, 0.4, 0.0), (0.0, 0.0, 1.4)
    for point, union, both, difference in ((inside_a, 1, -1, 1), (inside_b, 1, -1, -1), (nowhere, -1, -1, -1), ((0.3, 0.2, 0.0), 1, 1, -1)):
        assert np.sign(irt.r_union(A, B).evaluate(*point)) == union
        assert np.sign(irt.r_intersection(A, B).evaluate(*point)) == both
        assert np.sign(irt.r_subtraction(A, B).evaluate(*point)) == difference


def test_r_functions_take_what_render_takes() -> None:
    assert irt.r_union("x", 1) == irt.parse("x + 1 + sqrt(x^2 + 1)")


def test_faces_inside_a_union_touch() -> None:
    """Two halves of a box share a face, on which Max of them is zero and keeps its sign; seen from within it comes first."""
    hits = irt.trace(irt.Max(*HALVES), (0.5, 0.1, 0.2), (-1, 0, 0), bounds=1.6, method="csg-analytic")
    assert hits.status[0] == Status.TOUCH
    assert abs(hits.t[0] - 0.5) < 1e-6


def test_tangent_leaves() -> None:
    """A ray along which a leaf only touches zero, and the tree with it."""
    f = irt.Max(1 - y**2 - z**2, -5 - x)
    hits = irt.trace(f, (-2, 1, 0), (1, 0, 0), bounds=2, method="csg-analytic", precision="double")
    assert hits.hit[0]
    hits = irt.trace(irt.Max(x**2 + Rational(1, 100) - y**2, -1 - z), (-2, 0.1, 0), (1, 0, 0), bounds=2, method="csg-analytic", precision="double")
    assert hits.status[0] == Status.TOUCH
    assert abs(hits.t[0] - 2) < 1e-6
