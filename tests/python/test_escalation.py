"""precision="auto": few open pixels go to the reference and are shaded on the host, many to a kernel in double."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt
from implicitrt.devices import open_device

FEW = {
    "torus": "(x^2 + y^2 + z^2 + 3/4)^2 - 4*(x^2 + y^2)",
    "waves": "sin(1.25*x) + cos(y)*z - x^2",
    "region": "x^2 + y^2 + z^2 - 2.0625",
}
EPS = {
    "torus": 1e-4,
    "waves": 1e-4,
    "region": 1e-4,
}  # at which silhouettes stay open in single precision, and little else
SIZE = (234, 180)  # no whole packets


def _pair(name: str, **arguments: object) -> tuple[irt.Frame, irt.Frame]:
    bounds = [2, irt.Clip("x + y/3 - 1")] if name == "region" else 2
    camera = None if name == "region" else irt.Camera((1.5, 1.2, 2.4))
    return tuple(irt.render(FEW[name], bounds=bounds, camera=camera, size=SIZE, precision=p, **arguments) for p in ("auto", "single"))  # type: ignore[arg-type,return-value]


@pytest.mark.parametrize("method", ["contract", "raa", "ia", "mitchell"])
@pytest.mark.parametrize("name", FEW)
def test_few_open_pixels_need_no_second_kernel(name: str, method: str) -> None:
    auto, single = _pair(name, method=method, eps=EPS[name])
    assert 0 < auto.stats.escalated <= 192
    assert auto.stats.builds <= 1
    assert auto.stats.precision == "single and double" and auto.depth.dtype == auto.uncertainty.dtype == np.float64
    assert auto.depth is auto.depth
    changed = np.asarray(auto.depth != single.depth)
    assert changed.sum() <= auto.stats.escalated
    bounds = [2, irt.Clip("x + y/3 - 1")] if name == "region" else 2
    reference = irt.reference(FEW[name], bounds, auto.camera, SIZE)
    assert (auto.status == reference.kind)[changed].all()
    hit = changed & (auto.status == irt.Status.HIT)
    assert (np.abs(auto.depth[hit] - reference.depth[hit]) <= 1e-11).all()


@pytest.mark.parametrize("trace", [False, True])
def test_what_is_drawn_again_waits_neither_for_a_kernel_nor_for_the_reference(trace: bool) -> None:
    """The kernel in double is built behind the second frame. What it decides the reference does not differ from."""
    f, camera, size = "sin(1.25*x) + cos(y)*z - 1.0625*x^2", irt.Camera((1.5, 1.2, 2.4)), (320, 240)
    origins, directions = (a.reshape(-1, 3) for a in camera.rays(size))

    def draw() -> irt.Frame | irt.Hits:
        if trace:
            return irt.trace(f, origins, directions, bounds=2, method="contract", eps=1e-4)
        return irt.render(f, camera=camera, size=size, method="contract", eps=1e-4)

    first, second = draw(), draw()
    open_device(None).finish()
    later = draw()
    assert first.stats.by_reference == second.stats.by_reference == first.stats.escalated == later.stats.escalated > 40
    assert second.stats.builds == later.stats.builds == 0 and later.stats.by_reference == 0
    assert (later.status == first.status).all()
    depths = (later.t, first.t) if trace else (later.depth, first.depth)  # type: ignore[union-attr]
    changed = depths[0] != depths[1]
    assert 0 < changed.sum() <= later.stats.escalated
    assert (np.abs(depths[0][changed] - depths[1][changed]) <= (later.uncertainty + first.uncertainty)[changed]).all()


@pytest.mark.parametrize("name", [*FEW, "saddle"])
def test_what_is_drawn_again_is_the_same_to_the_last_bit(name: str) -> None:
    """Few open pixels go to the reference every time, whether or not a kernel in double is there."""
    f = FEW.get(name, "x^2*y - z^3 + x*z - 0.1")
    frames = []
    for _ in range(4):
        frames.append(irt.render(f, bounds=2, camera=irt.Camera((1.5, 1.2, 2.4)), size=(120, 90)))
        open_device(None).finish()
    assert frames[0].stats.escalated <= 40
    for frame in frames[1:]:
        for what in ("status", "depth", "uncertainty", "normal", "rgb"):
            assert np.array_equal(getattr(frame, what), getattr(frames[0], what), equal_nan=what in ("depth", "uncertainty", "normal"))


@pytest.mark.parametrize("shift", [None, 0.25])
def test_what_drowns_in_single_precision_begins_in_double(shift: float | None) -> None:
    """Expanded, T14 leaves floats few digits; nested it is the same surface and leaves them all. Nothing is known where nothing is met."""
    nested = "64*{0}^7 - 112*{0}^5 + 56*{0}^3 - 7*{0}".format("(2*w^2 - 1)")
    for text, drowns in ((str(irt.parse(nested).expand()), True), (nested, False), ("w^2", False)):
        f = irt.parse(" + ".join(f"({text.replace('w', axis)})" for axis in "xyz"))
        frame = irt.render(f, size=(64, 48), bounds=1.1, isovalue=shift, method="contract")
        assert (frame.stats.precision == "double") == drowns


@pytest.mark.parametrize("light", [(0.3, 0.9, 0.4), None])
def test_the_host_shades_like_the_kernel(light: tuple[float, float, float] | None) -> None:
    """A double frame shades every pixel in the kernel: those decided on the host look the same."""
    for back in ("x^2 + y^2 + z^2 - 1.0625", "1.0625 - x^2 - y^2 - z^2"):
        auto, double = (irt.render(back, size=SIZE, precision=p, light=light) for p in ("auto", "double"))
        where = (auto.status == double.status) & auto.hit
        assert np.abs(auto.rgb.astype(int) - double.rgb)[where].max() <= 1
        assert np.nanmax(np.abs(auto.normal[where] - double.normal[where])) < 1e-3


def test_rays_are_decided_likewise() -> None:
    origins = np.array([[0.9999999 + 2e-8 * k, 0, -3] for k in range(12)])
    hits = irt.trace("x^2 + y^2 + z^2 - 1", origins, (0, 0, 1), bounds=2)
    reference = irt.reference("x^2 + y^2 + z^2 - 1", origins, (0, 0, 1), bounds=2)
    assert (hits.status == reference.kind).all()
    assert hits.stats.escalated > 0


def test_a_slider_builds_nothing_even_where_many_pixels_become_open() -> None:
    """a = 0 is a double plane: every pixel is open, and the kernel in double was built behind the second frame."""
    frames = [irt.render("(x + y + z/7)^2 - a*0.0703125", size=(160, 120), params={"a": a}, method="contract") for a in (1, 0.5, 0)]
    assert [f.stats.builds for f in frames] == [frames[0].stats.builds, 0, 0]
    assert frames[1].stats.escalated <= 192 < frames[2].stats.escalated


def test_a_budget_of_pieces_is_kept() -> None:
    hits = irt.trace("x^2 + y^2 + z^2 - 1", (0.3, 0.2, -3), (0, 0, 1), bounds=2, max_pieces=1)
    assert hits.status[0] == irt.Status.UNRESOLVED


@pytest.mark.parametrize("method", ["contract", "frustum-newton"])
@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
def test_the_reference_takes_the_rays_of_the_camera(projection: str, method: str) -> None:
    """Its brackets are narrower than what rounding does to rays far from the origin, and rays rounded otherwise had other roots."""
    camera = irt.Camera((74417.2, -6.1, 74417.6), (74421.5, 0, 74421.5), projection=projection, height=3.2, fov=25)
    f, bounds = "(x - 74421.5)^2 + y^2 + (z - 74421.5)^2 - 1 + (x - 74421.5)*y*(z - 74421.5)", ((74420, 74423), (-1.5, 1.5), (74420, 74423))
    reference = irt.reference(f, bounds, camera, (16, 16))
    frame = irt.render(f, bounds, camera, (16, 16), method=method, eps=1e-6 if method == "contract" else 1e-12, outputs=())
    assert frame.stats.escalated >= 40
    hit = frame.status == irt.Status.HIT
    assert (hit == reference.hit).all()
    assert (np.abs(frame.depth[hit] - reference.depth[hit]) <= 2 * frame.uncertainty[hit]).all()
