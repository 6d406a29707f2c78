"""Drivers: found, probed in children, remembered, and survived."""

from __future__ import annotations

import importlib
import json
import multiprocessing
import os
import resource
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import working_devices

import implicitrt as irt
from implicitrt import _core
from implicitrt.devices import open_device

module = importlib.import_module("implicitrt.devices")

KERNEL = "__kernel void k(__global int* out) { out[0] = %s; }\n"


def _child(code: str, **env: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300, env={**os.environ, **env}
    )


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def test_devices_are_listed() -> None:
    found = irt.devices()
    assert any(d.ok for d in found)
    for d in found:
        assert d.name and d.driver and (d.ok or d.reason)
        assert d.width in (1, 4, 8, 16)


def test_build_errors_carry_the_numbered_source() -> None:
    with pytest.raises(irt.BuildError) as error:
        _core.build_kernel(open_device(), "\n" + KERNEL % "undeclared_name", "k")
    assert "    2 | __kernel void k" in str(error.value)
    assert "undeclared_name" in str(error.value)


def test_cached_programs_are_not_built_again_and_the_cache_is_bounded() -> None:
    device = open_device()
    _core.build_kernel(device, KERNEL % "1", "k")
    before = device.builds
    _core.build_kernel(device, KERNEL % "1", "k")
    assert device.builds == before
    for i in range(70):
        _core.build_kernel(device, KERNEL % (100 + i), "k")
    _core.build_kernel(device, KERNEL % "1", "k")
    assert device.builds == before + 71
    # Nor does what was forgotten stay in memory: of sources that no driver's cache on disk has, so that its compiler is loaded before.
    fresh = [f"// {os.getpid()} {time.time_ns()}\n" + KERNEL % i for i in range(25)]
    for source in fresh[:5]:
        _core.build_kernel(device, source, "k")
    resident = _resident()
    for source in fresh[5:]:
        _core.build_kernel(device, source, "k")
    assert device.builds == before + 96 and _resident() - resident < 16 << 20


def test_formulas_past_the_cap_of_programs_are_forgotten() -> None:
    """What two hundred formulas leave behind; 66 do, since a device keeps 64 programs: each costs a quarter of a second."""
    device = f"{working_devices()[0].driver}:4"

    def builds(k: int) -> int:
        f = f"x^2 + {k}/7 y^2 - z"
        return irt.trace(f, (0, 0, 5), (0, 0, -1), bounds=1, method="ia", precision="single", rounding="fast", device=device).stats.builds

    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(builds, range(66))) == [1] * 66
    assert builds(65) == 0 and builds(0) == 1


def test_threads_build_at_once() -> None:
    errors: list[Exception] = []

    def build(i: int) -> None:
        try:
            _core.build_kernel(open_device(), KERNEL % (1000 + i), "k")
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=build, args=(i,)) for i in range(8)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not errors


def test_no_driver_says_what_to_install(tmp_path: Path) -> None:
    code = (
        "import importlib.metadata as m\n"
        "m.files = lambda name: []\n"
        "import implicitrt as irt\n"
        "try: irt.render('x')\nexcept irt.DeviceError as e: print(e)"
    )
    out = _child(code, OCL_ICD_VENDORS=str(tmp_path), XDG_CACHE_HOME=str(tmp_path)).stdout
    assert "apt-get install" in out and "pip install implicitrt[intel]" in out


def test_without_a_linker_pocl_is_not_used(tmp_path: Path) -> None:
    code = (
        "import shutil, importlib.metadata as m\n"
        "m.files = lambda name: []\n"
        "shutil.which = lambda name, *a, **k: None\n"
        "import implicitrt as irt\n"
        "try: irt.render('x'); print('drew')\nexcept irt.DeviceError as e: print(e)"
    )
    if not any("pocl (system)" in d.driver for d in irt.devices()):
        pytest.skip("PoCL is not installed on this system")
    assert "linker" in _child(code).stdout


