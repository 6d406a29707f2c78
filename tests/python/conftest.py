"""Fixtures that all tests share."""

from __future__ import annotations

import os
import signal
import warnings
from pathlib import Path

import pytest

from implicitrt.devices import Device, devices

DATA = Path(__file__).parent.parent / "data"

# Shells start what runs behind them with SIGINT ignored, and tests of Ctrl-C, here and in child processes, would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def working_devices() -> list[Device]:
    """Every device that works here; tests run on each."""
    return [d for d in devices() if d.ok]


def pytest_report_header() -> list[str]:
    """Says aloud what the tests run on, and what they lack."""
    lines = [
        f"device: {d.driver} {d.name}, {'packets of ' + str(d.width) if d.ok else 'NOT USED: ' + d.reason}"
        for d in devices()
    ]
    if "IMPLICITRT_TEST_DATA" not in os.environ:
        lines.append("IMPLICITRT_TEST_DATA is not set: tests that need external files are skipped")
    return lines or ["no OpenCL device: tests that draw will fail"]


def _choices() -> list[str]:
    """The packet widths and drivers that rendering is tested on: all widths of the best, the others' widest."""
    found = working_devices()
    if not found:
        warnings.warn("no OpenCL device works", stacklevel=1)
        return [""]
    best = found[0]
    choices = [f"{best.driver}:{w}" for w in (1, 4, 8, 16) if w <= best.width]
    return choices + [d.driver for d in found[1:]]


@pytest.fixture(params=_choices())
def device(request: pytest.FixtureRequest) -> str:
    """A device choice; the test runs once for each."""
    return str(request.param)


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of the tests' own data."""
    return DATA


@pytest.fixture(scope="session")
def external() -> Path:
    """The folder of large external test data; the test is skipped without it."""
    folder = os.environ.get("IMPLICITRT_TEST_DATA")
    if not folder:
        pytest.skip("IMPLICITRT_TEST_DATA is not set")
    return Path(folder)
