"""Inclusion of the derivative along a ray, by which roots are isolated: its values by MPFR lie within its enclosures, in both algebras
and precisions, for random formulas of every operator.

One kernel holds a few formulas of x and y: a Piecewise over z, as in operators.py. Pieces of rays are exact in single precision, so that
nothing but what is tested needs room.
"""

from __future__ import annotations

import numpy as np
import pytest
from formulas import OPERATORS, formula
from operators import Array, combined

import implicitrt as irt
from implicitrt import _core
from implicitrt.enclose import _enclose_request

PIECES, POINTS, GROUP = 160, 6, 5
SEEDS = range(len(OPERATORS))  # one formula for each operator, with others in it
# And what none of them has: monomials of one coordinate that can cancel, a divisor that varies.
MORE = ("x^7 - 3 x^6 + 2 x^5 - x/3 + y", "Mod(3 x, 2 + y)/2 + y^2")
STEPS = ("floor", "ceiling", "sign")


def _formulas() -> list[irt.Expr]:
    """Of x and y."""
    return [irt.parse(f).subs({irt.z: irt.x / 2 - irt.y}) for f in (*map(formula, SEEDS), *MORE)]


def _rays(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Middles, directions and half lengths: sums of two of them are exact in single precision."""
    half = 2.0 ** -rng.integers(0, 8, PIECES)
    return rng.integers(-1400, 1400, (PIECES, 2)) / 1024, rng.integers(-255, 256, (PIECES, 2)) / 128, half


def _axis(middle: Array, reach: Array, spread: Array, algebra: str) -> Array:
    """(N, 3) coordinates of pieces of one axis: a form, or the ends of its range."""
    if algebra == "raa":
        return np.stack([middle, reach, spread], axis=-1)
    away = np.abs(reach) + spread
    return np.stack([middle - away, middle + away, np.zeros_like(middle)], axis=-1)


@pytest.mark.parametrize("group", range(-(-(len(SEEDS) + len(MORE)) // GROUP)))
def test_derivatives_contain_their_values(group: int) -> None:
    formulas = _formulas()[group * GROUP : (group + 1) * GROUP]
    f = combined(tuple(map(str, formulas)))
    rng = np.random.default_rng(group)
    middle, direction, half = _rays(rng)
    # Directions are known to within as much as this; some of them exactly.
    spread = np.where(rng.random((PIECES, 1)) < 0.5, 0.0, rng.integers(0, 9, (PIECES, 2)) / 64)
    e = rng.integers(-16, 17, (POINTS, PIECES)) / 16
    e[0], e[1] = -1, 1
    off = rng.integers(-4, 5, (POINTS, PIECES, 2)) / 4
    at = middle + (e * half)[..., None] * direction
    along = direction + off * spread
    shape = (len(formulas), POINTS, PIECES)
    least, most = np.zeros(shape), np.zeros(shape)
    for k, g in enumerate(formulas):
        points = np.concatenate([at.reshape(-1, 2), np.zeros((at.shape[0] * PIECES, 1))], axis=1)
        parts = [_core.values(g.diff(v)._node, points).reshape(POINTS, PIECES, 2) * along[..., i, None] for i, v in enumerate((irt.x, irt.y))]
        least[k], most[k] = sum(p.min(-1) for p in parts), sum(p.max(-1) for p in parts)
        slack = 1e-15 * sum(np.abs(p).max(-1) for p in parts) + 1e-300
        least[k], most[k] = least[k] - slack, most[k] + slack
    known = 0
    for algebra in ("ia", "raa"):
        for precision in ("single", "double"):
            request = _enclose_request(f, f, algebra, None, precision, "outward", None)
            xy = [_axis(middle[:, i], half * direction[:, i], np.zeros(PIECES), algebra) for i in (0, 1)]
            moves = [_axis(direction[:, i], np.zeros(PIECES), spread[:, i], algebra) for i in (0, 1)]
            nothing = np.zeros((PIECES, 3))
            which = [_axis(np.full(PIECES, float(k)), np.zeros(PIECES), np.zeros(PIECES), algebra) for k in range(len(formulas))]
            request["pieces"] = np.concatenate([np.concatenate([*xy, z], axis=1) for z in which])
            request["directions"] = np.tile(np.concatenate([*moves, nothing], axis=1), (len(formulas), 1))
            box = _core.enclose_pieces(f._node, request).reshape(len(formulas), 1, PIECES, 2)
            told = np.isfinite(least) & ~np.isnan(box[..., 0])
            known += int(told.sum())
            bad = told & ((box[..., 1] < least) | (box[..., 0] > most))
            assert not bad.any(), (algebra, precision, str(formulas[np.argwhere(bad)[0][0]]), np.argwhere(bad)[0])
    assert known > 0.3 * 4 * least.size
