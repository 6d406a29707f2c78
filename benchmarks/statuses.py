"""What statuses are worth: every named surface and 200 seeded formulas, each way, eps 1e-2 to 1e-6, against irt.reference.

    python benchmarks/statuses.py [--formulas 200] [--size 48] [--first 0]

Stops at the first status that lies. Prints how many simple roots were HIT, and how much stayed open.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import table

import implicitrt as irt
from implicitrt import Status

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "python"))
from formulas import check, formula

WIDTHS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
METHODS = ("ia", "raa", "contract", irt.Mitchell("ia"), irt.Mitchell("raa"))


def surface(name: str, size: int) -> list[object]:
    """A row for one named surface; asserts that no status lies."""
    s = irt.surfaces[name]
    o, d = (a.reshape(-1, 3) for a in s.camera.framed(s.bounds).rays((size, size)))
    truth = irt.reference(s, o, d, bounds=s.bounds)
    misses = np.pad((truth.kind == Status.MISS).reshape(size, size), 1, mode="edge")
    near = np.stack([misses[i : i + size, j : j + size] for i in range(3) for j in range(3)])
    away = (near.all(0) | ~near.any(0)).ravel()
    row: list[object] = [name, int((truth.kind == Status.HIT).sum()), int((truth.kind == Status.UNRESOLVED).sum())]
    for method in METHODS:
        for eps in WIDTHS:
            hits = irt.trace(s, o, d, bounds=s.bounds, method=method, eps=eps)
            proven = hits.status == Status.HIT
            with np.errstate(invalid="ignore"):
                apart = (truth.bracket[:, 1] < hits.t - hits.uncertainty) | (
                    truth.bracket[:, 0] > hits.t + hits.uncertainty
                )
            assert not (truth.hit & (hits.status == Status.MISS)).any(), f"wrong MISS: {name}, {method}, {eps}"
            assert not ((truth.kind == Status.MISS) & proven).any(), f"wrong HIT: {name}, {method}, {eps}"
            assert not (proven & truth.hit & apart).any(), f"bracket without its root: {name}, {method}, {eps}"
            if eps == 1e-4:
                simple = (truth.kind == Status.HIT) & away
                share = (simple & proven).sum() / max(simple.sum(), 1)
                row += [f"{share:.4f}", f"{(hits.status == Status.UNRESOLVED).mean():.4f}"]
    return row


def main() -> None:
    """Prints both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--formulas", type=int, default=200)
    parser.add_argument("--size", type=int, default=48)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    started = time.perf_counter()
    rows = [surface(name, options.size) for name in irt.surfaces]
    print(
        table(
            [
                "surface",
                "simple roots",
                "undecided",
                *(text for m in METHODS for text in (f"{m}: HIT at 1e-4", "UNRESOLVED")),
            ],
            rows,
        ),
        flush=True,
    )

    sums: dict[tuple[Any, float], dict[str, int]] = {(m, e): {} for m in METHODS for e in WIDTHS}
    with_hits = 0
    for seed in range(options.first, options.first + options.formulas):
        counts = check(formula(seed), 400, seed, METHODS, WIDTHS)
        with_hits += next(iter(counts.values()))["simple"] > 0
        for key, c in counts.items():
            for what, n in c.items():
                sums[key][what] = sums[key].get(what, 0) + n
    rows = [
        [m, f"{e:g}", c["rays"], c["simple"], f"{c['hits'] / c['simple']:.4f}", c["unresolved"], c["undecided"]]
        for (m, e), c in sums.items()
    ]
    print(f"\n{options.formulas} formulas, {with_hits} of them with hits\n")
    print(
        table(
            ["method", "eps", "rays", "simple roots", "of them HIT", "UNRESOLVED", "undecided by the reference"], rows
        )
    )
    print(f"\nno status lied; {time.perf_counter() - started:.0f} s")


if __name__ == "__main__":
    main()
