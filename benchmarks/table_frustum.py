"""S2's Tables 1 and 2 redone: residuals of the roots, and errors, insertions and times of each root finder, beside what the paper prints.

    python benchmarks/table_frustum.py [--size 128] [--method frustum-lr ...]

Residuals are |f| at the roots found, in parts of the largest |f| over a grid of the bounds (S2 divides by the largest coefficient of its
form, which is larger still). Errors are distances from the reference's roots in parts of the depth of the bounds, of all
pixels that both hit. Insertions count as S2's do: a cut of a Bezier piece is as many knots as the degree.
"""

from __future__ import annotations

import argparse
import statistics

import numpy as np
from common import table

import implicitrt as irt

# Table 1: mean and max. Table 2, for LR, LR-Mult, MR, MR-Mult: mean, max, insertions, ms (on a GPU of 2008).
PRINTED: dict[str, tuple[tuple[float, float], tuple[tuple[float, float, float, float], ...]]] = {
    "cayley": (
        (1.2e-07, 1.5e-06),
        (
            (9.7e-08, 0.0002, 11.2, 5.1),
            (8.8e-08, 0.00012, 11.1, 5.1),
            (5.2e-08, 0.00015, 4.8, 5.3),
            (6.3e-08, 3.4e-05, 4.7, 5.4),
        ),
    ),
    "klebsch": (
        (2.3e-07, 4.7e-06),
        (
            (1.1e-07, 0.00027, 11.7, 5.4),
            (5.3e-06, 0.15, 12.2, 5.7),
            (6.6e-08, 0.00018, 5.1, 5.3),
            (5.5e-07, 0.062, 5.3, 6),
        ),
    ),
    "tangle": (
        (2.3e-07, 4.7e-06),
        (
            (2.5e-07, 0.00023, 21.8, 9.4),
            (0.00015, 0.51, 21.5, 10.7),
            (1.3e-07, 0.00012, 9.7, 12.6),
            (5.9e-05, 0.49, 9.4, 14.7),
        ),
    ),
    "kiss": (
        (2.7e-07, 1.2e-05),
        ((2.7e-06, 0.34, 21.2, 10), (2.7e-06, 0.34, 19.9, 8.7), (1.3e-06, 0.33, 9.7, 15.4), (1.7e-05, 0.48, 9, 14.5)),
    ),
    "klein_bottle": (
        (2.4e-06, 1.9e-05),
        (
            (2.1e-07, 0.00018, 32.4, 16),
            (3.7e-05, 0.23, 29.8, 14.3),
            (9.6e-08, 4.7e-05, 14.5, 22.7),
            (1.6e-05, 0.24, 12.6, 23.8),
        ),
    ),
    "heart": (
        (4.3e-09, 5.6e-08),
        (
            (1.6e-05, 0.07, 34.6, 17.6),
            (0.00011, 0.036, 33.8, 16.2),
            (6.3e-06, 0.029, 15.6, 26.6),
            (5.5e-05, 0.029, 14.4, 28.2),
        ),
    ),
    "linked_tori": (
        (3.4e-08, 2.9e-07),
        (
            (3.7e-07, 0.00014, 53.7, 29),
            (2.2e-05, 0.32, 51.6, 28.1),
            (2e-07, 0.00012, 23.1, 48.7),
            (1.8e-05, 0.3, 21.1, 51.4),
        ),
    ),
    "barth_decic": (
        (3.5e-09, 7.3e-07),
        (
            (7.8e-05, 0.73, 69.5, 55.5),
            (0.0029, 0.85, 62.9, 49.1),
            (2.2e-05, 0.73, 35.6, 124.2),
            (0.0023, 0.87, 31.3, 139.5),
        ),
    ),
    "supersphere_16": (
        (7.2e-09, 2.9e-07),
        (
            (1.5e-05, 0.0036, 103.5, 77),
            (1e-05, 0.0054, 98.9, 79),
            (9.9e-06, 0.0036, 51.9, 185.6),
            (9.9e-06, 0.0036, 48.7, 231.4),
        ),
    ),
}
FINDERS = (
    "frustum-lr",
    "frustum-lr-mult",
    "frustum-mr",
    "frustum-mr-mult",
    "frustum-clip",
    "frustum-midpoint",
    "frustum-newton",
)
EPS = 1e-5  # of the depth of the bounds


def residuals(surface: irt.surfaces.NamedSurface, frame: irt.Frame) -> tuple[float, float]:
    """The mean and the largest |f| at the roots of a frame, in parts of the largest over the bounds."""
    p = frame.points[frame.hit].astype(float)
    values = np.abs(surface.expr.evaluate(p[:, 0], p[:, 1], p[:, 2], **surface.params))
    grid = [np.linspace(lo, hi, 17) for lo, hi in zip(frame.bounds.lower, frame.bounds.upper, strict=True)]
    largest = np.abs(surface.expr.evaluate(*np.meshgrid(*grid), **surface.params)).max()
    return float(values.mean() / largest), float(values.max() / largest)


def main() -> None:
    """Prints both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--method", nargs="*", default=FINDERS)
    args = parser.parse_args()
    first, second = [], []
    for name, (global_error, rows) in PRINTED.items():
        surface = irt.surfaces[name]
        depth = 2 * surface.bounds.radius
        call = {"size": (args.size, args.size), "eps": EPS * depth}
        truth = irt.reference(surface, size=call["size"])
        degree = surface.expr.degree()
        for method in args.method:
            frame = irt.render(surface, method=method, outputs=("pieces",), **call)
            bare = [irt.render(surface, method=method, outputs=(), **call).stats for _ in range(4)][1:]
            both = frame.hit & truth.hit
            errors = np.abs(frame.depth[both] - truth.depth[both]) / depth
            cuts = frame.pieces[frame.hit].mean()
            insertions = (
                f"{cuts * (1 if '-mr' in method else degree):.1f}"
                if method != "frustum-newton"
                else f"({cuts:.1f} steps)"
            )
            printed = dict(zip(FINDERS, rows, strict=False)).get(method)
            second.append((
                name, method, f"{errors.mean():.1e}", f"{errors.max():.1e}", insertions,
                f"{1e3 * statistics.median(s.seconds['kernel'] for s in bare):.1f}",
                " ".join(f"{v:g}" for v in printed) if printed else "", frame.stats.escalated,
                int((frame.hit != truth.hit).sum()),
            ))  # fmt: skip
            if method == "frustum-mr":
                mean, most = residuals(surface, frame)
                first.append((name, f"{mean:.1e}", f"{most:.1e}", " ".join(f"{v:g}" for v in global_error)))
    print(table(("surface", "mean", "max", "S2: mean, max"), first), "\n")
    head = (
        "surface",
        "method",
        "mean",
        "max",
        "insertions",
        "kernel ms",
        "S2: mean, max, insertions, ms",
        "escalated",
        "masks differ",
    )
    print(table(head, second))


if __name__ == "__main__":
    main()
