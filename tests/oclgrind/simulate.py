"""Every kernel on small images under Oclgrind, which reports invalid accesses and reads of what was never written.

    scripts/oclgrind                                        widths 1, 4 and 16; installs Oclgrind where it is missing
    python tests/oclgrind/simulate.py WIDTH [--quick]       one width; quick: a ninth of the calls

Exits with 1 where Oclgrind reports anything, and prints the first reports.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
from changed_kernels import with_change

LIBRARY = "/usr/lib/oclgrind/liboclgrind-rt-icd.so"
CREATE_BUFFER = 14  # its place in the table of CL/cl_icd.h
USE_HOST_PTR, COPY_HOST_PTR, READ_ONLY = 1 << 3, 1 << 5, 1 << 2

BALL = "x^2 + y^2 + z^2 - 1"
# Between them every kernel file.
FORMULAS = {
    "polynomial": "x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 0.4",
    "powers": "x^7 + y^6 + (z^2 + 1/2)^(7/3) + Abs(y)^x - 1",
    "taylor": "32 x^6 - 48 x^4 + 18 x^2 - 1 + 32 y^6 - 48 y^4 + 18 y^2 - 1 + z",
    "smooth": "sin(3x) + cos(2y) + tan(z/2) + asin(x/3) + acos(y/3) + atan(z) + atan2(x, y + 3)",
    "exponential": "exp(x) + log(y + 3) + sinh(z/2) + cosh(y) + tanh(x) + sqrt(z + 2) + cbrt(y) - 5 + 1/(x + 3) + x/(y + 4)",
    "choice": "Min(x, y) + Max(y, z) + Abs(x) + Mod(z, 1) + floor(2x)/4 + ceiling(y)/4 + sign(z)/4 + Piecewise((x, y > 0), (-x, And(z > 0, x < 1)), (y, True))",
}


def _device(width: int) -> Any:
    """Oclgrind as the device of that name. It counts memory of the host that it uses in place as never written, so inputs are copied."""
    from implicitrt import _core

    library = ctypes.CDLL(LIBRARY)
    platform = ctypes.c_void_p()
    library.clIcdGetPlatformIDsKHR(1, ctypes.byref(platform), None)
    table = ctypes.cast(ctypes.cast(platform, ctypes.POINTER(ctypes.c_void_p))[0] or 0, ctypes.POINTER(ctypes.c_void_p))
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    signature = ctypes.CFUNCTYPE(pointer, pointer, ctypes.c_uint64, size, pointer, pointer)
    create = signature(table[CREATE_BUFFER] or 0)

    def copying(context: int, flags: int, length: int, host: int, code: int) -> int:
        if flags & READ_ONLY:
            flags = (flags & ~USE_HOST_PTR) | COPY_HOST_PTR
        made: int = create(context, flags, length, host, code)
        return made

    hook = signature(copying)
    table[CREATE_BUFFER] = ctypes.cast(hook, pointer).value
    device = _core.load_device(LIBRARY, "oclgrind", width)
    return device, (hook, create)


def _calls() -> Iterator[tuple[str, Callable[[], Any]]]:
    """What is drawn, traced and enclosed."""
    import implicitrt as irt

    small: dict[str, Any] = {"size": (19, 5), "bounds": 1.5, "device": "oclgrind"}
    # Of what is drawn again, or has parameters, precision "auto" has the kernel in double built by a thread behind the frame, in which Oclgrind 21 crashes.
    again = small | {"precision": "single"}
    for name, f in FORMULAS.items():
        for method in ("ia", "raa", "contract", "mitchell"):
            for precision in ("single", "double"):
                yield f"{name}, {method}, {precision}", lambda f=f, m=method, p=precision: irt.render(f, method=m, precision=p, max_pieces=300, **small)
    for method in irt.methods():
        yield f"ball, {method}", lambda m=method: irt.render(BALL, method=m, **(again if m == "auto" else small))
        yield f"ball, {method}, fast", lambda m=method: irt.render(BALL, method=m, rounding="fast", outputs=("pieces",), **small)
        yield f"rays, {method}", lambda m=method: irt.trace(BALL, [(0, 0, 5), (0.1, 0.2, 5), (3, 3, 5)], (0, 0, -1), bounds=2, method=m, device="oclgrind")
    regions = [1.5, irt.Sphere((0, 0, 0), 1.4), irt.HalfSpace((0, 0, 1), 0.4), irt.Clip("0.3 - x^2")]
    for method in ("ia", "contract"):
        yield f"regions, {method}", lambda m=method: irt.render("x^2 + a y^2 + z^2 - 1", **(again | {"bounds": regions}), method=m, params={"a": 1.1})
    # Frames of fewer pixels refine no roots.
    yield "refined", lambda: irt.render(BALL, **(small | {"size": (128, 128)}), method="frustum-newton", eps=1e-6, outputs=("normal",))
    for label, method in (("contract", "contract"), ("beams", irt.Contraction(beams=True)), ("ia", "ia")):
        yield f"narrowed down, {label}", lambda m=method: irt.render("sin(x)*y + z - exp(-x^2)/2", **small, method=m, eps=1e-6, outputs=("normal", "pieces"))
    yield "neighbours", lambda: irt.render(BALL, normals="neighbours", **again)
    yield "silhouettes", lambda: irt.render(BALL, antialias="silhouette", **again)
    yield "isovalue", lambda: irt.render("x^2 + y^2", isovalue=0.5, background=None, **again)
    for algebra in ("ia", "raa"):
        for name, f in FORMULAS.items():
            yield f"enclose {name}, {algebra}", lambda f=f, a=algebra: irt.enclose(f, [(0, 0, 0)] * 5, (1, 1, 1), algebra=a, device="oclgrind")


def simulate(width: int, quick: bool) -> list[str]:
    """Runs everything at one width, in this process; what Oclgrind said about each."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        # Without optimization: Oclgrind 21 does not know what LLVM's inliner leaves behind.
        os.environ.update(OCLGRIND_UNINITIALIZED="1", OCLGRIND_CHECK_API="1", OCLGRIND_LOG=str(log), OCLGRIND_BUILD_OPTIONS="-cl-opt-disable")
        import implicitrt as irt
        from implicitrt import _core, devices

        module = sys.modules[devices.__module__]
        device, alive = _device(width)
        module._choices["oclgrind"] = device  # type: ignore[attr-defined]
        atexit.register(device.finish)
        found, seen = [], 0
        calls = list(_calls())
        for what, call in calls[:: 9 if quick else 1]:
            started = time.perf_counter()
            call()
            said = log.read_text() if log.exists() else ""
            if said[seen:].strip():
                found.append(f"{what}:\n{said[seen:seen + 1500]}")
            seen = len(said)
            print(f"width {width}: {what}: {time.perf_counter() - started:.1f} s", file=sys.stderr, flush=True)
        # Nothing said means something only if a fault is not passed over: this kernel writes past its buffers.
        broken = with_change(Path(folder), "trace.cl", "packet_at(column", "packet_at(1000000 + column")
        _core.set_kernel_directory(str(broken))
        irt.render("x^2 + y^2 + 2 z^2 - 1", size=(19, 5), bounds=1.5, method="ia", outputs=(), device="oclgrind")
        said = log.read_text() if log.exists() else ""
        assert "Invalid write" in said[seen:], f"Oclgrind did not report a broken kernel: {said[seen:][:500]!r}"
        del alive
    return found


def main() -> None:
    """One width; prints what was found."""
    width, quick = int(sys.argv[1]), "--quick" in sys.argv
    found = simulate(width, quick)
    for report in found[:5]:
        print(report)
    print(f"width {width}: Oclgrind reports {len(found)} calls, and a kernel that was broken on purpose")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
