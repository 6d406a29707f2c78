"""How many pieces of its ray each method looks at: what affine forms save against intervals.

python benchmarks/pieces.py [NAME ...]
"""

from __future__ import annotations

import statistics
import sys

from common import table

import implicitrt as irt

NAMES = [
    "sin_blob",
    "cloth",
    "water",
    "blobby",
    "gyroid",
    "blobby_molecule",
    "scherk",
    "diamond",
    "noise_csg",
    "icos_csg",
]


def main(names: list[str]) -> None:
    """Prints the table."""
    rows = []
    for name in names:
        row: list[object] = [name]
        for method in ("ia", "raa"):
            keywords = {"size": (512, 512), "method": method, "precision": "single"}
            counted = irt.render(irt.surfaces[name], outputs=("pieces",), **keywords)
            frames = [irt.render(irt.surfaces[name], outputs=(), **keywords) for _ in range(6)]
            milliseconds = 1e3 * statistics.median(f.stats.seconds["kernel"] for f in frames[1:])
            row += [f"{counted.pieces.mean():.1f}", f"{milliseconds:.1f}"]
        row += [f"{float(row[1]) / float(row[3]):.2f}", f"{float(row[2]) / float(row[4]):.2f}"]
        rows.append(row)
    print(table(["surface", "pieces a ray, ia", "ms", "raa", "ms", "pieces saved: times", "time: times"], rows))


if __name__ == "__main__":
    main(sys.argv[1:] or NAMES)