def test_an_unwritable_cache_is_survived(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    code = "import implicitrt as irt; print(irt.render('x', size=(8, 8)).hit.any())"
    done = _child(code, POCL_CACHE_DIR=str(blocked / "cache"), XDG_CACHE_HOME=str(blocked / "home"))
    assert done.stdout.strip() == "True", done.stderr


def test_verdicts_are_remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    calls = []

    def probe(path: str, width: int) -> tuple[str, dict[str, object]]:
        calls.append(width)
        if width == 8:
            return "wrong numbers (sin)", {}
        return "works", {"name": "a device", "version": "1", "gpu": False, "fp64": True}

    monkeypatch.setattr(module, "_probe_child", probe)
    driver = module._Driver("some (system)", "/nonexistent/libsome.so")
    first = module._examine(driver)
    assert calls == [1, 4, 8] and first.width == 4 and "wrong numbers" in first.reason
    assert module._examine(driver) == first and calls == [1, 4, 8]
    assert json.loads(module._memory_file().read_text())


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs a C compiler to make broken drivers")
@pytest.mark.parametrize(
    ("body", "verdict"),
    [
        ("__attribute__((constructor)) static void f(void) { __builtin_trap(); }", "died"),
        ("#include <unistd.h>\n__attribute__((constructor)) static void f(void) { for (;;) sleep(1); }", "hung"),
        ("int nothing;", "died"),
    ],
)
def test_broken_drivers_are_survived(body: str, verdict: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(module, "PROBE_SECONDS", 3.0)
    (tmp_path / "driver.c").write_text(body)
    library = tmp_path / "libbroken.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", library, tmp_path / "driver.c"], check=True)
    vendors = tmp_path / "vendors"
    vendors.mkdir()
    (vendors / "broken.icd").write_text(str(library) + "\n")
    monkeypatch.setenv("OCL_ICD_VENDORS", str(vendors))
    broken = [d for d in irt.devices() if d.path == str(library)]
    assert len(broken) == 1 and not broken[0].ok and verdict in broken[0].reason
    with pytest.raises(irt.DeviceError, match="broken"):
        open_device("broken")


def _forked(queue: multiprocessing.Queue[str]) -> None:
    try:
        irt.render("x", size=(4, 4))
        queue.put("drew")
    except irt.DeviceError as error:
        queue.put(str(error))


def test_a_forked_child_gets_an_error_instead_of_hanging() -> None:
    irt.render("x", size=(4, 4))
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_forked, args=(queue,))
    child.start()
    assert "spawn" in queue.get(timeout=30)
    child.join(10)


THREADS = """
import os, pathlib
import implicitrt as irt
print("pocl" in irt.render("z", size=(8, 8)).stats.driver, "POCL_AFFINITY" in os.environ)
for task in pathlib.Path("/proc/self/task").iterdir():
    print([line.split()[1] for line in (task / "status").read_text().splitlines() if line.startswith("Cpus_allowed_list")][0])
"""


@pytest.mark.skipif(
    not hasattr(os, "sched_getaffinity") or os.cpu_count() == 1 or os.sched_getaffinity(0) != set(range(os.cpu_count() or 0)),
    reason="threads are pinned where a process may use all of several processors",
)
@pytest.mark.parametrize(("before", "env", "pinned"), [("", {}, True), ("import os; os.sched_setaffinity(0, {0})", {}, False), ("", {"POCL_AFFINITY": "0"}, False)])
def test_threads_stay_where_they_are_if_they_may_use_all_processors(before: str, env: dict[str, str], pinned: bool) -> None:
    (pocl, kept), *allowed = (line.split() for line in _child(before + THREADS, **env).stdout.splitlines())
    if pocl != "True":
        pytest.skip("PoCL is not the best driver here")
    own, each = {line[0] for line in allowed}, {str(k) for k in range(os.cpu_count() or 0)}
    assert kept == str("POCL_AFFINITY" in env)
    assert each <= own if pinned else len(own) == 1


def test_widths_can_be_chosen() -> None:
    assert open_device(":1").width == 1
    with pytest.raises(irt.DeviceError, match="packets of 3"):
        open_device(":3")


@pytest.mark.parametrize("layout", ["kcache", ""])
def test_only_broken_entries_of_a_cache_are_dropped(layout: str, tmp_path: Path) -> None:
    """As PoCL lays them out, below `kcache` or not; one that nobody used since the last look is not looked into again."""
    bucket = tmp_path / layout / "AB"

    def entry(name: str, program: bytes) -> Path:
        (bucket / name / "trace").mkdir(parents=True)
        (bucket / name / "last_accessed").touch()
        (bucket / name / "program.bc").write_bytes(program)
        return bucket / name

    good, broken = entry("good", b"BC\xc0\xde" + bytes(8)), entry("broken", b"BC\xc0\xde" + bytes(7))
    module._drop_broken_entries(tmp_path)
    assert good.exists() and not broken.exists()
    unused, used = entry("unused", b"half"), entry("used", b"half")
    for e in (unused, used):
        for path in (e, e / "last_accessed"):
            os.utime(path, (1, 1))
    os.utime(used / "last_accessed")
    module._drop_broken_entries(tmp_path)
    assert good.exists() and unused.exists() and not used.exists()
