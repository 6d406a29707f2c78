"""Statuses never lie: seeded formulas that use every operator, against the reference. benchmarks/statuses.py runs many more."""

from __future__ import annotations

import numpy as np
import pytest
from formulas import OPERATORS, check, formula

import implicitrt as irt

# One formula for each operator, each third of them of another kind; the test below keeps them from saying nothing.
SEEDS = [i + len(OPERATORS) * (i % 3) for i in range(len(OPERATORS))]


@pytest.mark.parametrize("seed", SEEDS)
def test_random_formulas(seed: int) -> None:
    mitchell = irt.Mitchell("raa" if seed % 2 else "ia")
    counts = check(formula(seed), 200, seed, ("ia", "raa", "contract", mitchell), (1e-2, 1e-5))
    # Nothing is evaded where f is smooth and all of it is decided by the reference.
    for (method, eps), c in counts.items():
        if c["undecided"] == 0 and method != "raa":
            assert c["hits"] >= 0.98 * c["simple"], f"{method}, eps {eps}: {c}"


def test_pieces_that_cover_only_a_part() -> None:
    """Affine kernels were not made where no case of a Piecewise holds: libFuzzer's smallest input."""
    counts = check("Piecewise((x^2 + y^2 + z^2 - 1, x < y))", 200, 1, ("ia", "raa", "contract", "mitchell"), (1e-3,))
    assert all(c["hits"] > 20 for c in counts.values())


def test_windows_whose_root_is_their_end() -> None:
    """Newton steps make them points, and cannot cut those: the march goes on there. They were cut until the budget was spent."""
    origins, directions = [(3.75, 1.0625, -3.4375), (1.5, 2.8125, 3.5625), (-2.8125, 1.5, 3.5625)], [(-8, -2, 7), (-4, -6, -8), (6, -4, -8)]
    hits = irt.trace("x^2 + y^2 - z^2", origins, directions, bounds=1, method="ia", precision="single", max_pieces=1000)
    assert (hits.status == irt.Status.HIT).all()


@pytest.mark.parametrize("method", ["ia", "contract", "mitchell", "frustum-newton", "analytic"])
@pytest.mark.parametrize("precision", ["single", "double"])
def test_zeros_behind_the_origin(method: str, precision: str) -> None:
    """Their depth is negative; it was 0."""
    hits = irt.trace("x", [(0.5, 0, 0), (0.25, 0, 0.5)], (1, 0.5, 0), tmin=-3, bounds=1, method=method, precision=precision)
    assert np.abs(hits.t - [-0.5, -0.25]).max() < 1e-6 and (hits.status == irt.Status.HIT).all()
    if method != "analytic":
        assert (np.abs(hits.t - [-0.5, -0.25]) <= hits.uncertainty).all() and (hits.uncertainty > 0).all()


def test_forms_keep_the_ranges_of_what_jumps() -> None:
    """Where atan2 jumps it is as wide in the shortest piece, and forms of later squares reached a pole that is not there."""
    f = "(1 + (atan2(z - 3/4 y, atan(x/2 - 2y - 2z + 3/4)))^2)^(-2) + 5/16"
    for method in ("raa", "contract"):
        assert irt.render(f, bounds=1.5, size=(40, 30), method=method, precision="single", outputs=()).stats.counts["MISS"] == 1200


def test_ranges_without_an_end_stay_ranges() -> None:
    """ceiling(log x)/8 has a range only, and so has z less it: its form was infinite at both ends."""
    found = irt.enclose_rays("z - ceiling(log(x))/8", (0, 0, 0), (1, 0, 0), 0, 0.9, algebra="raa")
    assert found[0, 0] > -0.01 and found[0, 1] == np.inf


def test_half_of_the_formulas_have_hits() -> None:
    rng = np.random.default_rng(5)
    o, hits = rng.normal(size=(60, 3)) * 2, 0
    for seed in SEEDS:
        found = irt.reference(formula(seed), o, rng.uniform(-1, 1, (60, 3)) - o, bounds=1.5)
        hits += int(found.hit.sum() > 10)
    assert hits >= len(SEEDS) / 2
