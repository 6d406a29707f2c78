"""Random expressions of every operator, over boxes and pieces of rays: values by MPFR lie inside, IA and RAA meet."""

from __future__ import annotations

import numpy as np
from formulas import OPERATORS
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import implicitrt as irt
from implicitrt import _core

PIECES, INNER = 32, 32

_number = st.integers(-16, 16).map(lambda n: f"{n}/8")
_leaf = st.sampled_from(["x", "y", "z"]) | st.builds(
    "({} x + {} y + {} z + {})".format, _number, _number, _number, _number
)


def _apply(name: str, a: str, b: str) -> str:
    return "(" + OPERATORS[name].format(a=a, b=b) + ")"


_text = st.recursive(
    _leaf, lambda parts: st.builds(_apply, st.sampled_from(sorted(OPERATORS)), parts, parts), max_leaves=5
)


def _value(f: irt.Expr, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Doubles around f at (..., 3) points; nan where f has no value or a jump is too near to tell."""
    known = _core.values(f._node, points.reshape(-1, 3)).reshape(*points.shape[:-1], 2)
    with np.errstate(invalid="ignore", over="ignore"):
        told = (known[..., 0] == known[..., 1]) | (np.nextafter(known[..., 0], np.inf) == known[..., 1])
    return np.where(told, known[..., 0], np.nan), np.where(told, known[..., 1], np.nan)


def _contains(box: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    with np.errstate(invalid="ignore"):
        return bool((np.isnan(low) | ((box[:, :1] <= low) & (high <= box[:, 1:]))).all())


def _meet(a: np.ndarray, b: np.ndarray) -> bool:
    with np.errstate(invalid="ignore"):
        return bool((np.isnan(a[:, 0]) | np.isnan(b[:, 0]) | ((a[:, 0] <= b[:, 1]) & (b[:, 0] <= a[:, 1]))).all())


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True, database=None)
@given(_text, st.integers(0, 2**32 - 1), st.booleans())
@example(" + ".join(_apply(n, "(x - y/2)", "(y + z/4)") for n in sorted(OPERATORS)[::2]), 1, True)
@example(" + ".join(_apply(n, "(x - y/2)", "(y + z/4)") for n in sorted(OPERATORS)[1::2]), 2, True)
def test_enclosures(text: str, seed: int, through: bool) -> None:
    rng = np.random.default_rng(seed)
    # Numbers of few bits, so that points on rays are exact.
    centre = rng.integers(-2048, 2049, (PIECES, 3)) / 1024.0
    half = rng.integers(0, 1025, (PIECES, 3)) / 1024.0 * 2.0 ** -rng.integers(0, 18, (PIECES, 1)).astype(float)
    try:
        f = irt.parse(text)
        if through:  # zero is in range of the first piece
            at, _ = _value(f, centre[:1])
            if np.isfinite(at[0]):
                f = f - float(at[0])
        if not f.free_symbols:
            return
        boxes = {a: irt.enclose(f, centre - half, centre + half, algebra=a).astype(np.float64) for a in ("ia", "raa")}
        end = rng.integers(-64, 65, (PIECES, 2)) / 64.0
        end.sort(axis=1)
        direction = np.where(half == 0, 1.0 / 1024, half)
        rays = {
            a: irt.enclose_rays(f, centre, direction, end[:, 0], end[:, 1], algebra=a).astype(np.float64)
            for a in ("ia", "raa")
        }
    except irt.ExpressionError:
        return  # a constant part without a value
    share = rng.integers(-1024, 1025, (PIECES, INNER, 3)) / 1024.0
    share[:, :2] = np.sign(share[:, :2])  # corners, too
    inner = np.clip(centre[:, None] + share * half[:, None], (centre - half)[:, None], (centre + half)[:, None])
    t = end[:, :1] + np.linspace(0, 1, INNER) * (end[:, 1:] - end[:, :1])
    t = np.clip(np.round(t * 2**20) / 2**20, end[:, :1], end[:, 1:])
    along = centre[:, None] + t[..., None] * direction[:, None]
    for found, points in ((boxes, inner), (rays, along)):
        low, high = _value(f, points)
        for algebra, box in found.items():
            assert _contains(box, low, high), (str(f), algebra, points.shape)
        assert _meet(found["ia"], found["raa"]), str(f)
    if through and np.isfinite(boxes["ia"][0]).all():
        assert (boxes["ia"][0, 0] <= 0 <= boxes["ia"][0, 1]) or np.isnan(_value(f, centre[:1])[0][0])
