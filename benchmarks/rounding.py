"""What rounding="outward" costs: kernel time over that of rounding="fast", medians of alternating runs.

python benchmarks/rounding.py [--runs 5] [--size 1024] [SURFACE ...]
"""

from __future__ import annotations

import argparse
import statistics

from common import CAMERA, EPS, table

import implicitrt as irt

SURFACES = ("barth_sextic", "gyroid", "sin_blob")


def kernel_ms(name: str, method: str, rounding: str, size: int) -> tuple[float, dict[str, int]]:
    """Milliseconds of the kernel, and how many pixels have which status."""
    surface = irt.surfaces[name]
    view = {"bounds": 3, "camera": CAMERA} if name == "barth_sextic" else {}
    f = irt.render(
        surface.expr if view else surface, eps=EPS, size=(size, size), method=method, rounding=rounding, precision="single", outputs=(), **view,
    )  # fmt: skip
    return 1e3 * f.stats.seconds["kernel"], f.stats.counts


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("surfaces", nargs="*", default=SURFACES)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--size", type=int, default=1024)
    given = parser.parse_args()
    lines = []
    for name in given.surfaces:
        for method in ("raa", "ia"):
            times: dict[str, list[float]] = {"fast": [], "outward": []}
            counts = {}
            for run in range(given.runs + 1):
                for rounding, ms in times.items():
                    found = [kernel_ms(name, method, rounding, given.size) for _ in range(3)]
                    if run:  # the first run warms everything up
                        ms.append(statistics.median(t for t, _ in found))
                    counts[rounding] = found[0][1]
            fast, outward = (statistics.median(times[r]) for r in ("fast", "outward"))
            c = counts["outward"]
            lines.append((name, method, f"{fast:.1f}", f"{outward:.1f}", f"{outward / fast:.2f}", c["HIT"], c["TOUCH"], c["UNRESOLVED"]))
    device = irt.devices()[0]
    print(f"{device.name}, {device.driver}, packets of {device.width}, {given.size} x {given.size}, eps {EPS}, medians of {given.runs} alternating runs\n")
    print(table(("surface", "method", "fast, ms", "outward, ms", "ratio", "HIT", "TOUCH", "UNRESOLVED"), lines))


if __name__ == "__main__":
    main()
