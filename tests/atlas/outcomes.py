"""What a method makes of a hard case, measured against the reference; and the file of what is expected.

    python tests/atlas/outcomes.py [CASE ...] [--method NAME ...]     measures, and writes expected.json
    python tests/atlas/outcomes.py --honest DEVICE [CASE ...]         looks for statuses that lie on another device

Measured in single precision, where methods fail first, on one driver and width (PINNED): elsewhere roundings differ, and only
the honesty of statuses is tested.
"""

from __future__ import annotations

import argparse
import functools
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

import implicitrt as irt
from implicitrt import Status

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import CASES, Case

PINNED = ("pocl (system)", 16)
SIZE = (40, 40)
FILE = Path(__file__).resolve().parent / "expected.json"
# Of the pixels: what other versions of the pinned driver may change.
TOLERANCE = 0.005
# Up to this share of its pixels a picture still counts as right.
RIGHT = 0.01

# The rates, and the word for a picture in which one of them is the largest.
WORDS = {
    "missed": "misses",  # MISS where there is a zero
    "false": "false hits",  # HIT where there is none
    "elsewhere": "speckles",  # another zero than the first, or a place without one
    "open": "unresolved",  # TOUCH or UNRESOLVED, except where f does only touch zero
}


@functools.cache
def truth(name: str) -> irt.Reference:
    """The reference's picture of a case."""
    case = CASES[name]
    return irt.reference(case.surface, size=SIZE, time_limit=60, **case.keywords)


def draw(case: Case, method: str, device: str | None = None) -> irt.Frame | None:
    """The method's picture; None where it refuses the formula."""
    try:
        return irt.render(case.surface, size=SIZE, method=method, precision="single", device=device, outputs=(), **case.keywords)
    except irt.MethodError:
        return None


def marks(frame: irt.Frame, real: irt.Reference) -> dict[str, np.ndarray[Any, Any]]:
    """Where a picture is wrong or open: a mask of pixels for each of WORDS."""
    # How far apart depths may be: eps, and rounding of a depth in single precision.
    eps = frame.bounds.default_eps
    hit = frame.status == Status.HIT
    with np.errstate(invalid="ignore"):
        far = np.abs(frame.depth - real.depth) > np.fmax(2 * eps, frame.uncertainty) + 1e-6 * np.abs(real.depth)
    touching = real.kind == Status.TOUCH
    return {
        "missed": real.hit & (frame.status == Status.MISS),
        "false": (real.kind == Status.MISS) & hit,
        "elsewhere": real.hit & hit & far,
        "open": (frame.status == Status.UNRESOLVED) | ((frame.status == Status.TOUCH) & ~(touching & ~far)),
    }


def rates(frame: irt.Frame | None, real: irt.Reference) -> dict[str, float] | None:
    """The shares of WORDS; None for a picture that was refused."""
    return None if frame is None else {k: round(float(m.mean()), 4) for k, m in marks(frame, real).items()}


def outcome(found: dict[str, float] | None) -> str:
    """One word for a picture."""
    if found is None:
        return "refused"
    worst = max(found, key=lambda k: found[k])
    return WORDS[worst] if found[worst] > RIGHT else "right"


def lies(name: str, method: str, device: str) -> str:
    """What a method that proves its statuses gets wrong on a device; "" where nothing lies."""
    frame = draw(CASES[name], method, device)
    found = rates(frame, truth(name)) or {}
    wrong = {k: found[k] for k in ("missed", "false", "elsewhere") if found.get(k)}
    return f"{name}, {method} on {device}: {wrong}" if wrong else ""


def proven_methods() -> list[str]:
    """The methods whose statuses are proven."""
    return [m for m in names() if irt.methods()[m].guarantee == "inclusion"]


def expected() -> dict[str, dict[str, dict[str, float] | None]]:
    """Rates by case and method."""
    known: dict[str, dict[str, dict[str, float] | None]] = json.loads(FILE.read_text(encoding="utf-8"))
    return known


def names() -> list[str]:
    """The methods of the atlas: all but auto, which is one of the others."""
    return [m for m in irt.methods() if m != "auto"]


def main() -> None:
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", help="default: all")
    parser.add_argument("--method", action="append", help="default: all")
    parser.add_argument("--honest", metavar="DEVICE")
    options = parser.parse_args()
    if options.honest:
        found = [lies(name, m, options.honest) for name in options.cases or CASES for m in options.method or proven_methods()]
        sys.exit("\n".join(filter(None, found)) or None)
    table = expected() if FILE.exists() else {}
    for name in options.cases or CASES:
        row = table.setdefault(name, {})
        for method in options.method or names():
            before, now = row.get(method), rates(draw(CASES[name], method, PINNED[0]), truth(name))
            if method not in row or before != now:
                print(f"{name}, {method}: {outcome(now)} {now}" + (f"; was {outcome(before)} {before}" if method in row else ""))
            row[method] = now
        table[name] = {m: row[m] for m in names() if m in row}
    table = {name: table[name] for name in CASES if name in table}
    lines = [f'"{name}": {{\n' + ",\n".join(f'  "{m}": {json.dumps(r)}' for m, r in row.items()) + "\n}" for name, row in table.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
