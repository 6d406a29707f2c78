"""Statuses never lie: random formulas of kinds that have lied, along rays that have been lied about, against the reference.

test_statuses.py has a formula for every operator and rays at random. Here rays are parallel to axes, begin on lattice points (which are zeros, poles and edges of many of the
formulas), count from and to given places, and have directions of all lengths; boxes lie far from the origin, and parameters are those at which operators change.
"""

from __future__ import annotations

import random

import numpy as np
import pytest
from formulas import believe

import implicitrt as irt

SEED = 0  # that notices the products of what is never negative when they lose their care (interval.cl)
METHODS = ["auto", "contract", "raa", "ia", "ia-stack", irt.Mitchell("ia"), irt.Mitchell("raa")]
PARAMETERS = [0.0, 1.0, -1.0, 0.5, 2.0, 1e-60, -1e-40, 1e30]
POLYNOMIALS = ["x", "y", "z", "(x - y/2 + 1/4)", "(y + z - 1/2)", "(x y - z)", "(x^2 + y^2 - 3/4)", "(x^2 + y^2 + z^2 - 1)", "(z^3 - x)", "k", "(x - k y)"]

# What parts are put together by; {a} and {b} are parts, {c} a number.
KINDS = {
    "quotients": ["{a}/({b})", "{a} + 1/({b})", "1/({a} + {c}/({b}))", "({a})^(-2) - {b}", "tan({a}) + {b}", "Abs({a})/({b})", "{a}/(({b})^2 + 1/100)"],
    "never negative": ["({a})^2 (({b})^2 + 1/8)", "(({a})^2 + 1/(1 + 100 ({b})^2)) ({b} + {c})^2", "Abs({a}) exp({b})", "(1 + 1/({a})^2) (1 + 1/({b})^2)", "(1 + 1/({a})^2) ({b})^2",
                       "(({a})^24 + ({b})^2) ({a} - {c})^2", "(({a})^2 + Abs({a}/({b}))) (({b})^2 + ({a} + {c})^2)"],
    "powers": ["({a})^7", "(Abs({a}))^(3/2) - {b}", "(({a})^2)^(1/3)", "(({a})^2 + 1/8)^({b})", "sqrt({a} + {c}) + {b}", "({a})^21 + {b}", "cbrt({a} {b})", "({a} + {b})^4"],
    "choices": ["Max({a}, {b})", "Min({a}, {b}, {c})", "Abs({a}) - {b}", "{a} + {b} + sqrt(({a})^2 + ({b})^2)", "Piecewise(({a}, {b} < {c}), ({b}, True))",
                "Piecewise(({a}, And({a} >= 0, {b} < 1)), ({b}, Not({a} > {c})))", "Piecewise(({a}, Eq(floor({b}), 0)), ({a} - {c}, True))"],
    "steps": ["floor({a}) + {b}", "Mod({a}, {c}) + {b}", "sign({a}) {b}", "atan2({a}, {b})", "Mod({a}, 1 + ({b})^2)", "ceiling(2 {a})/({b})", "log({a}) + sign({b})"],
    "waves": ["sin(9 {a}) + {b}", "exp(-({a})^2) - Abs({b})/2", "cos({a} {b})", "asin({a}/2) {b}", "tanh({a}) - atan({b})", "log(({a})^2 + 1/8) {b}"],
}  # fmt: skip


def _formula(rng: random.Random, kind: str) -> str:
    parts = [rng.choice(POLYNOMIALS) for _ in range(4)]
    for _ in range(rng.randint(1, 3)):
        a, b = rng.sample(parts, 2)
        parts.append("(" + rng.choice(KINDS[kind]).format(a=a, b=b, c=rng.choice(["1/2", "(-1/2)", "1", "2"])) + ")")
    return f"{parts[-1]} - {rng.randint(-6, 6)}/8"


def _rays(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    lattice = rng.random(count) < 0.5
    through = np.where(lattice[:, None], rng.integers(-4, 5, (count, 3)) / 4, rng.uniform(-1, 1, (count, 3)))
    direction = np.where(lattice[:, None], rng.integers(-1, 2, (count, 3)) * (rng.random((count, 3)) < 0.6), rng.normal(size=(count, 3)))
    direction[~direction.any(axis=1)] = (0, 0, -1)
    origin = through - rng.choice([0, 0, 0.5, 4], (count, 1)) * direction
    length = np.where(rng.random(count) < 0.5, 1.0, 2.0 ** rng.integers(-20, 21, count))
    near = np.where(rng.random(count) < 0.2, rng.integers(-4, 17, count) / 4 / length, 0)
    far = np.where(rng.random(count) < 0.1, near + rng.integers(0, 17, count) / 4 / length, np.inf)
    return origin, direction * length[:, None], near, far


@pytest.mark.parametrize("kind", KINDS)
def test_awkward_rays(kind: str) -> None:
    rng, seen = random.Random(f"{kind} {SEED}"), 0
    for _ in range(4):
        f, methods = _formula(rng, kind), rng.sample(METHODS, 2)
        params = {"k": rng.choice(PARAMETERS)} if "k" in f else None
        # Moved with its box, by numbers that rays and boxes keep.
        off = rng.choice([0, 0, 0, 1000, 2**17])
        moved = irt.parse(f).subs({name: irt.parse(f"{name} - {off}") for name in "xyz"})
        origin, direction, near, far = _rays(np.random.default_rng(rng.getrandbits(32)), 150)
        call = {"tmin": near, "tmax": far, "bounds": ((off - 1.25, off + 1.25),) * 3, "params": params}
        truth = irt.reference(moved, origin + off, direction, time_limit=2, **call)
        seen += int(truth.hit.sum())
        for method in methods:
            precision, eps = rng.choice(["single", "double", "auto"]), 2.0 ** -rng.randint(5, 18)
            hits = irt.trace(moved, origin + off, direction, method=method, precision=precision, eps=eps, **call)
            believe(hits, truth, f"{f!r}, {params}, off {off}, {method}, {precision}, eps {eps:g}")
    assert seen > 40
