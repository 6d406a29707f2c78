"""Where eps is below what single precision resolves, it proves brackets and double narrows them down: by a second pass, or at once (test_refine.py)."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt

EPS = 1e-7
SIZE = (83, 61)  # packets have lanes past the last column
SCENES = {
    "sphere": ("x^2 + y^2 + z^2 - 1.0625", 2),
    "waves": ("sin(1.25*x) + cos(y)*z - x^2", 2),
    "quotients": ("sin(1.25*x) + cos(y)*z/(x + 4)*4 - x^2", 2),  # whose values in double have no bound: these take a second pass
    "corners": ("Max(Abs(x) - 1.0625, Abs(y) - z/2, z - 1.3)", 2),
    "poles": ("1/(x - 0.3) + 2*y - z", 2),
    "jumps": ("floor(x) + y - z/3 + 0.15", 2),
    "open": ("Max(Abs(x) - 1.0625, Abs(y) - z/2, z - 1.3)", [2, irt.Clip("x + y/3 - 1")]),
    "double": ("(x + y/3 - 0.2)^2*(z - 0.1)", 2),
    "region": ("x^2 + y^2 + z^2 - 2.0625", [2, irt.Clip("x + y/3 - 1")]),
    "ball": ("x*y - z", [irt.Sphere((0.1, 0, 0), 1.5), irt.HalfSpace((1, 0, 0.3), 0.7)]),
}


@pytest.mark.parametrize(("name", "method"), [(n, "contract") for n in ("waves", "quotients", "corners", "poles", "jumps")] + [(n, "raa") for n in SCENES] + [(n, m) for n in ("waves", "quotients", "corners") for m in ("ia", "mitchell")] + [("corners", "auto"), ("open", "auto")])
def test_brackets_hold_the_first_root_and_are_as_narrow_as_eps(name: str, method: str) -> None:
    f, bounds = SCENES[name]
    frame = irt.render(f, bounds=bounds, size=SIZE, method=method, eps=EPS, outputs=())  # type: ignore[arg-type]
    truth = irt.reference(f, bounds, frame.camera, SIZE)
    hit = frame.status == irt.Status.HIT
    assert frame.stats.precision == "single and double"
    assert not (truth.hit & (frame.status == irt.Status.MISS)).any() and not (hit & (truth.kind == irt.Status.MISS)).any()
    both = hit & truth.hit
    assert (np.abs(frame.depth[both] - truth.depth[both]) <= frame.uncertainty[both] + 1e-11).all()
    assert (2 * frame.uncertainty[hit] <= EPS).all()
    # Where f jumps or touches zero there is nothing to bracket.
    assert hit.sum() > (0.98 * truth.hit.sum() if name not in ("jumps", "double") else 50)


@pytest.mark.parametrize(("method", "eps", "gaps"), [("raa", 2e-8, 40), ("frustum-newton", 2e-7, 24)])
def test_a_root_just_outside_the_bounds_is_none(method: str, eps: float, gaps: int) -> None:
    """A bracket is as wide as the rounding of its depth, and may reach out of the bounds through that."""
    down = irt.Camera(origin=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), projection="orthographic", height=3)
    f = irt.parse("(z - 2 - a)*(z - 2 + b)")
    for k in range(gaps):
        a, b = 2.0 ** -(20 + 0.25 * k), 2.0 ** -(12 + 0.25 * k)
        frame = irt.render(f, bounds=2, camera=down, size=(4, 4), method=method, eps=eps, params={"a": a, "b": b}, outputs=())
        hit = frame.status == irt.Status.HIT
        assert (np.abs(frame.depth[hit] - (7 + b)) <= frame.uncertainty[hit] + 1e-14).all(), (a, b)
        assert (frame.status != irt.Status.MISS).all()


@pytest.mark.parametrize("name", ["waves", "quotients"])
def test_pictures_are_those_of_double(name: str) -> None:
    frames = [irt.render(SCENES[name][0], size=SIZE, method="contract", eps=EPS, precision=p, light=(0.3, 0.9, 0.4)) for p in ("auto", "double")]
    where = frames[0].status == frames[1].status
    assert where.mean() > 0.99
    assert np.abs(frames[0].rgb.astype(int) - frames[1].rgb)[where].max() <= 1
    assert np.nanmax(np.abs(frames[0].normal - frames[1].normal)[where]) < 1e-6


@pytest.mark.parametrize("name", ["waves", "quotients"])
def test_pieces_are_those_of_both_passes(name: str) -> None:
    frames = [irt.render(SCENES[name][0], size=SIZE, method="contract", eps=e, precision=p, outputs=("pieces",)) for e, p in ((EPS, "auto"), (1e-3, "single"))]
    assert (frames[0].pieces[frames[0].hit] > frames[1].pieces[frames[0].hit].min()).all()
    assert (frames[0].pieces[~frames[0].hit] > 0).any()


def test_both_kernels_are_built_once() -> None:
    f = "x^2 + 1.28125*y^2/(z + 4)*4 + cos(z) - 1.03125"
    frames = [irt.render(f, size=SIZE, method="contract", eps=EPS) for _ in range(2)]
    assert frames[1].stats.builds == 0
    assert (frames[0].depth == frames[1].depth).all()


@pytest.mark.parametrize("name", ["waves", "quotients"])
def test_progress_runs_once(name: str) -> None:
    seen: list[float] = []
    irt.render(SCENES[name][0], size=(256, 256), method="contract", eps=EPS, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == pytest.approx(1)


def test_a_time_limit_leaves_the_rest_open() -> None:
    frame = irt.render(irt.surfaces["icos_csg"], size=(2048, 2048), method="ia", eps=EPS, time_limit=0.2)
    assert frame.stats.counts["UNRESOLVED"] > 0
    assert frame.rgb.shape == (2048, 2048, 3) and frame.normal.shape == (2048, 2048, 3)
