"""Table 1 of S1 (Knoll et al. 2008), redrawn beside the printed numbers.

    python benchmarks/table1.py [--size 1024]        writes docs/table1.md

Frames per second by kernel time, shaded, at eps = 2^-11 of the largest side of the bounds, from the
cameras of the named surfaces. The paper's cameras are not known, and surfaces marked * are reconstructions: the
comparison is one of orders of magnitude.
"""

from __future__ import annotations

import argparse
import statistics
from pathlib import Path

from common import table

import implicitrt as irt

# Degree, CPU IA, GPU IA, GPU RAA as printed; None where there is no number.
PRINTED: dict[str, tuple[float | None, float | None, float | None]] = {
    "sphere": (15, 75, 147), "steiner": (7.5, 34, 40), "mitchell": (5.2, 16, 58), "teardrop": (5.5, 102, 115),
    "bretzel4": (13, 78, 48), "klein_bottle": (11, 30, 110), "tangle": (3.2, 15, 68), "decocube": (5.5, 28, 27),
    "barth_sextic": (7.4, 31, 76), "barth_decic": (0.9, 4.9, 15.6), "superquadric_200": (18, 119, 8.3),
    "icos_csg": (None, 13.3, None), "sq_csg": (None, 8.9, None), "sin_blob": (None, 6.0, None), "cloth": (None, 38, None),
    "water": (None, 37, None),
}  # fmt: skip
RUNS = [
    ("ia", "fast"), ("raa", "fast"), ("ia", "outward"), ("raa", "outward"), ("contract", "fast"), ("contract", "outward"), ("auto", "outward"),
]  # fmt: skip
ROUNDS = 7


def main() -> None:
    """Measures, prints and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=1024)
    size = parser.parse_args().size
    lines, behind = [], []
    for name, printed in PRINTED.items():
        surface = irt.surfaces[name]
        eps = max(b - a for a, b in zip(surface.bounds.lower, surface.bounds.upper, strict=True)) / 2048
        times: dict[tuple[str, str], list[float]] = {run: [] for run in RUNS}
        for round_ in range(ROUNDS + 1):  # alternating: other load on the machine hits all alike; the first warms everything up
            for method, rounding in RUNS:
                frame = irt.render(surface, size=(size, size), eps=eps, method=method, rounding=rounding, precision="single", outputs=("rgb",))
                if round_:
                    times[method, rounding].append(frame.stats.seconds["kernel"])
        rates = [1 / statistics.median(t) for t in times.values()]
        shown = ["-" if p is None else f"{p:g}" for p in printed]
        gpu = max(p for p in printed[1:] if p is not None)
        behind += [name] * (rates[-1] < gpu)
        lines.append((name + "*" * surface.reconstructed, surface.degree or "-", *shown, *(f"{r:.1f}" for r in rates), f"{rates[-1] / gpu:.1f}"))
        print(lines[-1], flush=True)
    device = irt.devices()[0]
    text = (
        f"# Table 1 of Knoll et al. 2008, redrawn\n\nFrames per second by kernel time, shaded, at {size} x {size}, eps 2^-11 of the "
        f"largest side of the bounds; {device.name}, {device.driver}, packets of {device.width}; * reconstructed: the paper "
        "gives only a name. Printed: four Xeon cores (SSE), and an NVIDIA 8800 GTX, from cameras that are not known. "
        "The last column divides `auto`, which proves its statuses, by the better of the printed GPU numbers; it is behind at "
        f"{', '.join(behind) or 'none'}. Written by `benchmarks/table1.py`.\n\n"
        + table(
            (
                "surface",
                "degree",
                "printed CPU IA",
                "printed GPU IA",
                "printed GPU RAA",
                *(f"{method}, {rounding}" for method, rounding in RUNS),
                "auto / GPU",
            ),
            lines,
        )
        + "\n"
    )
    (Path(__file__).parents[1] / "docs" / "table1.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
