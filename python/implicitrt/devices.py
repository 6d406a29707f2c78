"""OpenCL drivers: found without opening a library, tried in child processes, loaded one at a time.

A driver can abort, hang or compute wrong numbers, so each is probed before it is trusted: one child
process per packet width, narrowest first, each with a deadline and a throw-away cache folder. What
was learned is remembered per user, driver and CPU.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import importlib.metadata
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from implicitrt import _core
from implicitrt.errors import ArgumentError, DeviceError

__all__ = ["Device", "describe", "devices", "open_device"]

WIDTHS = (1, 4, 8, 16)
PROBE_SECONDS = 20.0
_MEMORY_VERSION = 3
_INSTALL = (
    "install one: `apt-get install pocl-opencl-icd gcc binutils` (Debian, Ubuntu), or `pip install implicitrt[intel]`"
)


@dataclass(frozen=True)
class Device:
    """An OpenCL device that was found, or a driver that failed.

    Attributes:
        name: the device's own name; the driver's path where it never came so far.
        driver: which driver, and where it came from: "pocl (system)", "intel (pip)".
        version: the driver's version.
        width: floats per packet, the widest that the probe found right; GPUs use 1.
        ok: whether it can be used.
        reason: why not, or why packets are not wider, and what to do.
        gpu, fp64: whether it is a GPU, whether it has double precision.
        path: the driver's library.
    """

    name: str
    driver: str
    version: str
    width: int
    ok: bool
    reason: str
    gpu: bool = False
    fp64: bool = False
    path: str = ""


@dataclass(frozen=True)
class _Driver:
    """A driver's library, and where it was found."""

    label: str
    path: str


@dataclass
class _Verdict:
    """What the probes of one driver showed."""

    name: str = ""
    version: str = ""
    gpu: bool = False
    fp64: bool = False
    widths: dict[str, str] = field(default_factory=dict)  # width -> "works" or what happened
    path: str = ""  # where another copy of the library has to be loaded

    @property
    def width(self) -> int:
        return max((int(w) for w, v in self.widths.items() if v == "works"), default=0)

    @property
    def failure(self) -> str:
        return "; ".join(f"width {w}: {v}" for w, v in self.widths.items() if v != "works")


def _vendor_files() -> Iterator[Path]:
    """The `.icd` files of the system's list, as OpenCL's loaders find them."""
    chosen = os.environ.get("OCL_ICD_VENDORS")
    if chosen and Path(chosen).is_file():
        yield Path(chosen)
        return
    folders = [Path(chosen)] if chosen else [Path("/etc/OpenCL/vendors")]
    if not chosen and os.environ.get("CONDA_PREFIX"):
        folders.append(Path(os.environ["CONDA_PREFIX"]) / "etc/OpenCL/vendors")
    for folder in folders:
        with contextlib.suppress(OSError):
            yield from sorted(folder.glob("*.icd"))


def _kind(path: str) -> str:
    name = Path(path).name.lower()
    for kind, part in (("pocl", "pocl"), ("intel", "intel"), ("nvidia", "nvidia"), ("amd", "amd")):
        if part in name:
            return kind
    return name.removeprefix("lib").split(".so")[0] or name


def _found() -> list[_Driver]:
    """Every driver of the system and of pip, by reading lists and metadata only."""
    drivers = []
    for file in _vendor_files():
        with contextlib.suppress(OSError, UnicodeDecodeError):
            path = file.read_text().strip().split("\n")[0].strip()
            if path:
                drivers.append(_Driver(f"{_kind(path)} (system)", path))
    for path in os.environ.get("OCL_ICD_FILENAMES", "").split(os.pathsep):
        if path:
            drivers.append(_Driver(f"{_kind(path)} (system)", path))
    for kind, package, name in (
        ("intel", "intel-opencl-rt", "libintelocl.so"),
        ("pocl", "pocl-binary-distribution", "libpocl"),
    ):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            for packed in importlib.metadata.files(package) or []:
                exact = packed.name == name or (kind == "pocl" and packed.name.startswith(name))
                if exact and ".so" in packed.name:
                    resolved = Path(str(packed.locate())).resolve()
                    if resolved.is_file():
                        drivers.append(_Driver(f"{kind} (pip)", str(resolved)))
                        break
    unique: dict[str, _Driver] = {}
    for driver in drivers:
        unique.setdefault(os.path.realpath(driver.path), driver)
    return list(unique.values())


def _cache_home() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "implicitrt"


@functools.cache
def _cpu() -> str:
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def _identity(driver: _Driver) -> str:
    """Changes where the driver or the CPU changes. Libraries named without a folder have no file."""
    mark = ""
    with contextlib.suppress(OSError):
        status = os.stat(driver.path)
        mark = f"{status.st_size} {status.st_mtime_ns}"
    return f"{driver.path} | {mark} | {_cpu()} | {_core_version()}"


