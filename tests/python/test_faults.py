"""Faults made to happen, in child processes: the process lives, the error says what to do, the next call works."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import pickle
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import implicitrt as irt
from implicitrt.devices import open_device

module = importlib.import_module("implicitrt.devices")

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


def test_four_threads_draw_what_one_draws() -> None:
    calls = [
        ("x^2 + y^2 + z^2 - 1", {"size": (64, 48)}), ("sin(3x) + y", {"size": (33, 21), "method": "ia"}),
        ("x^4 + y^4 + z^4 - 1", {"size": (50, 40), "method": "raa"}), ("x^2 + y^2 - a z", {"size": (41, 31), "method": "contract", "params": {"a": 0.5}}),
    ]  # fmt: skip
    alone = [irt.render(f, **call) for f, call in calls]
    together: dict[int, list[irt.Frame]] = {k: [] for k in range(4)}

    def draw(k: int) -> None:
        for _ in range(5):
            together[k].append(irt.render(calls[k][0], **calls[k][1]))

    threads = [threading.Thread(target=draw, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k, frames in together.items():
        assert len(frames) == 5
        for frame in frames:
            for name in ("rgb", "depth", "status", "uncertainty"):
                assert np.array_equal(getattr(frame, name), getattr(alone[k], name), equal_nan=name in ("depth", "uncertainty"))


def test_a_frame_too_large_is_refused() -> None:
    for size in ((1 << 14, 1 << 14), (200_000, 200_000)):
        with pytest.raises(irt.LimitError, match="pixels"):
            irt.render("x", size=size)
    irt.render("x", size=(4, 4))


def test_a_frame_too_large_for_memory_is_refused() -> None:
    code = (
        "import resource, implicitrt as irt\nirt.render('x', size=(4, 4))\n"
        "pages = int(open('/proc/self/statm').read().split()[0])\n"
        "resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + (100 << 20), resource.RLIM_INFINITY))\n"
        "try: irt.render('x', size=(8192, 8192))\nexcept irt.LimitError as e: print(e)\n"
        "print(irt.render('x', size=(4, 4)).size)"
    )
    out, err = _start(code).communicate(timeout=300)
    assert "smaller frame" in out and out.strip().endswith("(4, 4)"), err[-800:]


def test_ctrl_c_within_a_frame() -> None:
    """In a band of rows, most likely; between two frames it is no different."""
    threading.Timer(1.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    ends = time.monotonic() + 60
    with pytest.raises(KeyboardInterrupt):
        while time.monotonic() < ends:
            irt.render("sin(40x) sin(40y) sin(40z) + 1", size=(800, 600), method="ia", rounding="fast", eps=1e-6, precision="single")
    assert irt.render("x", size=(4, 4)).size == (4, 4)


@pytest.mark.parametrize(("script", "verdict"), [("kill -ABRT $PPID", "died .signal SIGABRT"), ("echo $$ > $0.pid; sleep 600", "hung")], ids=["aborts", "hangs"])
def test_a_driver_that_faults_in_its_compiler(script: str, verdict: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """PoCL calls a linker while it compiles; this one ends the process that called it, or never comes back."""
    driver = next((d for d in module._found() if d.label == "pocl (system)"), None)
    if driver is None:
        pytest.skip("PoCL is not installed on this system")
    irt.render("x", size=(4, 4))
    linker = tmp_path / "ld"
    linker.write_text(f"#!/bin/sh\n{script}\n")
    linker.chmod(0o755)
    with monkeypatch.context() as fault:
        fault.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
        fault.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
        fault.setattr(module, "_found", lambda: [driver])
        fault.setattr(module, "PROBE_SECONDS", 6.0)
        with pytest.raises(irt.DeviceError, match=verdict) as error:
            open_device("pocl (sys")
        assert "install one" in str(error.value) and "drivers-" in str(error.value)
        if (pid := tmp_path / "ld.pid").exists():
            state = Path(f"/proc/{int(pid.read_text())}/stat")
            assert not state.exists() or state.read_text().rpartition(")")[2].split()[0] == "Z"
    assert irt.render("x", size=(4, 4)).size == (4, 4)
    assert shutil.which("ld") != str(linker)


@pytest.mark.parametrize("step", [irt.sin, lambda e: e**2 + 1])
def test_deep_trees_end_in_limits(step: Callable[[irt.Expr], irt.Expr]) -> None:
    e: irt.Expr = irt.x
    for _ in range(210_000):
        e = step(e)
    for call in (
        lambda: e.diff(irt.x), e.simplify, e.expand, lambda: e.evaluate(1.0, 0, 0), e._sympy_, lambda: str(e), lambda: repr(e),
        e._repr_latex_, lambda: irt.render(e, size=(4, 4)), lambda: irt.reference(e, (0, 0, 1), (0, 0, 1), bounds=2),
    ):  # fmt: skip
        with pytest.raises(irt.LimitError):
            call()
    assert hash(e) == hash(step(e).args[0]) or e.free_symbols == {irt.x}
    assert e.subs({"x": irt.y}).free_symbols == {irt.y}
    assert pickle.loads(pickle.dumps(e)) == e
    with contextlib.suppress(irt.LimitError):  # x^2^2^2...
        assert e.degree() in (None, 210_001)


@pytest.mark.parametrize("step", [lambda e: (e + 1) * irt.x, lambda e: irt.Piecewise((e + 1, irt.x < 1), (irt.x, True))], ids=["products", "pieces"])
def test_deep_chains_are_answered_or_refused(step: Callable[[irt.Expr], irt.Expr]) -> None:
    e: irt.Expr = irt.x
    for _ in range(20_000):
        e = step(e)
    for call in (
        lambda: e.diff(irt.x), e.simplify, e.expand, lambda: e.evaluate(0.5, 0, 0), e._sympy_, lambda: str(e), e._repr_latex_,
        lambda: irt.render(e, size=(4, 4)),
    ):  # fmt: skip
        with contextlib.suppress(irt.LimitError):
            call()
    assert pickle.loads(pickle.dumps(e)) == e
    assert e.degree() in (None, 20_001)
    assert e.subs({"x": irt.y}).free_symbols == {irt.y}
