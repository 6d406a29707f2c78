"""Inclusion: enclosures contain the values at inner points, for every operator, algebra, precision and width."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import implicitrt as irt

OPERATORS = [
    "x + y", "x - y", "x*y", "x/y", "x^2", "x^3", "x^7", "x^8", "x^-2", "sqrt(x)", "cbrt(x)", "x^(3/2)", "x^(-1/3)", "Abs(x)^y", "exp(x)",
    "log(x)", "sinh(x)", "cosh(x)", "tanh(x)", "sin(x)", "cos(x)", "tan(x)", "asin(x)", "acos(x)", "atan(x)", "atan2(x, y)", "Abs(x)",
    "sign(x)", "floor(x)", "ceiling(x)", "Min(x, y)", "Max(x, y)", "Mod(x, y)", "Piecewise((x, x < y), (y^2, True))", "2.3*x + 0.1", "pi - x",
    "x*y*z - x*y + 3", "Abs(x - y)", "atan2(x - y, x)", "Mod(x, y + 3)", "Max(x^2, y)", "Min(sin(x), cos(y))", "1/(x^2 + y^2)", "log(x^2 + 1/4)",
    "tanh(3*x + y)", "cbrt(x*y)", "(x^2 + 1/10)^(y/2)", "x^(7/3)", "Piecewise((sin(x), y > 0), (x^3, z > 0), (exp(x), True))", "asin(sin(x)*0.9)", "acos(x/(1 + x^2))",
    "x^7 - 3*x^5 + x/3 - 1", "128*x^8 - 256*x^6 + 160*x^4 - 32*x^2 + y^9 - y^4/7 + 0.1*y",
]  # fmt: skip


def _boxes(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Boxes of all sizes: scales from 1e-6 to 1e4, widths from points to wide, some with exact ends."""
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-6, 4, (count, 3))
    scale[: count // 2] = 10.0 ** rng.uniform(-1, 1, (count // 2, 3))
    centre = rng.uniform(-1, 1, (count, 3)) * scale
    width = scale * 10.0 ** rng.uniform(-6, 0.5, (count, 3)) * (rng.random((count, 3)) > 0.1)
    low, high = (centre - width).astype(np.float32), (centre + width).astype(np.float32)
    return low.astype(np.float64), high.astype(np.float64)


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("algebra", ["ia", "raa"])
@pytest.mark.parametrize("formula", OPERATORS)
def test_operators_contain_their_values(formula: str, algebra: str, precision: str) -> None:
    f = irt.parse(formula)
    low, high = _boxes(7, 1500)
    box = irt.enclose(f, low, high, algebra=algebra, precision=precision).astype(np.float64)
    rng = np.random.default_rng(8)
    for k in range(12):
        share = rng.random(low.shape) if k > 2 else np.full(low.shape, k / 2)
        p = low + share * (high - low)
        with np.errstate(all="ignore"):
            value = f.evaluate(*p.T)
        slack = 4e-15 * np.abs(value) + 1e-300  # the host's own rounding
        known = np.isfinite(value)
        inside = (box[:, 0] <= value + slack) & (value - slack <= box[:, 1])
        bad = known & ~inside
        assert not bad.any(), (formula, p[bad][0], value[bad][0], box[bad][0])


def test_widths_and_drivers_agree(device: str) -> None:
    f = irt.parse("sin(x)*exp(y)/(1 + z^2) + Max(x, y)^3 - sqrt(Abs(z))")
    low, high = _boxes(3, 500)
    box = irt.enclose(f, low, high, device=device).astype(np.float64)
    value = f.evaluate(*(0.5 * (low + high)).T)
    known = np.isfinite(value)
    slack = 4e-15 * np.abs(value)
    assert ((box[:, 0] <= value + slack) & (value - slack <= box[:, 1]))[known].all()


def test_known_ranges() -> None:
    assert irt.enclose("x^2", [-1, 0, 0], [2, 0, 0])[0] == pytest.approx([0, 4], abs=1e-5)
    whole = irt.enclose("1/x", [-1, 0, 0], [1, 0, 0])[0]
    assert whole[0] == -np.inf and whole[1] == np.inf
    assert np.isnan(irt.enclose("sqrt(x)", [-2, 0, 0], [-1, 0, 0])).all()
    assert np.isnan(irt.enclose("log(x)", [-2, 0, 0], [-1, 0, 0], algebra="raa")).all()
    clipped = irt.enclose("sqrt(x)", [-2, 0, 0], [4, 0, 0])[0]
    assert clipped[0] == 0 and clipped[1] == pytest.approx(2, abs=1e-5)
    product = irt.enclose("x*y", [-np.inf, 0, 0], [np.inf, 0, 0], algebra="raa")[0]
    assert product[0] <= 0 <= product[1]  # infinity times zero
    endless = irt.enclose("x + 1", [0, 0, 0], [np.inf, 0, 0])[0]
    assert endless[0] <= 1 and endless[1] == np.inf


def test_rays_follow_the_dependence() -> None:
    loose = irt.enclose_rays("x - y", [0, 0, 0], [1, 1, 0], 0, 1, algebra="ia")[0]
    tight = irt.enclose_rays("x - y", [0, 0, 0], [1, 1, 0], 0, 1, algebra="raa")[0]
    assert loose[1] - loose[0] > 1.9 and tight[1] - tight[0] < 1e-5


@pytest.mark.parametrize(
    "call",
    [
        lambda: irt.enclose("x", [1, 0, 0], [0, 0, 0]),
        lambda: irt.enclose("x", [np.nan, 0, 0], [0, 0, 0]),
        lambda: irt.enclose_rays("x", [0, 0, 0], [1, 0, 0], 1, 0),
        lambda: irt.enclose_rays("x", [0, 0, 0], [0, 0, 0], 0, 1),
        lambda: irt.enclose("x", [0, 0], [1, 1]),
        lambda: irt.enclose("x", [0, 0, 0], [1, 1, 1], algebra="aa"),
    ],
)
def test_bad_boxes_are_refused(call) -> None:
    with pytest.raises(irt.ArgumentError):
        call()


LEAVES = (
    st.sampled_from([irt.x, irt.y, irt.z]) | st.integers(-3, 3).map(irt.sympify) | st.floats(-2, 2).map(irt.sympify)
)


def _grow(children):
    unary = [
        irt.sin,
        irt.cos,
        irt.exp,
        irt.Abs,
        irt.atan,
        irt.tanh,
        irt.floor,
        irt.sqrt,
        irt.cbrt,
        lambda e: e**2,
        lambda e: e**3,
        lambda e: -e,
    ]
    pair = [lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, irt.Min, irt.Max]
    return st.builds(lambda f, a: f(a), st.sampled_from(unary), children) | st.builds(
        lambda f, a, b: f(a, b), st.sampled_from(pair), children, children
    )


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(st.recursive(LEAVES, _grow, max_leaves=6), st.integers(0, 1000))
def test_random_expressions(f: irt.Expr, seed: int) -> None:
    low, high = _boxes(seed, 32)
    low, high = np.clip(low, -4, 4), np.clip(high, -4, 4)
    try:
        boxes = {a: irt.enclose(f, low, high, algebra=a).astype(np.float64) for a in ("ia", "raa")}
    except irt.ExpressionError:
        return  # a constant part without a value
    rng = np.random.default_rng(seed)
    for _ in range(8):
        p = low + rng.random(low.shape) * (high - low)
        with np.errstate(all="ignore"):
            value = f.evaluate(*p.T)
        slack = 1e-9 * np.abs(value) + 1e-12
        for algebra, box in boxes.items():
            bad = np.isfinite(value) & ~((box[:, 0] <= value + slack) & (value - slack <= box[:, 1]))
            assert not bad.any(), (str(f), algebra, p[bad][0], value[bad][0], box[bad][0])


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("formula", OPERATORS)
def test_forms_contain_their_values_along_rays(formula: str, precision: str) -> None:
    """Slopes matter here: pieces of rays of all lengths, from far below a rounding to far above any range."""
    f = irt.parse(formula)
    rng = np.random.default_rng(9)
    n = 3000
    scale = 10.0 ** np.where(rng.random((n, 1)) < 0.6, rng.uniform(-1, 0.7, (n, 1)), rng.uniform(-5, 3, (n, 1)))
    o, d = rng.uniform(-1, 1, (n, 3)) * scale, rng.normal(size=(n, 3)) * scale
    length = 10.0 ** rng.uniform(-8, 0.3, n) * (rng.random(n) > 0.05)
    for algebra in ("raa", "ia"):
        box = irt.enclose_rays(f, o, d, 0, length, algebra=algebra, precision=precision).astype(np.float64)
        for k in range(12):
            t = length * (k / 2 if k < 3 else rng.random(n))
            p = o + t[:, None] * d
            with np.errstate(all="ignore"):
                value = f.evaluate(*p.T)
                # What rounding the point can do to the value, by differences.
                near = [f.evaluate(*(p * (1 + s)).T) for s in (3e-16, -3e-16)]
                slack = 4e-15 * np.abs(value) + 1e-300 + 4 * sum(np.abs(v - value) for v in near)
            known = np.isfinite(value) & np.isfinite(slack)
            bad = known & ~((box[:, 0] <= value + slack) & (value - slack <= box[:, 1]))
            assert not bad.any(), (formula, algebra, o[bad][0], d[bad][0], length[bad][0], value[bad][0], box[bad][0])


@pytest.mark.parametrize("formula", ["exp(60x) - 7", "cosh(60x) - 7", "sinh(60x) + y"])
def test_forms_keep_the_end_that_did_not_overflow(formula: str) -> None:
    assert irt.enclose_rays(formula, [2, 0, 0], [1, 0, 0], 0, 1, algebra="raa")[0, 0] > 1e30


@pytest.mark.parametrize("algebra", ["ia", "raa"])
@pytest.mark.parametrize(
    "formula",
    ["exp(-x^2 - 3*y^2)", "exp(Min(-Abs(x)*y^2, z)) - exp(-x^4*z^2)", "y*exp(-x^2 - 1)", "exp(-sqrt(x^2 + 1) - (y - z)^2)", "exp(Max(-x^2, -y^2 - 2))"],
)
def test_exponentials_of_what_is_never_positive_do_not_overflow(formula: str, algebra: str) -> None:
    """Wide forms of the exponent reach far above zero, where the kernel, made for values that stay small, must not look."""
    rng = np.random.default_rng(4)
    middle, half = rng.normal(size=(2000, 3)) * 10.0 ** rng.uniform(-2, 2.5, (2000, 1)), 10.0 ** rng.uniform(-6, 2.5, (2000, 3))
    box = irt.enclose(formula, middle - half, middle + half, algebra=algebra).astype(np.float64)
    assert np.isfinite(box).all() and np.abs(box / np.abs(middle).max(axis=1, keepdims=True)).max() < 1e7
    f = irt.parse(formula)
    for _ in range(16):
        value = f.evaluate(*(middle + rng.uniform(-1, 1, (2000, 3)) * half).T)
        assert ((box[:, 0] <= value + 1e-12) & (value - 1e-12 <= box[:, 1])).all()


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize(
    "formula", ["(x^24 + y^2)*z^2", "(x^2 + 1/(1 + 100*y^2))*z^2", "(x^2 + tan(y)^2)*z^2", "(x^2 + x^2/(1 + y^2))*(z^2 + 1/100)", "(x^2 + Abs(y/z))*(z^2 + y^2)", "(1 + 1/x^2)*(1 + 1/y^2)",
                "exp(x)*(1 + x^2/y^2)*(1 + y^2/x^2)"]
)
def test_forms_of_what_is_never_negative_may_be(formula: str, precision: str) -> None:
    """Their ranges reach below zero, where the product of two that are said not to be negative is cut off at its wrong ends."""
    rng = np.random.default_rng(4)
    n = 1000
    origins, directions = rng.uniform(-1.5, 1.5, (n, 3)), rng.normal(size=(n, 3))
    start = rng.uniform(-1, 0, n)
    end = start + 10 ** rng.uniform(-3, 0.3, n)
    bounds = irt.enclose_rays(formula, origins, directions, start, end, precision=precision).astype(np.float64)
    expr = irt.parse(formula)
    for share in np.linspace(0, 1, 21):
        values = expr.evaluate(*(origins + (start + share * (end - start))[:, None] * directions).T)
        slack = 1e-9 * (1 + np.abs(values))
        with np.errstate(invalid="ignore"):
            assert not ((values < bounds[:, 0] - slack) | (values > bounds[:, 1] + slack)).any()


@pytest.mark.parametrize("algebra", ["ia", "raa"])
@pytest.mark.parametrize("formula", ["x - 10^320", "x^3 + x - 10^320*x^6", "Max(x - 10^320, -10^310)"])
def test_constants_below_all_doubles(formula: str, algebra: str) -> None:
    """Their nearest double was nan, and drivers refused the kernel."""
    for precision in ("single", "double"):
        low, high = irt.enclose(formula, [0.5, 0, 0], [1, 0, 0], algebra=algebra, precision=precision)[0]
        assert low == -np.inf and high >= -np.finfo(np.float64).max