@functools.cache
def _core_version() -> str:
    return f"{_MEMORY_VERSION}"


def _memory_file() -> Path:
    return _cache_home() / f"drivers-{os.getuid() if hasattr(os, 'getuid') else 0}.json"


def _remembered() -> dict[str, dict[str, object]]:
    with contextlib.suppress(OSError, ValueError):
        data = json.loads(_memory_file().read_text())
        if isinstance(data, dict):
            return data
    return {}


def _remember(identity: str, verdict: _Verdict) -> None:
    """Adds a verdict to the memory. A cache folder that cannot be written costs only time."""
    with contextlib.suppress(OSError):
        file = _memory_file()
        file.parent.mkdir(parents=True, exist_ok=True)
        data = _remembered() | {identity: vars(verdict)}
        handle, temporary = tempfile.mkstemp(dir=file.parent, prefix=".drivers-")
        try:
            with os.fdopen(handle, "w") as out:
                json.dump(data, out, indent=1)
            os.replace(temporary, file)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise


def _probe_child(path: str, width: int) -> tuple[str, dict[str, object]]:
    """Runs one probe in a child of its own session; returns what happened and what it reported."""
    with tempfile.TemporaryDirectory(prefix="implicitrt-probe-", ignore_cleanup_errors=True) as cache:
        env = os.environ | {
            "POCL_CACHE_DIR": cache,
            "PYTHONPATH": os.pathsep.join(p for p in sys.path if p),
        }
        child = subprocess.Popen(
            [sys.executable, "-m", "implicitrt._probe", path, str(width)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env, start_new_session=True,
        )  # fmt: skip
        try:
            out, err = child.communicate(timeout=PROBE_SECONDS)
        except subprocess.TimeoutExpired:
            _kill(child)
            return f"hung (no answer in {PROBE_SECONDS:.0f} s)", {}
        except BaseException:
            _kill(child)
            raise
    if child.returncode != 0:
        lines = err.decode(errors="replace").strip().splitlines()
        how = (
            f"signal {signal.Signals(-child.returncode).name}"
            if child.returncode < 0
            else f"exit code {child.returncode}"
        )
        return f"died ({how}{': ' + lines[-1][:160] if lines else ''})", {}
    try:
        report = json.loads(out.decode().strip().splitlines()[-1])
    except (ValueError, IndexError):
        return "died (no report)", {}
    wrong = str(report.pop("wrong"))
    return (f"wrong numbers ({wrong})" if wrong else "works"), report


def _kill(child: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(OSError):
        os.killpg(child.pid, signal.SIGKILL)
    child.kill()
    child.communicate()


def _probe(driver: _Driver) -> _Verdict:
    verdict = _Verdict()
    for width in WIDTHS:
        outcome, report = _probe_child(driver.path, width)
        verdict.widths[str(width)] = outcome
        for key, value in report.items():
            setattr(verdict, key, value)
        # What fails narrow fails wide, and a GPU's lanes are its own.
        if outcome != "works" or verdict.gpu:
            break
    return verdict


_lock = threading.RLock()
_opened: dict[tuple[str, int], _core.Device] = {}


def _verdict(driver: _Driver) -> _Verdict:
    identity = _identity(driver)
    known = _remembered().get(identity)
    if known is not None:
        with contextlib.suppress(TypeError):
            return _Verdict(**known)  # type: ignore[arg-type]
    verdict = _probe(driver)
    if driver.label == "pocl (pip)" and verdict.width < WIDTHS[-1]:
        mirror = _pocl_mirror(driver.path)
        if mirror:
            mirrored = _probe(_Driver(driver.label, mirror))
            if mirrored.width > verdict.width:
                mirrored.path = mirror
                verdict = mirrored
    _remember(identity, verdict)
    return verdict


def _pocl_mirror(path: str) -> str:
    """A folder of links to PyPI's PoCL in which its AVX-512 builtins, which it cannot compile on many CPUs, are those of
    AVX2. Returns the library's path in it, or "" where there is nothing to mirror."""
    library = Path(path)
    try:
        files = importlib.metadata.files("pocl-binary-distribution") or []
    except importlib.metadata.PackageNotFoundError:
        return ""
    wide = next((f for f in files if f.name.endswith("-avx512.bc")), None)
    if wide is None:
        return ""
    builtins = Path(str(wide.locate())).resolve()
    narrow = builtins.with_name(builtins.name.replace("avx512", "avx2"))
    if not narrow.exists():
        return ""
    # PoCL finds its data relative to its own path, so the layout stays.
    top = Path(os.path.commonpath([library, builtins]))
    root = _cache_home() / f"pocl-{zlib.crc32(path.encode()):08x}"
    try:
        for folder in (library.parent, builtins.parent.parent.parent):
            for source in sorted(folder.rglob("*")):
                if source.is_file():
                    link = root / source.relative_to(top)
                    link.parent.mkdir(parents=True, exist_ok=True)
                    _link(narrow if source == builtins else source, link)
    except OSError:
        return ""
    return str(root / library.relative_to(top))


def _link(source: Path, link: Path) -> None:
    if link.is_symlink():
        link.unlink()
    if not link.exists():
        link.symlink_to(source)


def _examine(driver: _Driver) -> Device:
    verdict = _verdict(driver)
    reason = verdict.failure
    ok = verdict.width > 0
    if "pocl" in driver.label and not shutil.which("ld"):
        # PoCL aborts the whole process at the first launch without a linker.
        ok = False
        reason = (
            "PoCL needs a linker (`ld`) and finds none: `apt-get install binutils gcc libc6-dev`, "
            "or use a driver that needs none: `pip install implicitrt[intel]`"
        )
    return Device(
        name=verdict.name or driver.path, driver=driver.label, version=verdict.version,
        width=max(verdict.width, 1), ok=ok, reason=reason, gpu=verdict.gpu, fp64=verdict.fp64,
        path=verdict.path or driver.path,
    )  # fmt: skip


def devices() -> list[Device]:
    """Every OpenCL device found, best first, and every driver that failed with the reason.

    Drivers seen for the first time are probed in child processes, which takes seconds.
    """
    with _lock:
        return sorted((_examine(d) for d in _found()), key=_preference)


def _preference(device: Device) -> tuple[bool, bool, bool, int]:
    """Working ones first; a GPU; the system's before pip's; then the widest packets."""
    return (not device.ok, not device.gpu, "(system)" not in device.driver, -device.width)


def _split_width(choice: str) -> tuple[str, int | None]:
    name, colon, width = choice.rpartition(":")
    if colon and width.strip().isdecimal():
        return name.strip(), int(width)
    return choice.strip(), None


def open_device(choice: str | None = None) -> _core.Device:
    """The device that `choice` names, loaded into this process.

    Args:
        choice: part of a device's or driver's name, and after a colon a packet width if not the
            widest ("pocl:1"). None: the environment variable IMPLICITRT_DEVICE, else the best: a
            GPU, a driver of the system, one of pip.

    Raises:
        ArgumentError: the choice is no text.
        DeviceError: nothing matches or works; names what was tried and what to install.
    """
    wanted = choice if choice is not None else os.environ.get("IMPLICITRT_DEVICE", "")
    if not isinstance(wanted, str):
        raise ArgumentError(f"device is part of a device's or driver's name, not {choice!r}; irt.devices() lists them")
    try:
        return _open(wanted)
    except OSError as error:
        raise DeviceError(
            f"no driver can be tried or loaded: {error}. Drivers need a folder for temporary files that can be written: "
            "free some space, or set TMPDIR"
        ) from error


def _open(wanted: str) -> _core.Device:
    name, width = _split_width(wanted)
    with _lock:
        known = _opened_for(wanted)
        if known is not None:
            return known
        best = (_first_choice() if not name else None) or _matching(name, devices(), wanted)
        if width is not None and (width not in WIDTHS or width > best.width):
            raise DeviceError(
                f"{best.driver} cannot run packets of {width}; it can of "
                f"{', '.join(str(w) for w in WIDTHS if w <= best.width)}"
            )
        key = (best.path, width or best.width)
        if key not in _opened:
            _prepare_cache(best)
            with _threads_pinned(best):
                _opened[key] = _core.load_device(best.path, best.driver, key[1])
            atexit.register(_opened[key].finish)  # no driver survives being left while it compiles
        _choices[wanted] = _opened[key]
        return _opened[key]


def _matching(name: str, found: list[Device], wanted: str) -> Device:
    """The best of the devices found that works and that `name` is part of; DeviceError where there is none."""
    matching = [d for d in found if name.lower() in f"{d.name} {d.driver}".lower()]
    for device in matching:
        if device.ok:
            return device
    raise DeviceError(_nothing(found, matching, wanted))


def _first_choice() -> Device | None:
    """The best device, found without probing drivers that could not be it: pip brings no GPU drivers."""
    system = sorted((_examine(d) for d in _found() if d.label.endswith("(system)")), key=_preference)
    return system[0] if system and system[0].ok else None


_choices: dict[str, _core.Device] = {}


def _opened_for(wanted: str) -> _core.Device | None:
    return _choices.get(wanted)


def _nothing(found: list[Device], matching: list[Device], wanted: str) -> str:
    if not found:
        return f"no OpenCL driver was found; {_INSTALL}"
    tried = "\n".join(f"  {d.driver} ({d.path}): {d.reason or 'works'}" for d in (matching or found))
    if wanted and not matching:
        return f"no OpenCL device matches '{wanted}'. Found:\n{tried}"
    return f"no OpenCL driver works. Tried:\n{tried}\n{_INSTALL}. To try these again, delete {_memory_file()}"


@contextlib.contextmanager
def _threads_pinned(device: Device) -> Iterator[None]:
    """PoCL makes its threads meanwhile, one for each processor, and keeps each on its own: Linux wakes two on one processor often enough that a quarter of
    the frames take twice as long. Not where the process may not use all processors, or where the environment says how PoCL's threads are to be."""
    chosen = any(name.startswith(("POCL_AFFINITY", "POCL_MAX", "POCL_CPU")) for name in os.environ)
    all_of_them = hasattr(os, "sched_getaffinity") and os.sched_getaffinity(0) == set(range(os.cpu_count() or 0))
    if "pocl" not in device.driver or chosen or not all_of_them:
        yield
        return
    os.environ["POCL_AFFINITY"] = "1"
    try:
        yield
    finally:
        del os.environ["POCL_AFFINITY"]


def _prepare_cache(device: Device) -> None:
    """PoCL fails without a word where it cannot write its cache: it is given a folder that works."""
    if "pocl" not in device.driver:
        return
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = Path(os.environ.get("POCL_CACHE_DIR") or Path(base) / "pocl")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"\0" * 65536)
        _drop_broken_entries(folder)
    except OSError:
        import atexit

        temporary = tempfile.mkdtemp(prefix="implicitrt-pocl-")
        atexit.register(shutil.rmtree, temporary, True)
        os.environ["POCL_CACHE_DIR"] = temporary


def _drop_broken_entries(folder: Path) -> None:
    """Removes what a crash or a full disk left half-written in PoCL's cache: PoCL aborts the process where it reads such an
    entry. Entries that nobody has used since the last look are not opened again: a cache may hold ten thousands."""
    stamp = folder / ".implicitrt-checked"
    since = stamp.stat().st_mtime if stamp.exists() else 0.0
    root = folder / "kcache" if (folder / "kcache").is_dir() else folder  # the latter where POCL_CACHE_DIR is set
    for bucket in _folders(root):
        for entry in _folders(bucket.path):
            with contextlib.suppress(OSError):
                used = entry.stat().st_mtime
                with contextlib.suppress(FileNotFoundError):
                    used = max(used, os.stat(os.path.join(entry.path, "last_accessed")).st_mtime)
                if used >= since and not all(_whole(os.path.join(place, file)) for place, _, files in os.walk(entry.path) for file in files):
                    shutil.rmtree(entry.path, ignore_errors=True)
    stamp.touch()


def _folders(folder: str | Path) -> list[os.DirEntry[str]]:
    with os.scandir(folder) as found:
        return [entry for entry in found if entry.is_dir()]


def _whole(path: str) -> bool:
    """Whether a file of LLVM bitcode or a shared object has a head that fits, and a length that fits its head."""
    if not path.endswith((".bc", ".so")):
        return True
    with open(path, "rb") as file:
        head = file.read(64)
        size = os.fstat(file.fileno()).st_size
    if path.endswith(".bc"):
        return head[:4] == b"BC\xc0\xde" and size % 4 == 0
    if head[:5] != b"\x7fELF\x02" or len(head) < 64:
        return False
    # Where the table of sections lies, at the end, and how long it is.
    start = int.from_bytes(head[40:48], "little")
    return start + int.from_bytes(head[58:60], "little") * int.from_bytes(head[60:62], "little") <= size


def describe() -> str:
    """A text about every device and driver, for `implicitrt info`."""
    lines = []
    found = devices()
    for device in found:
        state = f"works, packets of {device.width}" if device.ok else "cannot be used"
        kind = "GPU" if device.gpu else "CPU"
        lines.append(f"{device.driver}: {device.name} ({kind}, {device.version or 'no version'}): {state}")
        lines.append(f"    {device.path}")
        if device.reason:
            lines.append(f"    {device.reason}")
    if not lines:
        lines.append(f"No OpenCL driver was found; {_INSTALL}")
    else:
        wanted = os.environ.get("IMPLICITRT_DEVICE", "")
        by = f" by IMPLICITRT_DEVICE={wanted}" if wanted else ""
        try:
            lines.append(f"Used{by}: {_matching(_split_width(wanted)[0], found, wanted).driver}")
        except DeviceError as error:
            lines.append(f"Used{by}: none, {str(error).splitlines()[0]}")
    lines.append(f"Verdicts are remembered in {_memory_file()}")
    return "\n".join(lines)
