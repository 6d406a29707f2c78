"""Faults made to happen, in child processes: the process lives, the error says what to do, the next call works."""

from __future__ import annotations

import contextlib
import io
import os
import pickle
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import implicitrt as irt

DRAW = "import implicitrt as irt; print(irt.render('x^2 + y^2 + z^2 - 1', size=(32, 32)).stats.counts['HIT'])"


def _start(code: str, before: Callable[[], None] | None = None, **env: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, **env}, preexec_fn=before,
    )  # fmt: skip


def _cache(folder: Path) -> dict[str, str]:
    return {"POCL_CACHE_DIR": str(folder / "pocl"), "XDG_CACHE_HOME": str(folder / "home")}


@pytest.fixture(scope="module")
def hits() -> str:
    return str(irt.render("x^2 + y^2 + z^2 - 1", size=(32, 32)).stats.counts["HIT"])


def test_eight_processes_start_at_once_on_an_empty_cache(tmp_path: Path, hits: str) -> None:
    children = [_start(DRAW, **_cache(tmp_path)) for _ in range(8)]
    for child in children:
        out, err = child.communicate(timeout=400)
        assert child.returncode == 0 and out.strip() == hits, err[-500:]


def test_a_poisoned_cache_is_survived(tmp_path: Path, hits: str) -> None:
    env = _cache(tmp_path)
    assert _start(DRAW, **env).communicate(timeout=300)[0].strip() == hits
    rng = np.random.default_rng(1)
    for file in tmp_path.rglob("*"):
        if file.is_file():
            file.write_bytes(rng.bytes(1 + file.stat().st_size // 2))
    child = _start(DRAW, **env)
    out, err = child.communicate(timeout=300)
    # The driver may refuse what it reads; it must not take the process down, nor draw something else.
    assert child.returncode >= 0, err[-500:]
    assert out.strip() == hits or "implicitrt.errors" in err, err[-800:]


def test_a_full_disk_is_survived(tmp_path: Path, hits: str) -> None:
    def full() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))

    out, err = _start(DRAW, full, **_cache(tmp_path)).communicate(timeout=300)
    assert out.strip() == hits or "DeviceError" in err or "BuildError" in err, err[-800:]


def test_killed_while_saving_leaves_a_whole_file_or_none(tmp_path: Path) -> None:
    target = tmp_path / "out.png"
    code = (
        "import implicitrt as irt\nf = irt.render('x^2 + y^2 - z', size=(900, 900))\nprint('ready', flush=True)\n"
        f"while True: f.save({str(target)!r})"
    )
    child = _start(code)
    assert child.stdout is not None and child.stdout.readline().strip() == "ready"
    time.sleep(0.31)
    child.kill()
    child.wait()
    if target.exists():
        assert Image.open(io.BytesIO(target.read_bytes())).convert("RGB").size == (900, 900)


def test_a_thousand_renders_leak_nothing_and_build_nothing() -> None:
    def resident() -> int:
        with open("/proc/self/statm") as f:
            return int(f.read().split()[1]) * resource.getpagesize()

    def draw(count: int) -> int:
        return sum(
            irt.render("x^2 + a y^2 + z^4 - b", size=(40, 30), params={"a": 1 + k / 300, "b": 1.5}).stats.builds
            for k in range(count)
        )

    draw(100)
    before = resident()
    assert draw(1000) == 0
    assert resident() - before < 8 << 20


def test_a_frame_too_large_is_refused() -> None:
    with pytest.raises(irt.LimitError, match="pixels"):
        irt.render("x", size=(1 << 14, 1 << 14))
    irt.render("x", size=(4, 4))


@pytest.mark.parametrize("step", [irt.sin, lambda e: e**2 + 1])
def test_deep_trees_end_in_limits(step: Callable[[irt.Expr], irt.Expr]) -> None:
    e: irt.Expr = irt.x
    for _ in range(210_000):
        e = step(e)
    for call in (
        lambda: e.diff(irt.x), e.simplify, e.expand, lambda: e.evaluate(1.0, 0, 0), e._sympy_, lambda: str(e), lambda: repr(e),
        e._repr_latex_, lambda: pickle.dumps(e), lambda: irt.render(e, size=(4, 4)), lambda: irt.reference(e, (0, 0, 1), (0, 0, 1), bounds=2),
    ):  # fmt: skip
        with pytest.raises(irt.LimitError):
            call()
    assert hash(e) == hash(step(e).args[0]) or e.free_symbols == {irt.x}
    assert e.subs({"x": irt.y}).free_symbols == {irt.y}
    with contextlib.suppress(irt.LimitError):  # x^2^2^2...
        assert e.degree() in (None, 210_001)


@pytest.mark.parametrize("step", [lambda e: (e + 1) * irt.x, lambda e: irt.Piecewise((e + 1, irt.x < 1), (irt.x, True))], ids=["products", "pieces"])
def test_deep_chains_are_answered_or_refused(step: Callable[[irt.Expr], irt.Expr]) -> None:
    e: irt.Expr = irt.x
    for _ in range(20_000):
        e = step(e)
    for call in (
        lambda: e.diff(irt.x), e.simplify, e.expand, lambda: e.evaluate(0.5, 0, 0), e._sympy_, lambda: str(e), e._repr_latex_,
        lambda: pickle.dumps(e), lambda: irt.render(e, size=(4, 4)),
    ):  # fmt: skip
        with contextlib.suppress(irt.LimitError):
            call()
    assert e.degree() in (None, 20_001)
    assert e.subs({"x": irt.y}).free_symbols == {irt.y}
