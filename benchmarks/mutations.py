"""Mutations: do tests notice a pad that is too small? Each constant that pads for rounding is made smaller, one after another, in
copies of the kernels in which every builtin errs by all that OpenCL permits, upwards and then downwards (tests/python/mutations.py).
Those outside the operators break what their functions promise, compiled as C++ (tests/python/contracts.py).

    python benchmarks/mutations.py [--only FUNCTION ...] [--record FILE] [--driver NAME] [--write]

Prints for each pad the largest share of it, among some, at which a value falls outside its enclosure or a contract is broken, and what noticed it.
Exits with 1 where a pad can be dropped unnoticed. With `--record` every pad is a line of a file, and what stands there is not done again.
`--write` puts the table into docs/rounding.md.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from common import table

import implicitrt as irt
from implicitrt import _core

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "python"))
import contracts
import mutations

ROOT = Path(__file__).resolve().parent.parent
SHARES = (0.99, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)
MARK = "<!-- benchmarks/mutations.py writes what follows -->\n"


def smallest(breaks: Callable[[float], object]) -> float:
    """The largest share at which a pad is noticed that is noticed at 0: by halving."""
    few, many = 0, len(SHARES) - 1
    while few < many:
        middle = (few + many) // 2
        few, many = (few, middle) if breaks(SHARES[middle]) else (middle + 1, many)
    return SHARES[many]


def noticed(judge: mutations.Judge, pad: mutations.Pad) -> tuple[float, str]:
    """The largest share at which a look loses a value, and that look; "" where none does without the pad."""
    found = judge.lost(pad, 0.0, mutations.looks_at(pad))
    if found is None:
        return 0.0, ""
    formula, algebra, kind = found
    return smallest(lambda share: judge.lost(pad, share, [found])), f"`{formula}`, {algebra}, {kind}"


def broken(judge: contracts.Judge, pad: mutations.Pad) -> tuple[float, str]:
    """The largest share at which a contract is broken, and that contract."""
    shares = []
    for contract in contracts.contracts_of(pad):
        if judge.breaks(pad, 0.0, [contract]):
            shares.append((smallest(partial(judge.breaks, pad, contracts=[contract])), contract))
    if not shares:
        return 0.0, ""
    share, contract = max(shares)
    return share, f"contract `{contract}`, {judge.breaks(pad, share, [contract])[1]}"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", help="functions")
    parser.add_argument("--record", type=Path)
    parser.add_argument("--driver", default=next(d.driver for d in irt.devices() if d.ok and d.fp64))
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    kernels = Path(_core.__file__).resolve().parent / "kernels"
    known = {}
    if options.record and options.record.exists():
        known = {(*row[:3], row[3]): row[4:] for row in map(json.loads, options.record.read_text().splitlines())}
    rows, unnoticed = [], 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ["POCL_CACHE_DIR"] = str(Path(folder) / "cache")
        judge = mutations.Judge(kernels, Path(folder), options.driver)
        judges = [(pad, noticed, judge) for pad in mutations.all_pads(kernels)]
        contract_judge = contracts.Judge(kernels, Path(folder))
        judges += [(pad, broken, contract_judge) for pad in contract_judge.pads]
        for pad, how, by_what in judges:
            if options.only and pad.function not in options.only:
                continue
            key, started = (pad.file, pad.function, pad.text, pad.start), time.perf_counter()
            if key not in known:
                known[key] = how(by_what, pad)
                if options.record:
                    with options.record.open("a") as file:
                        file.write(json.dumps([*key, *known[key]]) + "\n")
                print(*key, *known[key], f"{time.perf_counter() - started:.0f} s", file=sys.stderr, flush=True)
            share, by = known[key]
            unnoticed += not by
            rows.append([pad.file, f"`{pad.function}`", f"`{pad.text}`", f"{share:g}" if by else "never", by])
    text = table(["file", "in", "pad", "noticed at a share of", "by"], rows)
    text += f"\n\n{len(rows)} pads, {unnoticed} never noticed"
    print(text)
    if options.write:
        document = ROOT / "docs" / "rounding.md"
        document.write_text(document.read_text().split(MARK)[0] + MARK + "\n" + text + "\n")
    sys.exit(unnoticed > 0)


if __name__ == "__main__":
    main()
