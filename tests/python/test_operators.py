"""Inclusion of every operator against MPFR, on every driver, narrow and wide, both algebras and precisions.

10^5 arguments on the best driver at its full width; 4000 on each of the others. benchmarks/operators.py takes more.
"""

from __future__ import annotations

import numpy as np
import pytest
from conftest import working_devices
from operators import OPERATORS, Array, arguments, check, references

MANY, FEW = 100_000, 4_000
COMBINATIONS = [(algebra, precision) for precision in ("single", "double") for algebra in ("ia", "raa")]
Truth = tuple[Array, dict[str, Array]]


@pytest.fixture(scope="module")
def truth() -> Truth:
    """The arguments and the one set of references."""
    points = arguments(MANY, seed=4)
    return points, references(points)


def _others() -> list[str]:
    found = working_devices()
    narrow = [f"{d.driver}:1" for d in found]
    return narrow + [f"{d.driver}:{d.width}" for d in found[1:]]


@pytest.mark.parametrize("algebra, precision", COMBINATIONS)
def test_best_driver(truth: Truth, algebra: str, precision: str) -> None:
    best = working_devices()[0]
    compared, bad = check(*truth, algebra, precision, f"{best.driver}:{best.width}")
    assert not bad, bad[:5]
    assert compared > 0.7 * MANY * len(OPERATORS)  # elsewhere the operator has no value


@pytest.mark.parametrize("choice", _others())
def test_other_drivers_and_widths(truth: Truth, choice: str) -> None:
    points, known = truth
    some = {formula: values[:FEW] for formula, values in known.items()}
    for algebra, precision in COMBINATIONS:
        _, bad = check(points[:FEW], some, algebra, precision, choice, thorough=False)
        assert not bad, (algebra, precision, bad[:5])


def test_without_padding_values_are_lost(truth: Truth) -> None:
    points, known = truth
    some = {formula: values[:FEW] for formula, values in known.items()}
    best = working_devices()[0]
    for algebra, precision in COMBINATIONS[:2]:
        lost = {
            v.formula
            for v in check(points[:FEW], some, algebra, precision, best.driver, rounding="fast", thorough=False)[1]
        }
        assert lost >= {"x + y", "x*y", "sin(x)", "exp(x)", "3*x/y", "atan2(x, y)"}, lost


def test_one_huge_lane_spoils_no_other() -> None:
    """PoCL's sin of a packet of floats is wrong for small lanes beside one past 2^23."""
    import implicitrt as irt

    at = np.full(16, 0.0014)
    at[5] = 1e30
    for name in ("sin", "cos", "tan"):
        for algebra in ("ia", "raa"):
            corner = np.stack([at, 0 * at, 0 * at], axis=-1)
            low, high = irt.enclose(f"{name}(x)", corner, corner, algebra=algebra).astype(np.float64).T
            value = getattr(np, name)(0.0014)
            assert (np.delete(low, 5) <= value).all() and (value <= np.delete(high, 5)).all(), (
                name,
                algebra,
                low,
                high,
            )
