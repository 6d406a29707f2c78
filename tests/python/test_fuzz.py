"""A short seeded fuzz: whatever is handed in, only irt.Error (or TypeError) comes out, and the process lives.

scripts/fuzz runs the parser and the operations on formulas under libFuzzer and AddressSanitizer for longer.
"""

from __future__ import annotations

import contextlib
import copy
import math
import pickle
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from formulas import OPERATORS, formula
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import implicitrt as irt

CORPUS = sorted((Path(__file__).parent.parent / "fuzz" / "corpus").iterdir())
WORDS = [
    *"xyzabE0123456789.,()^*/+-=<> ", "**", "<=", "==", "!=", "e5", "1e-400", "1e400", "√", "π", "−", "·", "²", "³", "\0", "\n", "é", "𝔵", "#", "'", "[", "{",
    "sin(", "log(", "atan2(", "Piecewise((", "And(", "True", "Min(", "Mod(", "pi", "lambda", "__import__", "99999999999999999999", "/0", "^-1", "^(1/2)",
]  # fmt: skip


def _text(rng: random.Random) -> str:
    """A formula, mutated or made up."""
    kind = rng.random()
    if kind < 0.2:
        return "".join(rng.choice(WORDS) for _ in range(rng.randint(0, 30)))
    if kind < 0.6 or not CORPUS:
        text = formula(rng.randint(0, 10**6))
    else:
        text = rng.choice(CORPUS).read_bytes().decode(errors="replace")[:400]
    for _ in range(rng.randint(0, 3)):
        i, j = sorted(rng.randint(0, len(text)) for _ in range(2))
        change = rng.randint(0, 3)
        if change == 0:
            text = text[:i] + rng.choice(WORDS) + text[i:]
        elif change == 1:
            text = text[:i] + text[min(j, i + 3) :]
        elif change == 2:
            text = text[:i] + text[i : i + 20] + text[i:]
        else:
            text = text[:i] + rng.choice(WORDS) + text[i + 1 :]
    return text


def _operate(e: irt.Expr, other: irt.Expr, rng: random.Random) -> irt.Expr:
    """One operation, chosen at random."""
    small = rng.choice([-2, -1, 0, 1, 2, 3, irt.Rational(1, 3), 0.1])
    operations: list[Callable[[], irt.Expr]] = [
        lambda: e + other, lambda: e - other, lambda: e * other, lambda: e / other, lambda: e**small, lambda: -e,
        lambda: irt.Min(e, other), lambda: irt.Max(e, small), lambda: irt.Mod(e, other), lambda: irt.atan2(e, other),
        lambda: irt.Piecewise((e, other < small), (other, True)), lambda: e.diff(irt.x), e.simplify, e.expand,
        lambda: e.subs({irt.x: other}), lambda: e.subs({"y": small}), lambda: abs(e), lambda: irt.sqrt(e), lambda: irt.log(e),
    ]  # fmt: skip
    return rng.choice(operations)()


@pytest.mark.parametrize("block", range(8))
def test_text(block: int) -> None:
    rng = random.Random(block)
    read = 0
    known: list[irt.Expr] = [irt.x]
    for _ in range(250):
        text = _text(rng)
        try:
            e = irt.parse(text)
            read += 1
        except irt.Error:
            continue
        with contextlib.suppress(irt.Error, TypeError):
            for _ in range(3):
                e = _operate(e, rng.choice(known), rng)
            assert irt.parse(str(e)) == e, text
            assert pickle.loads(pickle.dumps(e)) == e and copy.deepcopy(e) == e
            e.degree(), e.free_symbols, hash(e), e.latex if hasattr(e, "latex") else None
            known = [*known[-20:], e]
    assert read > 50


