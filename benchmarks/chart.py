"""The speed-accuracy chart over twelve surfaces: writes docs/speed-accuracy.md and its picture.

python benchmarks/chart.py [--size 256] [--runs 5] [--output docs]
"""

from __future__ import annotations

import argparse
import datetime
import os
import sys
from pathlib import Path

from common import table

import implicitrt as irt

# Smooth, singular, of high degree, transcendental, CSG.
SURFACES = [
    "sphere", "tangle", "barth_sextic", "barth_decic", "cayley", "labs_7", "supersphere_16", "sin_blob", "gyroid",
    "blobby_molecule", "icos_csg", "menger_3",
]  # fmt: skip
METHODS = ["ia", "raa", "contract", "auto"]
WIDTHS = [2.0**-8, 2.0**-11, 2.0**-14, 2.0**-17, 2.0**-20]

TEXT = """# Speed against accuracy

Drawn on {date} by `python benchmarks/chart.py --size {size} --runs {runs}` on {device}; {size} x {size} pixels, `precision="auto"`,
`rounding="outward"`, medians of {runs} frames. Depth errors are against `irt.reference`. Milliseconds are of the kernels; ratios within one
surface are what to look at: machines differ and are shared.

![Largest depth error against time](speed-accuracy.png)

Rings mark the Pareto front; a red cross would mark a status that lies. Where a line goes up again, eps is below what single precision
resolves and `auto` repeats those pixels in double.

{summary}

## All points

{points}
"""


def main() -> None:
    """Writes the chart."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--output", default="docs")
    options = parser.parse_args()
    found = irt.compare(
        SURFACES, METHODS, WIDTHS, (options.size, options.size), runs=options.runs,
        progress=lambda line: print(line, file=sys.stderr, flush=True),
    )  # fmt: skip
    wrong = [p for p in found if p.wrong_misses or p.wrong_hits]
    rows = []
    for name in SURFACES:
        for eps in (WIDTHS[1], WIDTHS[3]):
            at = {p.method: p for p in found if p.formula == name and p.eps == eps}
            if len(at) == len(METHODS):
                rows.append(
                    [
                        name,
                        f"2^{eps.hex().split('p')[1]}",
                        *(f"{at[m].milliseconds:.1f}" for m in METHODS),
                        at["auto"].ran,
                    ]
                )
    summary = f"{len(found)} points, {len(wrong)} with a status that lies.\n\n" + table(
        ["surface", "eps", *(f"{m}, ms" for m in METHODS), "what auto ran"], rows
    )
    folder = Path(options.output)
    found.plot(folder / "speed-accuracy.png")
    text = TEXT.format(
        date=datetime.date.today().isoformat(), size=options.size, runs=options.runs,
        device=f"{found.device}, {os.cpu_count()} cores", summary=summary, points=found.to_markdown(),
    )  # fmt: skip
    (folder / "speed-accuracy.md").write_text(text, encoding="utf-8")
    if wrong:
        sys.exit(f"{len(wrong)} points have a status that lies")


if __name__ == "__main__":
    main()
