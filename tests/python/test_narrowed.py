"""Bounds that are wider than the surface: methods that march by enclosures look at the part that may hold zeros, and answer the same."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt

METHODS = ["contract", "raa", "ia", "ia-stack", "mitchell"]
BALL = "x^8 + y^8 + z^8 - r"
CAMERA = irt.Camera((2, 1.5, 3))


@pytest.mark.parametrize("method", METHODS)
def test_loose_bounds_cost_few_pieces(method: str) -> None:
    def looks(bounds: float) -> float:
        frame = irt.render(BALL, params={"r": 1}, bounds=bounds, camera=CAMERA, size=(48, 48), method=method, eps=1e-3, precision="single", outputs=("pieces",))
        return float(frame.pieces.mean())

    assert looks(7.9) < 1.1 * looks(1.05)


@pytest.mark.parametrize("method", ["contract", "ia"])
def test_a_parameter_that_moves_builds_nothing(method: str) -> None:
    frames = [irt.render(BALL, params={"r": r}, bounds=3, camera=CAMERA, size=(48, 48), method=method) for r in (1, 0.01, 200)]
    assert [f.stats.builds for f in frames[1:]] == [0, 0]
    assert len({f.stats.counts["HIT"] for f in frames}) == 3


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("formula", "bounds"),
    [
        # Two parts far apart, a part on the face of the bounds, a domain that ends, a ball instead of a box, a plane beside the surface, a clip formula.
        ("Min(x^2 + y^2 + z^2 - 1/16, (x - 3)^2 + (y - 3)^2 + (z - 3)^2 - 1/16)", 4),
        ("(x - 2)^2 + y^2 + z^2 - 1", 2),
        ("sqrt(x) + y^2 + z^2 - 1/2", 2),
        ("x^6 + y^6 + z^6 - 1/64", irt.Sphere((0.25, 0, 0), 2)),
        ("x^6 + y^6 + z^6 - 1/64", [3, irt.HalfSpace((0, 0, 1), 0.25)]),
        ("x^6 + y^6 + z^6 - 1/64", [3, irt.Clip("x + y - 1/4")]),
    ],
)
def test_answers_are_those_of_the_reference(formula: str, bounds: object, method: str) -> None:
    camera = irt.Camera((5, 4, 7), target=(1, 1, 1) if bounds == 4 else (0, 0, 0))
    frame = irt.render(formula, bounds=bounds, camera=camera, size=(40, 30), method=method)
    reference = irt.reference(formula, bounds, camera, (40, 30))
    assert (frame.status == irt.Status.HIT).sum() >= 5
    decided = (frame.status == irt.Status.HIT) | (frame.status == irt.Status.MISS)
    assert (frame.status == reference.kind)[decided].all() and decided.mean() > 0.99
    hit = frame.status == irt.Status.HIT
    assert (np.abs(frame.depth[hit] - reference.depth[hit]) <= frame.uncertainty[hit]).all()


def test_batches_are_narrowed_too() -> None:
    origins, directions = (a.reshape(-1, 3) for a in CAMERA.rays((48, 48)))
    frame = irt.render(BALL, params={"r": 1}, bounds=6, camera=CAMERA, size=(48, 48), method="contract", eps=1e-3)
    hits = irt.trace(BALL, origins, directions, params={"r": 1}, bounds=6, method="contract", eps=1e-3)
    assert (hits.status == frame.status.ravel()).all()
