"""Seeded random formulas that between them use every operator, for tests of what statuses say."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

import implicitrt as irt
from implicitrt import Status

# name: text with {a} and {b} for arguments of about unit size, within its domain most of the time.
OPERATORS = {
    "add": "({a} + {b})", "subtract": "({a} - {b})", "multiply": "{a} {b}", "divide": "{a}/(2 + {b})", "pole": "{a}/({b} + 1/3)",
    "square": "({a})^2", "cube": "({a})^3", "power": "({a})^6", "odd": "({a})^7", "inverse": "(1 + ({a})^2)^(-2)", "sqrt": "sqrt(Abs({a}) + {b}^2)",
    "clipped": "sqrt(1 + {a})", "rational": "(1 + ({a})^2)^(3/7)", "real": "(1/2 + ({a})^2)^(1 + {b}/4)", "cbrt": "cbrt({a})", "exp": "exp({a})",
    "log": "log(3/2 + ({a})^2)", "undefined": "log(1 + {a})", "sin": "sin(3 {a})", "cos": "cos(2 {a} + {b})", "tan": "tan({a}/2)", "asin": "asin({a}/2)",
    "acos": "acos({a}/3)", "atan": "atan(2 {a})", "atan2": "atan2({a}, 2 + {b})", "turn": "atan2({a}, {b})", "sinh": "sinh({a})", "cosh": "cosh({a})",
    "tanh": "tanh(2 {a})", "abs": "Abs({a})", "sign": "sign({a})/3", "floor": "floor(2 {a})/4", "ceiling": "ceiling(2 {a})/4",
    "mod": "Mod({a}, 1)", "min": "Min({a}, {b})", "max": "Max({a}, {b}, 1/4)",
    "piecewise": "Piecewise(({a}, {b} > 0), ({a} + {b}/2, True))", "cases": "Piecewise(({a}, And({b} > 0, {a} < 1/2)), ({b}, Or({a} <= 0, Not({b} < -1/2))), (1/2, True))",
}  # fmt: skip


def _argument(rng: random.Random, depth: int) -> str:
    if depth > 0 and rng.random() < 0.45:
        name = rng.choice(sorted(OPERATORS))
        return "(" + OPERATORS[name].format(a=_argument(rng, depth - 1), b=_argument(rng, depth - 1)) + ")"
    c = [rng.randint(-4, 4) for _ in range(3)]
    if not any(c):
        return rng.choice("xyz")
    return f"({c[0]}/4 x + {c[1]}/4 y + {c[2]}/4 z + {rng.randint(-3, 3)}/8)"


def formula(seed: int) -> str:
    """The formula of that seed; the seeds 0, 1, 2, ... go through the operators in turn."""
    rng = random.Random(seed)
    name = sorted(OPERATORS)[seed % len(OPERATORS)]
    part = OPERATORS[name].format(a=_argument(rng, 2), b=_argument(rng, 1))
    kind = seed // len(OPERATORS) % 3
    if kind == 0:  # a dented ball: many hits, silhouettes
        return f"x^2 + y^2 + z^2 - 1 + {rng.randint(1, 4)}/8 {part}"
    if kind == 1:  # a graph
        return f"{rng.choice('xyz')} - {part}/2"
    return f"{part} - {rng.randint(-6, 6)}/16"


def believe(hits: irt.Hits, truth: irt.Reference, where: str) -> None:
    """Asserts that no status of `hits` contradicts the reference along the same rays."""

    def never(what: str, lies: np.ndarray) -> None:
        rays = np.flatnonzero(lies)
        assert not len(rays), f"{what}: {where}: ray {rays[0]}: t {hits.t[rays[0]]} +- {hits.uncertainty[rays[0]]}, reference {truth.bracket[rays[0]]}"

    found, proven = truth.hit, hits.status == Status.HIT
    low, high = hits.t - hits.uncertainty, hits.t + hits.uncertainty
    never("wrong MISS", found & (hits.status == Status.MISS))
    never("wrong HIT", (truth.kind == Status.MISS) & proven)
    with np.errstate(invalid="ignore"):
        never("bracket without its root", proven & found & ((truth.bracket[:, 1] < low) | (truth.bracket[:, 0] > high)))
        # No zero lies before the piece that the reference leaves open.
        never("HIT before any zero", proven & (truth.kind == Status.UNRESOLVED) & (high < truth.bracket[:, 0]))
        never("UNRESOLVED behind a root", (hits.status == Status.UNRESOLVED) & found & (truth.bracket[:, 1] < hits.t))


def check(
    f: str, size: int, seed: int, methods: tuple[Any, ...], widths: tuple[float, ...], bounds: Any = 1.5
) -> dict[tuple[Any, float], dict[str, int]]:
    """Statuses of `size` rays through f, against the reference; asserts that none lies.

    Returns counts for each method and eps: of rays, simple (the reference's HITs), hits (HIT among them), unresolved, undecided
    (by the reference).
    """
    rng = np.random.default_rng(seed)
    origins = rng.normal(size=(size, 3))
    origins *= 4 / np.linalg.norm(origins, axis=1)[:, None]
    directions = rng.uniform(-1.1, 1.1, (size, 3)) - origins
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    truth = irt.reference(f, origins, directions, bounds=bounds)
    counts = {}
    for method in methods:
        for eps in widths:
            hits = irt.trace(f, origins, directions, bounds=bounds, method=method, eps=eps)
            where = f"{f!r}, bounds {bounds}, {method}, eps {eps:g}"
            believe(hits, truth, f"{where}, seed {seed}")
            proven = hits.status == Status.HIT
            simple = truth.kind == Status.HIT
            counts[method, eps] = {
                "rays": size, "simple": int(simple.sum()), "hits": int((simple & proven).sum()),
                "unresolved": int((hits.status == Status.UNRESOLVED).sum()), "undecided": int((truth.kind == Status.UNRESOLVED).sum()),
            }  # fmt: skip
    return counts


# Whose terms cancel.
CANCEL = "(x + y)**2*(x - y)*(x + 1000) - (x**3 + 1000*x**2 + x**2*y + 1000*x*y - x*y**2 - 1000*y**2 - y**3 - 1000*y**2)*(x + y) + z/100000"


def composed(rng: np.random.Generator, rules: tuple[str, ...]) -> str:
    """A formula made by a few of the rules, texts with {a} and {b}."""
    parts = ["x", "y", "z", "(x + 2*y - z/7)", "(z - 1/3)"]
    for _ in range(int(rng.integers(3, 8))):
        a, b = (parts[int(k)] for k in rng.integers(0, len(parts), 2))
        parts.append(rules[int(rng.integers(len(rules)))].format(a=a, b=b))
    return f"{parts[-1]} + {parts[-2]}"
