"""Inclusion of every operator, counted: random arguments against MPFR, on every driver, narrow and wide.

    python benchmarks/operators.py [--count 1e6] [--drivers all|best] [--widths all|widest] [--first-seed 100]

Prints a table with how many enclosures were compared with their values, and how many lacked them; the first ones are shown.
Exits with 1 where there are any. `count` is the number of arguments of each operator.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from common import table

import implicitrt as irt

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "python"))
import operators as cases

BATCH = 100_000  # arguments at a time, each batch with references of its own


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=float, default=1e6)
    parser.add_argument("--drivers", choices=("all", "best"), default="all")
    parser.add_argument("--widths", choices=("all", "widest"), default="all")
    parser.add_argument("--first-seed", type=int, default=100)
    options = parser.parse_args()
    devices = [d for d in irt.devices() if d.ok][: None if options.drivers == "all" else 1]
    choices = [(d.driver, w) for d in devices for w in ((1, d.width) if options.widths == "all" else (d.width,))]
    keys = [(d, w, p, a) for d, w in choices for p in ("single", "double") for a in ("ia", "raa")]
    counts, violations, shown = dict.fromkeys(keys, 0), dict.fromkeys(keys, 0), 0
    started = time.perf_counter()
    batches = max(1, round(options.count / BATCH))
    for batch in range(batches):
        points = cases.arguments(min(BATCH, int(options.count)), options.first_seed + batch)
        truth = cases.references(points)
        for driver, width, precision, algebra in keys:
            compared, bad = cases.check(points, truth, algebra, precision, f"{driver}:{width}")
            counts[driver, width, precision, algebra] += compared
            violations[driver, width, precision, algebra] += len(bad)
            for v in bad[: max(0, 20 - shown)]:
                print(driver, width, precision, algebra, v, flush=True)
            shown += len(bad)
        print(f"{batch + 1} of {batches}, {time.perf_counter() - started:.0f} s", file=sys.stderr, flush=True)
    rows = [[*key, f"{counts[key]:,}", violations[key]] for key in keys]
    print(table(["driver", "width", "precision", "algebra", "compared", "violations"], rows))
    total = sum(counts.values())
    print(
        f"\n{len(cases.OPERATORS)} operators, {total:,} enclosures, {sum(violations.values())} violations, {time.perf_counter() - started:.0f} s"
    )
    sys.exit(shown > 0)


if __name__ == "__main__":
    main()
