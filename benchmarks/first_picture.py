"""The first picture of a new formula in a process that has drawn before: parse, build, first launch and frame apart.

python benchmarks/first_picture.py [--named]
"""

from __future__ import annotations

import argparse
import random
import statistics
from collections.abc import Callable
from functools import partial

from common import table

import implicitrt as irt

# The random number makes each formula new to every cache.
FORMULAS = (
    "x^2 + y^2 + z^2 - {}",
    "x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + {}",
    "4*(6.854*x^2 - y^2)*(6.854*y^2 - z^2)*(6.854*z^2 - x^2) - {}*(x^2 + y^2 + z^2 - 1)^2",
    "sin({}*x) + cos(y)*z - x^2",
    "sin(a*x) + cos(y)*z - {}*x^2",
)
PARTS = ("parse", "build", "launch", "kernel", "total")
HEADER = ("parse ms", "build ms", "first launch ms", "kernel ms", "together ms", "longest")


def measured(draw: Callable[..., irt.Frame], new: Callable[[], object], times: int) -> tuple[str, list[float]]:
    """The method that ran, and milliseconds: medians of the parts, and the longest together."""
    stats = [draw(new()).stats for _ in range(times)]
    medians = [1e3 * statistics.median(s.seconds[part] for s in stats) for part in PARTS]
    return stats[0].method, [*medians, 1e3 * max(s.seconds["total"] for s in stats)]


def formulas() -> list[tuple[str, ...]]:
    """Five formulas that differ in a number, by contraction and by "auto"; a is a parameter."""
    lines = []
    for text in FORMULAS:
        for method, precision in (("contract", "single"), ("contract", "auto"), ("auto", "auto")):
            ran, ms = measured(
                partial(
                    irt.render, size=(640, 480), method=method, precision=precision, params={"a": 0.7} if "a*" in text else {}
                ),
                lambda text=text: text.format(random.uniform(0.2, 0.9)),
                5,
            )  # fmt: skip
            lines.append((text, ran, precision, *(f"{v:.0f}" for v in ms)))
    return lines


def named() -> list[tuple[str, ...]]:
    """Every named surface by "auto", a little off its place; the slowest first."""
    found = []
    for surface in irt.surfaces.values():
        ran, ms = measured(
            partial(irt.render, size=(640, 480), params=surface.params, bounds=surface.bounds, camera=surface.camera),
            lambda expr=surface.expr: expr + random.uniform(1e-6, 1e-5),
            3,
        )
        found.append((surface.name, ran, ms))
    found.sort(key=lambda row: -row[2][4])
    return [(name, ran, *(f"{v:.0f}" for v in ms)) for name, ran, ms in found]


def main() -> None:
    """Prints the table: medians, 640 x 480."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--named", action="store_true", help="the 64 named surfaces instead of five formulas")
    options = parser.parse_args()
    irt.render("x", size=(8, 8))
    if options.named:
        irt.render(f"sin(x) + {random.uniform(0.2, 0.9)}", size=(8, 8))
        print(table(("surface", "method", *HEADER), named()))
    else:
        print(table(("formula", "method", "precision", *HEADER), formulas()))


if __name__ == "__main__":
    main()
