"""Some pads, with builtins at the bounds of OpenCL: made smaller, each loses a value. benchmarks/mutations.py does it for all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import working_devices
from mutations import Judge, Pad, all_pads, looks_at

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


def test_every_function_that_pads_is_looked_at() -> None:
    assert len(all_pads(KERNELS)) > 60
    for pad in all_pads(KERNELS):
        assert looks_at(pad)