def test_every_operator_takes_odd_arguments() -> None:
    odd: list[Any] = [
        None,
        "x +",
        "",
        b"x",
        [],
        {},
        object(),
        math.nan,
        math.inf,
        1j,
        np.array([1.0, 2.0]),
        True,
        10**400,
        irt.x < 1,
        irt,
    ]
    names = [
        "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "cbrt", "Abs", "sign", "floor", "ceiling",
        "Min", "Max", "Mod", "atan2", "Piecewise", "Rational", "sympify", "parse", "symbols", "Surface", "Sphere", "explain", "kernel_source",
    ]  # fmt: skip
    for name in names:
        function = getattr(irt, name, None)
        for a in odd if function else ():
            for arguments in ((a,), (a, irt.x), (irt.x, a), (a, a)):
                with contextlib.suppress(irt.Error, TypeError):
                    function(*arguments)
    assert len(OPERATORS) > 30


_anything = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.text(max_size=8),
    st.binary(max_size=4),
    st.lists(st.floats(), max_size=4),
    st.tuples(st.floats(), st.floats(), st.floats()),
    st.sampled_from(
        [np.zeros((2, 3)), np.zeros((0, 3)), np.zeros((3, 2)), np.full(3, np.nan), np.array(["a"]), np.array([None]), np.zeros((1, 1, 3)), object(), 1j, {}]
    ),
)  # fmt: skip


def _only_errors(call: Callable[[], Any]) -> None:
    with np.errstate(all="ignore"), contextlib.suppress(irt.Error, TypeError):
        call()


def _some(names: list[str]) -> st.SearchStrategy[dict[str, Any]]:
    return st.dictionaries(st.sampled_from(names), _anything, min_size=1, max_size=2)


_settings = settings(
    max_examples=150, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
)


@_settings
@given(
    _some(
        [
            "bounds", "camera", "method", "eps", "params", "device", "precision", "rounding", "isovalue", "max_pieces", "time_limit", "outputs", "color",
            "back_color", "light", "background", "unresolved_color",
        ]
    )
)  # fmt: skip
def test_render(arguments: dict[str, Any]) -> None:
    _only_errors(
        lambda: irt.render("x^2 + y^2 + a z", **({"params": {"a": 1}, "size": (4, 3), "max_pieces": 999} | arguments))
    )


@_settings
@given(_anything)
def test_size(size: Any) -> None:
    if isinstance(size, (tuple, list)) and len(size) == 2 and all(isinstance(n, float) and n < 1e4 for n in size):
        size = tuple(min(n, 64) for n in size)
    _only_errors(lambda: irt.render("x", size=size, bounds=1))


@_settings
@given(
    _some(["origins", "directions", "tmin", "tmax", "bounds", "method", "eps", "params", "precision", "isovalue"]),
)
def test_trace(arguments: dict[str, Any]) -> None:
    usual = {"origins": (0, 0, 3), "directions": (0, 0, -1), "bounds": 2, "max_pieces": 999}
    _only_errors(lambda: irt.trace("x^2 + y^2 + z^2 - 1", **(usual | arguments)))


@_settings
@given(_some(["lower", "upper", "algebra", "params", "precision", "rounding"]), st.booleans())
def test_enclose(arguments: dict[str, Any], swapped: bool) -> None:
    usual = {"lower": (-1, 0, 0), "upper": (1, 1, 1)}
    _only_errors(lambda: irt.enclose("x y / z", **(usual | arguments)))


@_settings
@given(_some(["origin", "target", "up", "fov", "projection", "height"]))
def test_camera(arguments: dict[str, Any]) -> None:
    def draw() -> None:
        camera = irt.Camera(**({"origin": (0, 0, 5)} | arguments))
        frame = irt.render("x^2 + y^2 + z^2 - 1", camera=camera, size=(5, 4), bounds=2, max_pieces=999)
        assert frame.rgb.shape == (4, 5, 3)

    _only_errors(draw)


def test_what_fuzzing_found() -> None:
    inverse = (1 / irt.x) ** -2
    assert str(inverse) == "(1/x)**(-2)" and irt.parse(str(inverse)) == inverse
    assert str(0 * irt.x**2 * irt.log(irt.x)) == "0*log(x)"
    with pytest.raises(irt.LimitError, match="pairs"):
        irt.parse("(a - (y - 2) v - 3)^61").expand()  # half a minute, once
