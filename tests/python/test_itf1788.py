"""Interval test vectors in the portable ITL format: for every operator that we have, the enclosure contains what is expected.

The vectors are read where they lie (IMPLICITRT_TEST_DATA/itf1788). Vectors with empty inputs, which `enclose` cannot take,
and decorated ones are left out; their number is checked, so that none disappears unnoticed.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt

FORMULAS = {
    "neg": "-x", "add": "x + y", "sub": "x - y", "mul": "x*y", "div": "x/y", "recip": "1/x", "sqr": "x^2", "sqrt": "sqrt(x)",
    "fma": "x*y + z", "pow": "x^y", "exp": "exp(x)", "log": "log(x)", "sin": "sin(x)", "cos": "cos(x)", "tan": "tan(x)",
    "asin": "asin(x)", "acos": "acos(x)", "atan": "atan(x)", "atan2": "atan2(x, y)", "sinh": "sinh(x)", "cosh": "cosh(x)",
    "tanh": "tanh(x)", "sign": "sign(x)", "ceil": "ceiling(x)", "floor": "floor(x)", "abs": "Abs(x)", "min": "Min(x, y)", "max": "Max(x, y)",
}  # fmt: skip
VECTOR = re.compile(r"^\s*(\w+)\s+(.*?)\s*=\s*(\[[^\]]*\])\s*;")


def _interval(text: str) -> tuple[float, float] | None:
    body = text.strip()[1:-1].strip()
    if body == "empty":
        return None
    if body == "entire":
        return (-np.inf, np.inf)
    low, high = (p.strip() for p in body.split(","))
    return (_number(low), _number(high))


def _number(text: str) -> float:
    if "x" in text.lower():
        return float.fromhex(text)
    return float(text.replace("infinity", "inf"))


def _vectors(folder: Path) -> dict[str, list[tuple[list[tuple[float, float]], tuple[float, float] | None]]]:
    """By formula: the inputs and the expected range of each vector."""
    found: dict[str, list[tuple[list[tuple[float, float]], tuple[float, float] | None]]] = {}
    for file in sorted(folder.glob("*.itl")):
        for line in file.read_text().splitlines():
            match = VECTOR.match(line)
            if not match or "]_" in line or "nai" in line:
                continue
            op, arguments, expected = match.groups()
            inputs = [_interval(a) for a in re.findall(r"\[[^\]]*\]", arguments)]
            if any(i is None for i in inputs):
                continue
            if op == "pown":
                power = int(arguments.split("]")[1].strip(" ,"))
                formula = f"x^({power})"
            elif op in FORMULAS:
                formula = FORMULAS[op]
            else:
                continue
            found.setdefault(formula, []).append(([i for i in inputs if i is not None], _interval(expected)))
    return found


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("algebra", ["ia", "raa"])
def test_vectors(external: Path, algebra: str, precision: str) -> None:
    vectors = _vectors(external / "itf1788")
    count, bad = 0, []
    for formula, cases in vectors.items():
        low = np.zeros((len(cases), 3))
        high = np.zeros((len(cases), 3))
        for i, (inputs, _) in enumerate(cases):
            for axis, (a, b) in enumerate(inputs):
                low[i, axis], high[i, axis] = a, b
        if formula in ("x^(0)", "x^(1)"):
            continue  # the constant 1, and x itself
        result = irt.enclose(formula, low, high, algebra=algebra, precision=precision).astype(np.float64)
        for (inputs, expected), got in zip(cases, result, strict=True):
            count += 1
            if expected is not None and not (got[0] <= expected[0] and expected[1] <= got[1]):
                bad.append(f"{formula} of {inputs}: {got.tolist()} lacks {expected}")
    assert not bad, f"{len(bad)} of {count}:\n" + "\n".join(bad[:20])
    assert count > COUNT, count


COUNT = 2800
