"""Statuses never lie: seeded formulas that use every operator, against the reference. benchmarks/statuses.py runs many more."""

from __future__ import annotations

import numpy as np
import pytest
from formulas import OPERATORS, check, formula

import implicitrt as irt
from implicitrt import Status

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


@pytest.mark.parametrize("method", ["auto", "contract", "raa", "ia", "ia-stack", "mitchell"])
def test_coefficients_below_the_smallest_float(method: str) -> None:
    """Of (x / 10^5)^10, 1e-50 is no float, and the term is half of what there is."""
    f = "(x/100000)^10 + (x/100000)^2 + x/100000 - 5/2"
    call = {"origins": (-2e5, 0, 0), "directions": (1, 0, 0), "bounds": 1e5}
    truth = irt.reference(f, **call)
    for precision in ("single", "double", "auto"):
        found = irt.trace(f, **call, method=method, precision=precision)
        assert found.status[0] != Status.MISS
        if found.status[0] == Status.HIT:
            assert abs(found.t[0] - truth.depth[0]) <= found.uncertainty[0] + 1e-6


@pytest.mark.parametrize("precision", ["single", "double", "auto"])
@pytest.mark.parametrize("method", ["ia", "raa", "ia-stack", "contract", irt.Mitchell("ia"), irt.Mitchell("raa")])
def test_roots_at_the_start_are_not_passed_over(method: object, precision: str) -> None:
    """f is positive behind its zero at the start of the ray, or has another one there."""
    for f in ("x*exp(-4*x)", "x^3 - 3*x^2 + 3*x", "sin(3*x) + y*y*x", "x*(2 + sin(9*x))", "x*(1/2 - x)", "x - 700*x^2", "sinh(x) - x^2"):
        for eps in (0.3, 0.1, 1e-3, 1e-5):
            found = irt.trace(f, (0, 0.1, 0.2), (1, 0.1, 0.2), bounds=1.125, method=method, precision=precision, eps=eps)
            assert found.hit[0] and (found.status[0] != Status.HIT or found.t[0] - found.uncertainty[0] <= 0), (f, eps)


@pytest.mark.parametrize("method", ["reference", "ia", "contract", "mitchell"])
def test_rays_of_one_point_in_a_zero(method: str) -> None:
    """Nothing is left to be divided: the search of a bracket around it went on for ever."""
    ray = {"origins": (0, -0.625, -0.125), "directions": (1, 0, 0.5), "tmin": 0.5, "tmax": 0.5, "bounds": 1.125}
    found = irt.reference("sin(x - 1/2)", **ray) if method == "reference" else irt.trace("sin(x - 1/2)", **ray, method=method, precision="double")
    assert (found.kind if method == "reference" else found.status)[0] != Status.MISS


@pytest.mark.parametrize("method", ["auto", "contract", "raa", "ia", irt.Contraction(beams=True)])
@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
def test_boxes_far_from_the_origin(method: object, projection: str) -> None:
    """In single precision coordinates err by more than the box is wide, so that no plane cut the rays, and f was asked where it overflows."""
    c, f = 1e6, "sqrt(Abs((x - 10^6)*(y - 10^6)*(z - 10^6))) - 1/200"
    camera = irt.Camera((c + 0.375, c + 0.25, c + 0.625), (c, c, c), fov=40, projection=projection, height=0.375)
    bounds = ((c - 0.125, c + 0.125),) * 3
    truth = irt.reference(f, bounds, camera, (16, 16))
    assert truth.hit.sum() > 20
    for precision in ("single", "auto"):
        frame = irt.render(f, bounds, camera, (16, 16), method=method, precision=precision, outputs=())
        assert not (truth.hit & (frame.status == Status.MISS)).any(), precision


@pytest.mark.parametrize("method", ["contract", "raa", "ia"])
def test_rays_from_too_far_are_open(method: str) -> None:
    """They may lie anywhere in the bounds: contraction had a MISS where f overflows, and TOUCH at depths beyond all bounds."""
    f, far = "sqrt(Abs(x*y*z)) - 1/4", 2.0**73
    found = irt.trace(f, [(0.5, 0.5, far), (0.5 + far, 0.5 + far, 0.75)], [(0, 0, -1), (-1, -1, 0)], bounds=1.5, method=method, precision="double")
    assert (found.status == Status.UNRESOLVED).all() and (found.t == 0).all()
    frame = irt.render("sqrt(Abs(x*y*z)) - 4/10^9", 0.0015, irt.Camera((3e12, 2e12, 9e12), projection="orthographic", height=0.003), (9, 9), method=method, outputs=())
    assert not frame.stats.counts["MISS"] and not frame.stats.counts["TOUCH"]
