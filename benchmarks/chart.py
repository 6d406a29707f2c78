"""The speed-accuracy chart over twelve surfaces, by every method: writes docs/speed-accuracy.md, .csv and .png.

    python benchmarks/chart.py [--size 256] [--runs 5] [--output docs] [--surfaces barth_sextic,labs_7]

With --surfaces only these are drawn anew, and the others stay as the table in the output folder has them: on a shared machine all twelve are
drawn one after the other, each in a quiet minute.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import datetime
import os
import statistics
import sys
from pathlib import Path
from typing import Any

from common import table

import implicitrt as irt
from implicitrt.compare import Point

# Smooth, singular, of high degree, transcendental, CSG.
SURFACES = [
    "sphere", "tangle", "barth_sextic", "barth_decic", "cayley", "labs_7", "supersphere_16", "sin_blob", "gyroid",
    "blobby_molecule", "icos_csg", "menger_3",
]  # fmt: skip
SHOWN = ["ia", "raa", "contract", "auto"]  # in the short table
WIDTHS = [2.0**-8, 2.0**-11, 2.0**-14, 2.0**-17, 2.0**-20]

TEXT = """# Speed against accuracy

Drawn on {date} by `python benchmarks/chart.py --size {size} --runs {runs}` on {device}; {size} x {size} pixels, `precision="auto"`,
`rounding="outward"`, medians of {runs} frames. Depth errors are against `irt.reference`. Milliseconds are of the kernels and of the frustum form's coefficients, which the host
makes for each frame; ratios within one surface are what to look at: machines differ and are shared.

![Largest depth error against time](speed-accuracy.png)

Rings mark the Pareto front; a red cross marks wrong statuses: roots that were missed, and hits where there is nothing. Only methods that sample
(dashed) have any. Where a line goes up again, eps is below what single precision resolves and `auto` repeats those pixels in double. The
tests redraw a part of the chart and fail where statuses or errors contradict this one (`tests/python/test_chart.py`).

{summary}

All points are in [speed-accuracy.csv](speed-accuracy.csv).
"""


def as_good(p: Any, auto: Any) -> bool:
    """Whether a point is at least as accurate as auto's, and leaves no more open."""
    return p.largest_error <= auto.largest_error and p.touching + p.unresolved + p.wide <= auto.touching + auto.unresolved + auto.wide


def main() -> None:
    """Writes the chart."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--output", default="docs")
    parser.add_argument("--surfaces", default=",".join(SURFACES))
    options = parser.parse_args()
    chosen = options.surfaces.split(",")
    kept = [] if chosen == SURFACES else drawn_before(Path(options.output) / "speed-accuracy.csv", chosen)
    found = irt.compare(
        chosen, None, WIDTHS, (options.size, options.size), runs=options.runs,
        progress=lambda line: print(line, file=sys.stderr, flush=True),
    )  # fmt: skip
    points = sorted([*kept, *found], key=lambda p: SURFACES.index(p.formula))
    growth = {name: growth_of(name, found.size) for name in SURFACES}
    wrong = write(irt.Comparison(points, found.size, found.device), growth, options.runs, Path(options.output))
    if wrong:
        sys.exit(f"{wrong} points have a status that lies")


def drawn_before(path: Path, chosen: list[str]) -> list[Point]:
    """The points of a table, but those of the surfaces `chosen`."""
    kinds = {"str": str, "float": float, "int": int}
    with path.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["formula"] not in chosen]
    return [Point(**{f.name: kinds[str(f.type)](row[f.name]) for f in dataclasses.fields(Point)}) for row in rows]


def growth_of(name: str, size: tuple[int, int]) -> float:
    """How many times as long kernels of `auto` take at the finest eps as at the widest, by medians of frames in turns: other load on the machine hits both alike."""
    times: dict[float, list[float]] = {WIDTHS[0]: [], WIDTHS[-1]: []}
    for turn in range(24):
        for eps, seconds in times.items():
            frame = irt.render(irt.surfaces[name], size=size, eps=eps, outputs=("normal",))
            if turn > 2:  # the first ones build
                seconds.append(frame.stats.seconds["kernel"])
    return statistics.median(times[WIDTHS[-1]]) / statistics.median(times[WIDTHS[0]])


def write(found: irt.Comparison, growth: dict[str, float], runs: int, folder: Path) -> int:
    """Writes the page, its table and its picture; returns how many proven statuses lie."""
    proven = {name for name, m in irt.methods().items() if m.guarantee == "inclusion"}
    wrong = [p for p in found if p.method in proven and (p.wrong_misses or p.wrong_hits)]
    rows, beaten = [], []
    for name in SURFACES:
        for eps in WIDTHS:
            at = {p.method: p for p in found if p.formula == name and p.eps == eps}
            auto = at["auto"]
            # What auto ran is auto, but for the noise of two measurements.
            others = [at[m] for m in proven & set(at) if as_good(at[m], auto) and not auto.ran.startswith(m + ",")]
            fastest = min([auto, *others], key=lambda p: p.milliseconds)
            ratio = auto.milliseconds / fastest.milliseconds
            if ratio > 1.25:
                beaten.append(f"{name} at 2^{eps.hex().split('p')[1]}: {fastest.method}, {ratio:.2f}")
            if eps in (WIDTHS[1], WIDTHS[3]):
                rows.append([
                    name, f"2^{eps.hex().split('p')[1]}", *(f"{at[m].milliseconds:.1f}" for m in SHOWN), auto.ran,
                    f"{fastest.method}, {fastest.milliseconds:.1f}",
                ])  # fmt: skip
    at_eps = {(p.formula, p.method, p.eps): p.milliseconds for p in found}
    gains = [at_eps[name, "raa", eps] / at_eps[name, "contract", eps] for name in SURFACES for eps in WIDTHS]
    summary = (
        f"{len(found)} points; {len(wrong)} of methods that prove their statuses have one that lies. An inclusion method that is at least as "
        f"accurate is more than 1.25 times as fast as `auto` at {len(beaten)} of {len(SURFACES) * len(WIDTHS)} points"
        + (": " + "; ".join(beaten) if beaten else "") + f". `contract` is {statistics.geometric_mean(gains):.2f} times as fast as `raa` at equal eps "
        f"(geometric mean, least {min(gains):.2f}). From 2^-8 to 2^-20 the kernels of `auto` take longer by (frames of both in turns): {', '.join(f'{name} {times:.2f}' for name, times in growth.items())}.\n\n"
    ) + table(
        ["surface", "eps", *(f"{m}, ms" for m in SHOWN), "what auto ran", "fastest as accurate as auto"], rows
    )  # fmt: skip
    found.plot(folder / "speed-accuracy.png")
    found.to_csv(folder / "speed-accuracy.csv")
    text = TEXT.format(
        date=datetime.date.today().isoformat(), size=found.size[0], runs=runs,
        device=f"{found.device}, {os.cpu_count()} cores", summary=summary,
    )  # fmt: skip
    (folder / "speed-accuracy.md").write_text(text, encoding="utf-8")
    return len(wrong)


if __name__ == "__main__":
    main()
