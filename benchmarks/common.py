"""What the benchmarks share: medians, tables, and yardsticks from outside."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import implicitrt as irt

# The view of the Barth sextic that the yardstick draws.
CAMERA = irt.Camera(
    origin=(-5.48984, 3.84824, -9.95906),
    target=(-5.01041, 3.54732, -9.13469),
    up=(0, 0.93937, 0.34290),
    fov=48.4555,
)
EPS = 0.003  # a 2048th of a ray's piece of the box


def external(*parts: str) -> Path:
    """A file of the external data; exits with a word about IMPLICITRT_TEST_DATA where there is none."""
    folder = os.environ.get("IMPLICITRT_TEST_DATA")
    if not folder:
        sys.exit("set IMPLICITRT_TEST_DATA to the folder of external test data, which has the yardstick")
    return Path(folder, *parts)


def yardstick(size: int, width: int) -> dict[str, float]:
    """Milliseconds per frame of each of the yardstick's rows."""
    done = subprocess.run(
        [sys.executable, str(external("peers", "yardstick.py")), "--size", str(size), "--width", str(width), "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    return {name: float(ms) for name, ms in json.loads(done.stdout)["ms"].items()}


def median_seconds(call: Callable[[], float], runs: int = 5) -> float:
    """The median of what `call` returns, after one call that does not count."""
    call()
    return statistics.median(call() for _ in range(runs))


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(c) for c in row) + " |" for row in rows])
