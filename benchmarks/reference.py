"""What irt.reference takes for each named surface at 128 x 128, and which arithmetic decided.

python benchmarks/reference.py [NAME ...]
"""

from __future__ import annotations

import sys

from common import table

import implicitrt as irt
from implicitrt import Status

PRECISIONS = ("double", "fixed", "mpfr", "exact")


def main(names: list[str]) -> None:
    """Prints the table."""
    rows: list[list[object]] = []
    for name in names:
        found = irt.reference(irt.surfaces[name], size=(128, 128))
        counts = [int((found.kind == s).sum()) for s in Status]
        rows.append([name, f"{found.seconds:.2f}", *counts, *(int((found.precision == p).sum()) for p in PRECISIONS)])
    print(table(["surface", "seconds", *(s.name for s in Status), *PRECISIONS], rows))


if __name__ == "__main__":
    main(sys.argv[1:] or list(irt.surfaces))
