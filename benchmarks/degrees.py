"""Time against degree, and what the reference says: Chmutov's surfaces of even degree 2 to 30 as printed (expanded), and two named
surfaces, 128 x 128.

    python benchmarks/degrees.py [--method frustum-newton] [--least 2] [--most 30] [--chart docs/frustum-degrees.png] [--state out/degrees.jsonl]
        [--seconds 100]

Counts of statuses that lie: MISS where the reference has a hit, HIT where it has a miss, brackets that do not hold its root. Times are medians of
five frames; of one where a frame takes more than SLOW seconds. What is done is written down in `state` and not done again: with --seconds a
call stops after about so long, and the next one goes on.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import table

import implicitrt as irt
from implicitrt import Status
from implicitrt.devices import open_device

SLOW = 1.0


def chmutov(n: int) -> irt.Expr:
    """T_n(x) + T_n(y) + T_n(z) + 1, T_n being Chebyshev's polynomial with its coefficients multiplied out."""
    t = [[1], [0, 1]]
    for _ in range(n - 1):
        t.append([2 * a - b for a, b in zip([0, *t[-1]], [*t[-2], 0, 0], strict=True)])
    terms = [f"{c}*{v}^{k}" for v in "xyz" for k, c in enumerate(t[n]) if c]
    return irt.parse(" + ".join(["1", *(f"({term})" for term in terms)]))


def lies(frame: irt.Frame, truth: irt.Reference) -> int:
    """How many pixels say what is not so."""
    wrong = (frame.status == Status.MISS) & truth.hit | (frame.status == Status.HIT) & (truth.kind == Status.MISS)
    both = (frame.status == Status.HIT) & truth.hit
    far = np.abs(frame.depth[both] - truth.depth[both]) > (frame.uncertainty + truth.uncertainty)[both]
    return int(wrong.sum() + far.sum())


def measured(f: Any, method: str, call: dict[str, Any]) -> dict[str, Any]:
    """One surface: times in milliseconds, shares of pixels, lies, statuses."""
    first = irt.render(f, method=method, **call)
    slow = first.stats.seconds["total"] - first.stats.seconds["build"] > SLOW
    if not slow:
        # The second frame of a degree has its pass in double compiled in the background.
        irt.render(f, method=method, **call)
        open_device(None).finish()
    frames = [irt.render(f, method=method, **call) for _ in range(1 if slow else 5)]
    frame = frames[-1]
    return {
        "ms": [1e3 * statistics.median(g.stats.seconds.get(k, 0) for g in frames) for k in ("kernel", "prepare", "total")],
        "shares": [100 * n / frame.status.size for n in (frame.stats.escalated, frame.stats.by_reference)],
        "lies": lies(frame, irt.reference(f, **call)),
        "counts": list(frame.stats.counts.values()),
    }


def main() -> None:
    """Prints the table, and draws the chart."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--method", default="frustum-newton")
    parser.add_argument("--least", type=int, default=2)
    parser.add_argument("--most", type=int, default=30)
    parser.add_argument("--state", type=Path)
    parser.add_argument("--seconds", type=float, default=np.inf)
    parser.add_argument("--chart")
    args = parser.parse_args()
    started = time.perf_counter()
    degrees = list(range(args.least, args.most + 1, 2))
    surfaces: list[tuple[str, Any, dict[str, Any]]] = [(f"chmutov {n}", chmutov(n), {"bounds": 1.1}) for n in degrees]
    surfaces += [(name, irt.surfaces[name], {}) for name in ("sarti_12", "supersphere_16") if args.least <= irt.surfaces[name].degree <= args.most]
    done = dict(json.loads(line) for line in args.state.read_text().splitlines()) if args.state and args.state.exists() else {}
    for name, f, call in surfaces:
        if name in done:
            continue
        if time.perf_counter() - started > args.seconds:
            print(f"{len(done)} of {len(surfaces)} done")
            return
        done[name] = measured(f, args.method, call | {"size": (128, 128)})
        if args.state:
            with args.state.open("a") as file:
                file.write(json.dumps([name, done[name]]) + "\n")
    head = ("surface", "kernel ms", "coefficients ms", "render() ms", "escalated", "by reference", "lies", "MISS HIT TOUCH UNRESOLVED")
    print(table(head, [
        (name, *(f"{ms:.1f}" for ms in r["ms"]), *(f"{share:.2f} %" for share in r["shares"]), r["lies"], " ".join(map(str, r["counts"])))
        for name, r in ((name, done[name]) for name, *_ in surfaces)
    ]))  # fmt: skip
    if args.chart:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6, 4), layout="constrained")
        axes = figure.subplots()
        for what, ms in zip(("kernel", "coefficients", "render()"), zip(*(done[f"chmutov {n}"]["ms"] for n in degrees), strict=True), strict=True):
            axes.semilogy(degrees, ms, marker="o", label=what)
        axes.set(xlabel="degree", ylabel="milliseconds a frame, 128 x 128", title=f"Chmutov's surfaces, {args.method}")
        axes.grid(alpha=0.3)
        axes.legend()
        figure.savefig(args.chart, dpi=100)


if __name__ == "__main__":
    main()
