"""Time against degree, and what the reference says: Chmutov's surfaces of even degree 2 to 30 as printed (expanded), and two named
surfaces, 128 x 128.

    python benchmarks/degrees.py [--method frustum-newton] [--least 2] [--most 30] [--chart docs/frustum-degrees.png]

Counts of statuses that lie: MISS where the reference has a hit, HIT where it has a miss, brackets that do not hold its root.
"""

from __future__ import annotations

import argparse
import statistics
import time
from typing import Any

import numpy as np
from common import table

import implicitrt as irt
from implicitrt import Status


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


def main() -> None:
    """Prints the table, and draws the chart."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--method", default="frustum-newton")
    parser.add_argument("--least", type=int, default=2)
    parser.add_argument("--most", type=int, default=30)
    parser.add_argument("--chart")
    args = parser.parse_args()
    degrees, times, rows = list(range(args.least, args.most + 1, 2)), [], []
    surfaces: list[tuple[str, Any, dict[str, Any]]] = [(f"chmutov {n}", chmutov(n), {"bounds": 1.1}) for n in degrees]
    surfaces += [(name, irt.surfaces[name], {}) for name in ("sarti_12", "supersphere_16") if args.least <= irt.surfaces[name].degree <= args.most]
    for name, f, call in surfaces:
        call |= {"size": (128, 128)}
        frame = irt.render(f, method=args.method, **call)
        # The second frame of a degree has its pass in double compiled in the background.
        irt.render(f, method=args.method, **call)
        time.sleep(1.2)
        stats = [irt.render(f, method=args.method, **call).stats for _ in range(5)]
        kernel, prepare, total = (
            1e3 * statistics.median(s.seconds.get(k, 0) for s in stats) for k in ("kernel", "prepare", "total")
        )
        times.append((kernel, prepare, total))
        again, asked = (100 * n / frame.status.size for n in (frame.stats.escalated, frame.stats.by_reference))
        rows.append((
            name, f"{kernel:.1f}", f"{prepare:.1f}", f"{total:.1f}", f"{again:.2f} %", f"{asked:.2f} %", lies(frame, irt.reference(f, **call)),
            " ".join(str(n) for n in frame.stats.counts.values()),
        ))  # fmt: skip
    head = ("surface", "kernel ms", "coefficients ms", "render() ms", "escalated", "by reference", "lies", "MISS HIT TOUCH UNRESOLVED")
    print(table(head, rows))
    if args.chart:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6, 4), layout="constrained")
        axes = figure.subplots()
        for what, ms in zip(("kernel", "coefficients", "render()"), zip(*times[: len(degrees)], strict=True), strict=True):
            axes.semilogy(degrees, ms, marker="o", label=what)
        axes.set(xlabel="degree", ylabel="milliseconds a frame, 128 x 128", title=f"Chmutov's surfaces, {args.method}")
        axes.grid(alpha=0.3)
        axes.legend()
        figure.savefig(args.chart, dpi=100)


if __name__ == "__main__":
    main()
