"""The named surfaces against certified depth maps and probes, each by each inclusion method."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import Status

EPS = 1e-4
# Their printed, expanded form leaves single precision no digits.
DOUBLE = {"chmutov_14", "chmutov_18", "chmutov_20", "chmutov_30", "sarti_12"}
# Where the agreement that is asked for, 99.9 %, is not reached, or fewer than 95 % of the hits are proven:
# surface and method to the fractions that are reached. Both directions are tested: an entry that is better than it says
# must be raised.
EXCEPTIONS: dict[tuple[str, str], tuple[float, float]] = json.loads(
    (Path(__file__).parent.parent / "data" / "map_exceptions.json").read_text(),
    object_hook=lambda d: {tuple(k.split()): tuple(v) for k, v in d.items()},
)


def _silhouette(misses: np.ndarray) -> np.ndarray:
    padded = np.pad(misses, 1, mode="edge")
    near = np.stack([padded[i : i + 32, j : j + 32] for i in range(3) for j in range(3)])
    return near.any(0) & ~near.all(0)


@pytest.mark.parametrize("method", ["ia", "raa", "contract", "mitchell"])
@pytest.mark.parametrize("name", [n for n in irt.surfaces if n != "double_plane"])
def test_depth_map(name: str, method: str, data: Path) -> None:
    reference = np.load(data / "reference_depth_32.npz")[name]
    precision = "double" if name in DOUBLE else "single"
    frame = irt.render(irt.surfaces[name], size=(32, 32), eps=EPS, method=method, precision=precision, outputs=())
    misses = np.isinf(reference)
    with np.errstate(invalid="ignore"):
        error = np.abs(frame.depth - reference)
    # No status lies, anywhere.
    assert not (misses & (frame.status == Status.HIT)).any()
    assert not (~misses & (frame.status == Status.MISS)).any()
    proven = (frame.status == Status.HIT) & ~misses
    assert (error[proven] <= frame.uncertainty[proven] + 1e-12).all()
    # And most is decided.
    close = frame.hit & (error <= EPS + 4 * np.spacing(frame.depth.astype(np.float32)))
    agrees = close | (misses & (frame.status == Status.MISS))
    away = ~_silhouette(misses)
    hits = agrees & frame.hit & away
    agreement = float(agrees[away].mean())
    decided = float((frame.status[hits] == Status.HIT).mean()) if hits.any() else 1.0
    wanted = EXCEPTIONS.get((name, method), (0.999, 0.95))
    assert agreement >= wanted[0], f"{agreement:.4f} of the pixels agree"
    assert decided >= wanted[1], f"{decided:.3f} of the agreeing hits are proven"
    if (name, method) in EXCEPTIONS:
        assert agreement < 0.999 or decided < 0.95, "good enough now: remove it from map_exceptions.json"


@pytest.mark.parametrize("method", ["ia", "raa", "contract", "mitchell"])
@pytest.mark.parametrize("name", sorted(DOUBLE))
def test_formulas_that_cancel_are_decided(name: str, method: str, data: Path) -> None:
    # Around each root rounding drowns f, even in double, over a good part of eps: brackets have to widen past it.
    simple = np.isfinite(np.load(data / "reference_depth_32.npz")[name])
    frame = irt.render(irt.surfaces[name], size=(32, 32), eps=EPS, method=method, outputs=())
    away = simple & ~_silhouette(~simple)
    assert (frame.status[away] == Status.HIT).mean() >= 0.99
    assert frame.stats.counts["UNRESOLVED"] == 0


@pytest.mark.parametrize("name", sorted({n for n, _ in EXCEPTIONS}))
def test_what_single_precision_leaves_open_auto_decides(name: str, data: Path) -> None:
    reference = np.load(data / "reference_depth_32.npz")[name]
    frame = irt.render(irt.surfaces[name], size=(32, 32), eps=EPS, outputs=())
    away = ~_silhouette(np.isinf(reference))
    assert (frame.status[away] == np.where(np.isinf(reference), Status.MISS, Status.HIT)[away]).all()
    hit = np.isfinite(reference) & away
    assert (np.abs(frame.depth[hit] - reference[hit]) <= EPS).all()


@pytest.mark.parametrize("name", list(irt.surfaces))
def test_probes(name: str, data: Path) -> None:
    probes = json.loads((data / "probes.json").read_text())[name]
    hits = irt.trace(irt.surfaces[name], [p["origin"] for p in probes], [p["direction"] for p in probes], eps=EPS)
    for i, probe in enumerate(probes):
        if probe["kind"] == "miss":
            assert hits.status[i] == Status.MISS, f"ray {i}: {hits.status[i]}"
        elif probe["kind"] == "simple":
            assert hits.hit[i], f"ray {i}: {Status(hits.status[i]).name}"
            assert abs(hits.t[i] - probe["t"]) <= EPS + 1e-6 * probe["t"], f"ray {i}"
        else:
            assert hits.status[i] != Status.MISS, f"ray {i}"
