"""Beams (kernels/beams.cl) change what rays look at, never what is found: frames against `trace`, whose rays have none."""

from __future__ import annotations

import pytest

import implicitrt as irt
from implicitrt import Status

CAMERAS = {
    "far": irt.Camera(origin=(2, 3, 5), fov=35),
    "inside": irt.Camera(origin=(0.3, 0.2, 0.4), target=(1, 1, 0), fov=80),
    "farther": irt.Camera(origin=(40, 30, -60), fov=3),
    "orthographic": irt.Camera(origin=(2, 1, 4), projection="orthographic", height=4),
    "a pixel of all": irt.Camera(origin=(6000, 4000, 18600)),
}
FORMULAS = ["x^2 + y^2 + z^2 - 1", "sin(3x)*cos(2y) + z^2 - 1/5", "sqrt(x) + y*z - 1/10", "(x^2 + y^2 + z^2 - 1)^2", "floor(2x) + y - z", "sqrt(Abs(x*y*z)) - 1/4"]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("formula", FORMULAS)
@pytest.mark.parametrize(("size", "precision", "rounding"), [((37, 23), "single", "outward"), ((5, 33), "double", "outward"), ((37, 23), "single", "fast")])
def test_frames_agree_with_trace(formula: str, camera: str, size: tuple[int, int], precision: str, rounding: str) -> None:
    """Sizes that are no multiples of tiles; eyes inside and far from the bounds."""
    keywords = {"bounds": 1.5, "method": irt.Contraction(beams=True), "precision": precision, "rounding": rounding, "eps": 1e-4}
    frame = irt.render(formula, camera=CAMERAS[camera], size=size, **keywords)
    origins, directions = CAMERAS[camera].rays(size)
    hits = irt.trace(formula, origins.reshape(-1, 3), directions.reshape(-1, 3), **keywords)
    beams, alone = frame.status.ravel(), hits.status
    contradict = ((beams == Status.MISS) & (alone == Status.HIT)) | ((beams == Status.HIT) & (alone == Status.MISS))
    assert not contradict.any() if rounding == "outward" else contradict.mean() < 0.01
    both = (beams == Status.HIT) & (alone == Status.HIT)
    if rounding == "outward":
        apart = abs(frame.depth.ravel()[both] - hits.t[both])
        assert (apart <= (frame.uncertainty.ravel() + hits.uncertainty)[both] * 1.001 + 1e-6).all()


@pytest.mark.parametrize("precision", ["single", "double"])
def test_beams_wider_than_boxes_off_the_origin(precision: str) -> None:
    """A pixel is as wide as ten of the box, and half as far as the origin: no plane cut such beams, and f was asked where it overflows."""
    camera = irt.Camera((103, 102, 109.3), (100, 100, 100), projection="orthographic", height=660)
    frame = irt.render("sqrt(Abs((x - 100)*(y - 100)*(z - 100))) - 1/4", ((98, 102),) * 3, camera, (33, 33), method=irt.Contraction(beams=True), precision=precision, outputs=())
    assert frame.status[16, 16] == Status.HIT
