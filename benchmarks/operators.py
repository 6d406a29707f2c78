"""Inclusion of every operator, counted: random arguments against MPFR, on every driver, narrow and wide.

    python benchmarks/operators.py [--count 1e6] [--drivers all|best] [--widths all|widest] [--algebras ia raa]
        [--precisions single double] [--first-seed 100] [--record FILE] [--seconds 200]

Prints a table with how many enclosures were compared with their values, and how many lacked them; the first ones are shown.
Exits with 1 where there are any. `count` is the number of arguments of each operator. With `--record` every batch is a line of a
file; what stands there is not done again, and the table is of the whole file, so that a long sweep can be cut (`--seconds`) and go on.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from common import table

import implicitrt as irt

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "python"))
import operators as cases

BATCH = 100_000  # arguments at a time, each batch with references of its own
Row = tuple[int, str, int, str, str, int, int]  # seed, driver, width, precision, algebra, compared, violations


def rows_of(record: Path | None) -> list[Row]:
    """What a file holds."""
    if record is None or not record.exists():
        return []
    return [tuple(json.loads(line)) for line in record.read_text().splitlines()]


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=float, default=1e6)
    parser.add_argument("--drivers", choices=("all", "best"), default="all")
    parser.add_argument("--widths", choices=("all", "widest"), default="all")
    parser.add_argument("--algebras", nargs="+", choices=("ia", "raa"), default=["ia", "raa"])
    parser.add_argument("--precisions", nargs="+", choices=("single", "double"), default=["single", "double"])
    parser.add_argument("--first-seed", type=int, default=100)
    parser.add_argument("--record", type=Path)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="no batch begins after this time")
    options = parser.parse_args()
    devices = [d for d in irt.devices() if d.ok][: None if options.drivers == "all" else 1]
    choices = [(d.driver, w) for d in devices for w in ((1, d.width) if options.widths == "all" else (d.width,))]
    keys = [(d, w, p, a) for d, w in choices for p in options.precisions for a in options.algebras]
    rows, shown, started = rows_of(options.record), 0, time.perf_counter()
    batches = max(1, round(options.count / BATCH))
    for seed in range(options.first_seed, options.first_seed + batches):
        known = {row[:5] for row in rows}
        missing = [key for key in keys if (seed, *key) not in known]
        if not missing:
            continue
        if time.perf_counter() - started > options.seconds:
            break
        points = cases.arguments(min(BATCH, int(options.count)), seed)
        truth = cases.references(points)
        for driver, width, precision, algebra in missing:
            compared, bad = cases.check(points, truth, algebra, precision, f"{driver}:{width}")
            rows.append((seed, driver, width, precision, algebra, compared, len(bad)))
            if options.record:
                with options.record.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
            for v in bad[: max(0, 20 - shown)]:
                print(driver, width, precision, algebra, v, flush=True)
            shown += len(bad)
        print(f"seed {seed}, {time.perf_counter() - started:.0f} s", file=sys.stderr, flush=True)
    printed = []
    for key in dict.fromkeys(row[1:5] for row in rows):
        of_key = [row for row in rows if row[1:5] == key]
        compared, bad = sum(row[5] for row in of_key), sum(row[6] for row in of_key)
        printed.append([*key, len(of_key), f"{compared:,}", bad])
    print(table(["driver", "width", "precision", "algebra", "batches", "compared", "violations"], printed))
    total, violations = sum(row[5] for row in rows), sum(row[6] for row in rows)
    print(f"\n{len(cases.OPERATORS)} operators, {total:,} enclosures, {violations} violations")
    sys.exit(violations > 0)


if __name__ == "__main__":
    main()
