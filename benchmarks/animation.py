"""Frame coherence (S2 section 4.2): an orbit of 100 frames, and a slider moved in 100 steps, with and without `previous=frame`.

    python benchmarks/animation.py [--methods frustum-newton,frustum-lr] [--frames 100] [--size 512]

Each frame is drawn both ways, one after the other. Ratios are of medians. Compared are statuses, depths beside what both brackets
allow, and colours, which follow the depths within eps; any difference of the first two is a fault.
"""

from __future__ import annotations

import argparse
import math
import statistics
from typing import Any

import numpy as np
from common import table

import implicitrt as irt
from implicitrt import Status


def orbit(name: str, frames: int) -> list[tuple[Any, dict[str, Any]]]:
    """A degree a frame about the vertical through the middle of the bounds."""
    surface = irt.surfaces[name]
    camera = surface.camera
    x, y, z = camera.origin
    calls = []
    for k in range(frames):
        c, s = math.cos(math.radians(k)), math.sin(math.radians(k))
        moved = irt.Camera((c * x + s * z, y, c * z - s * x), camera.target, camera.up, camera.fov)
        calls.append((surface.expr, {"bounds": surface.bounds, "camera": moved}))
    return calls


def slider(frames: int) -> list[tuple[Any, dict[str, Any]]]:
    """Tangle and what it grows into."""
    f = irt.parse("x^4 - 5x^2 + y^4 - 5y^2 + z^4 - 5z^2 + a")
    return [(f, {"bounds": 3, "params": {"a": 10 + 4 * k / frames}}) for k in range(frames)]


def differences(plain: irt.Frame, seeded: irt.Frame) -> tuple[int, int, int]:
    """Pixels whose status differs, of whose brackets no root is in both, and whose colours differ by more than 2 of 255."""
    both = (plain.status == Status.HIT) & (seeded.status == Status.HIT)
    far = np.abs(plain.depth[both] - seeded.depth[both]) > plain.uncertainty[both] + seeded.uncertainty[both]
    colours = (np.abs(plain.rgb.astype(int) - seeded.rgb.astype(int)).max(-1) > 2).sum()
    return int((plain.status != seeded.status).sum()), int(far.sum()), int(colours)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--methods", default="frustum-newton,frustum-lr,frustum-mr")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--size", type=int, default=512)
    args = parser.parse_args()
    animations = {name: orbit(name, args.frames) for name in ("tangle", "barth_sextic", "barth_decic")} | {"tangle, slider": slider(args.frames)}
    rows = []
    for name, calls in animations.items():
        for method in args.methods.split(","):
            shape = {"size": (args.size, args.size), "method": method}
            previous = None
            times: list[list[float]] = []
            sums = np.zeros(3)
            for f, call in calls:
                plain = irt.render(f, **call, **shape)
                seeded = irt.render(f, **call, **shape, previous=previous)
                if previous is not None:
                    times.append([x.stats.seconds[k] for k in ("kernel", "total") for x in (plain, seeded)])
                    sums += differences(plain, seeded)
                previous = seeded
            kernel, kernel_seeded, total, total_seeded = (1e3 * statistics.median(t) for t in zip(*times, strict=True))
            rows.append((
                name, method, f"{kernel:.1f}", f"{kernel_seeded:.1f}", f"{kernel / kernel_seeded:.2f}", f"{total:.1f}", f"{total_seeded:.1f}",
                f"{total / total_seeded:.2f}", int(sums[0]), int(sums[1]), f"{100 * sums[2] / len(times) / args.size**2:.4f} %",
            ))  # fmt: skip
    head = ("animation", "method", "kernel ms", "with", "ratio", "render() ms", "with", "ratio", "statuses differ", "depths differ", "colours differ")
    print(table(head, rows))


if __name__ == "__main__":
    main()
