"""Some pads, with builtins at the bounds of OpenCL: made smaller, each loses a value. benchmarks/mutations.py does it for all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from changed_kernels import with_change
from conftest import working_devices
from mutations import Judge, Pad, all_pads, looks_at

import implicitrt as irt
from implicitrt import _core

KERNELS = Path(_core.__file__).resolve().parent / "kernels"


@pytest.fixture(scope="module")
def judge(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Judge]:
    yield Judge(KERNELS, tmp_path_factory.mktemp("mutations"), working_devices()[0].driver)


def _pads(function: str) -> list[Pad]:
    return [pad for pad in all_pads(KERNELS) if pad.function == function]


@pytest.mark.parametrize(
    "function, share", [("ia_exp", 0.7), ("ia_recip", 0.9), ("ra_recip", 0.6), ("ra_from_range", 0.0)]
)
def test_a_smaller_pad_is_noticed(judge: Judge, function: str, share: float) -> None:
    found = _pads(function)
    assert found
    for pad in found:
        assert judge.lost(pad, share, looks_at(pad)), pad


def test_unchanged_pads_hold(judge: Judge) -> None:
    pad = _pads("ra_mul")[0]
    assert (
        judge.lost(pad, 1.0, [("x*y", "raa", "plain"), ("sin(x)", "raa", "plain"), ("tanh(x)", "ia", "plain")]) is None
    )


def _planes_lost(folder: Path) -> int:
    """Rays through x = 65/64, near a face of the bounds, that kernels in a folder get wrong: roots are known exactly."""
    rng = np.random.default_rng(4)
    n = 6000
    p = np.column_stack([np.full(n, 65 / 64), rng.uniform(-1, 1, (n, 2))])
    d = rng.normal(size=(n, 3))
    d[:, 0] += np.copysign(0.1, d[:, 0])
    o = p - rng.uniform(0.1, 4, (n, 1)) * d
    t = (65 / 64 - o[:, 0].astype(np.longdouble)) / d[:, 0]
    _core.set_kernel_directory(str(folder))
    hits = irt.trace("x - 65/64", o, d, bounds=1.03, method="contract", precision="single", eps=1e-7)
    with np.errstate(invalid="ignore"):
        apart = np.abs(t - hits.t) > hits.uncertainty
    return int(((hits.status == irt.Status.MISS) | (hits.status == irt.Status.HIT) & apart).sum())


def test_a_smaller_pad_of_positions_is_noticed(tmp_path: Path) -> None:
    smaller = with_change(tmp_path, "path.cl", "ALONG_ERROR R(1.05)", "ALONG_ERROR R(0.4)")
    try:
        assert _planes_lost(KERNELS) == 0
        assert _planes_lost(smaller) > 0
    finally:
        _core.set_kernel_directory(str(KERNELS))


def test_every_function_that_pads_is_looked_at() -> None:
    assert len(all_pads(KERNELS)) > 60
    for pad in all_pads(KERNELS):
        assert looks_at(pad)
