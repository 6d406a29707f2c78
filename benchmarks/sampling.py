"""Methods that sample beside those that prove, in one run: milliseconds of the kernel and pixels that are wrong.

python benchmarks/sampling.py [--size 512] [--runs 5]
"""

from __future__ import annotations

import argparse
import statistics

from common import table

import implicitrt as irt
from implicitrt import Status

SURFACES = ["barth_sextic", "steiner", "blobby_molecule", "menger_3"]
METHODS = ["ia", "ia-stack", "raa", "contract", *(name for name, m in irt.methods().items() if m.guarantee == "sampled")]
JUDGED = (128, 128)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    lines: list[tuple[object, ...]] = []
    for name in SURFACES:
        surface, truth = irt.surfaces[name], irt.reference(irt.surfaces[name], size=JUDGED)
        times: dict[str, list[float]] = {m: [] for m in METHODS}
        for _ in range(options.runs + 1):
            for method, found in times.items():
                frame = irt.render(surface, size=(options.size, options.size), method=method, precision="single", outputs=())
                found.append(1e3 * frame.stats.seconds["kernel"])
        medians = {m: statistics.median(found[1:]) for m, found in times.items()}
        for method in METHODS:
            frame = irt.render(surface, size=JUDGED, method=method, precision="single", outputs=("pieces",))
            missed = int((truth.hit & (frame.status == Status.MISS)).sum())
            false = int(((truth.kind == Status.MISS) & (frame.status == Status.HIT)).sum())
            both = (frame.status == Status.HIT) & truth.hit
            far = int((abs(frame.depth[both] - truth.depth[both]) > 2 * frame.bounds.default_eps).sum())
            lines.append((name, method, f"{medians[method]:.1f}", f"{medians[method] / medians['contract']:.2f}", f"{frame.pieces.mean():.0f}",
                          int(frame.pieces.max()), missed, false, far))  # fmt: skip
    device = irt.devices()[0]
    print(f"{device.name}, {device.driver}, {options.size} x {options.size}; wrong pixels of {JUDGED[0]} x {JUDGED[1]}\n")
    print(table(("surface", "method", "ms", "of contract", "looks a ray", "at most", "missed", "false hits", "another root"), lines))


if __name__ == "__main__":
    main()
