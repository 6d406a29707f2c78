"""The first picture of a new formula in a process that has drawn before: parse, build, first launch and frame apart.

python benchmarks/first_picture.py
"""

from __future__ import annotations

import random
import statistics

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


def main() -> None:
    """Prints the table: medians of five formulas that differ in a number, 640 x 480, by contraction and by "auto"; a is a parameter."""
    irt.render("x", size=(8, 8))
    lines = []
    parts = ("parse", "build", "launch", "kernel", "total")
    for text in FORMULAS:
        for method, precision in (("contract", "single"), ("contract", "auto"), ("auto", "auto")):
            stats = [
                irt.render(
                    text.format(random.uniform(0.2, 0.9)),
                    size=(640, 480),
                    method=method,
                    precision=precision,
                    params={"a": 0.7} if "a*" in text else {},
                ).stats
                for _ in range(5)
            ]
            medians = (f"{1e3 * statistics.median(s.seconds[p] for s in stats):.0f}" for p in parts)
            lines.append(
                (text, stats[0].method, precision, *medians, f"{1e3 * max(s.seconds['total'] for s in stats):.0f}")
            )
    print(
        table(
            (
                "formula",
                "method",
                "precision",
                "parse ms",
                "build ms",
                "first launch ms",
                "kernel ms",
                "together ms",
                "longest",
            ),
            lines,
        )
    )


if __name__ == "__main__":
    main()
