"""Speed beside a hand-written kernel, in one run: the Barth sextic, 1024 x 1024, medians of alternating runs.

    IMPLICITRT_TEST_DATA=... python benchmarks/speed.py [--runs 5]      needs pyopencl for the yardstick

Ratios are of medians over runs that alternate, so that other load on the machine hits both alike.
"""

from __future__ import annotations

import argparse
import statistics
import time

from common import CAMERA, EPS, table, yardstick

import implicitrt as irt

SIZE = 1024
FINE = 1e-6


def frame(
    method: str, rounding: str, outputs: tuple[str, ...], device: str | None = None, eps: float = EPS, precision: str = "single"
) -> tuple[float, float]:
    """Milliseconds of the kernel and of the whole call."""
    started = time.perf_counter()
    f = irt.render(
        irt.surfaces["barth_sextic"].expr, bounds=3, camera=CAMERA, eps=eps, size=(SIZE, SIZE), method=method,
        rounding=rounding, precision=precision, outputs=outputs, device=device,
    )  # fmt: skip
    return 1e3 * f.stats.seconds["kernel"], 1e3 * (time.perf_counter() - started)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    runs = parser.parse_args().runs
    width = irt.devices()[0].width
    times: dict[tuple[str, str], list[float]] = {}
    for run in range(runs + 1):
        rows = yardstick(SIZE, width)
        found: dict[tuple[str, str], float] = {}
        for method in ("raa", "ia", "contract"):
            found[method, "yardstick"] = rows["ia barth_sextic" if method == "ia" else "raa barth_sextic"]
            for rounding in ("fast", "outward"):
                pairs = [frame(method, rounding, ()) for _ in range(3)]
                found[method, f"kernel, {rounding}"] = statistics.median(k for k, _ in pairs)
                whole = [frame(method, rounding, ("rgb", "normal")) for _ in range(3)]
                found[method, f"render(), {rounding}"] = statistics.median(t for _, t in whole)
            found[method, "kernel, fast, width 1"] = frame(method, "fast", (), ":1")[0]
        # The yardstick's raa stops at 2^-11; its limit is one value of f and its gradient per pixel.
        fine = f"contract, eps {FINE:g}"
        found |= {(fine, "yardstick"): rows["raa barth_sextic"], (fine, "yardstick, limit"): rows["limit barth_sextic"]}
        found[fine, "kernel, outward"] = statistics.median(frame("contract", "outward", (), eps=FINE, precision="auto")[0] for _ in range(3))
        if run:  # the first run warms everything up
            for key, ms in found.items():
                times.setdefault(key, []).append(ms)
    medians = {key: statistics.median(v) for key, v in times.items()}
    lines = []
    for (method, what), ms in medians.items():
        fast = medians.get((method, "kernel, fast"))
        lines.append((method, what, f"{ms:.1f}", f"{ms / medians[method, 'yardstick']:.2f}", f"{ms / fast:.2f}" if fast else ""))
    device = irt.devices()[0]
    print(f"{device.name}, {device.driver}, {SIZE} x {SIZE}, medians of {runs} alternating runs\n")
    print(table(("method", "what", "ms", "of the yardstick", "of the fast kernel"), lines))


if __name__ == "__main__":
    main()
