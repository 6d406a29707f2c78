"""The tables of S3 (Singh and Narayanan) for closed forms and marching points, redrawn beside the printed numbers.

    python benchmarks/table_s3.py [--size 512]        writes docs/table_s3.md

Frames per second by kernel time at 512 x 512, with normals and shading, from the cameras of the named surfaces; the paper's are
not known. Marching methods take as many steps as the paper's did. The paper counts frames only; here each method also has the
share of its pixels that are wrong, by `irt.reference`: MISS where there is a root, HIT where there is none, another root than the first.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "atlas"))
from common import median_seconds, table
from outcomes import marks

import implicitrt as irt

ROOT = Path(__file__).resolve().parent.parent
JUDGED = (64, 64)  # pixels that are compared with the reference

ANALYTIC = {"sphere": 5821, "cylinder": 4358, "cayley": 3750, "ding_dong": 3400, "steiner": 1400, "tooth": 1100, "torus": 1200}
# Steps, and frames per second by the sign test and by the Taylor test.
MARCHING = {
    "chmutov_18": (400, 85, 38), "chmutov_14": (400, 55, 48), "sarti_12": (300, 60, 53), "barth_decic": (300, 92, 105), "endrass_8": (300, 140, 179),
    "chmutov_8": (250, 185, 195), "klein_bottle": (400, 285, 290), "hunt": (400, 230, 225), "barth_sextic": (125, 300, 310), "heart": (120, 265, 260),
    "dervish": (300, 285, 275), "peninsula": (85, 370, 447), "torus": (50, 410, 430), "blobby": (250, 160, 305), "scherk": (250, 200, 315),
    "diamond": (250, 260, 306), "superquadric": (150, 105, 125),
}  # fmt: skip
ADAPTIVE = {
    "chmutov_18": (100, 98, 60), "chmutov_14": (100, 125, 95), "sarti_12": (100, 86, 75), "barth_decic": (100, 150, 115), "endrass_8": (96, 190, 208),
    "chmutov_8": (64, 215, 216), "klein_bottle": (48, 435, 385), "hunt": (84, 240, 325), "barth_sextic": (60, 325, 310), "heart": (48, 420, 320),
    "dervish": (45, 285, 280), "peninsula": (35, 512, 435), "torus": (24, 555, 525), "blobby": (50, 329, 300), "scherk": (100, 358, 322),
    "diamond": (100, 360, 330), "superquadric": (100, 185, 155),
}  # fmt: skip

TEXT = """# The tables of Singh and Narayanan, redrawn

Written by `python benchmarks/table_s3.py` on {device}. Frames per second by kernel time at {size} x {size} with normals and shading;
printed: an NVIDIA 8800 GTX. *Wrong* is the share of {judged} pixels that `irt.reference` contradicts, in our pictures; the paper has no such
number. Views are ours: the paper's are not known.

## Closed forms

{analytic}

## Marching points

{marching}

## Adaptive marching points

{adaptive}
"""


def fps(name: str, method: str, size: int, **options: Any) -> str:
    """Frames per second by kernel time."""

    def once() -> float:
        frame = irt.render(irt.surfaces[name], size=(size, size), method=method, precision="single", rounding="fast", **options)
        return float(frame.stats.seconds["kernel"])

    return f"{1 / median_seconds(once, 3):.0f}"


def wrong(name: str, method: str, truth: irt.Reference, **options: Any) -> str:
    """The share of pixels that the reference contradicts."""
    frame = irt.render(irt.surfaces[name], size=JUDGED, method=method, precision="single", outputs=(), **options)
    bad = marks(frame, truth)
    return f"{float((bad['missed'] | bad['false'] | bad['elsewhere']).mean()):.2%}"


def main() -> None:
    """Measures, prints and writes the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=512)
    size = parser.parse_args().size
    truths = {n: irt.reference(irt.surfaces[n], size=JUDGED, time_limit=60) for n in {**ANALYTIC, **MARCHING}}
    analytic = [(n, printed, fps(n, "analytic", size), wrong(n, "analytic", truths[n])) for n, printed in ANALYTIC.items()]
    print(table(("surface", "printed fps", "fps", "wrong"), analytic), flush=True)
    marched = []
    for kind, rows in (("marching", MARCHING), ("adaptive", ADAPTIVE)):
        lines = []
        for n, (steps, *printed) in rows.items():
            cells: list[object] = []
            for test, of_paper in zip(("sign", "taylor"), printed, strict=True):
                method = f"{kind}-{test}"
                cells += [of_paper, fps(n, method, size, steps=steps), wrong(n, method, truths[n], steps=steps)]
            lines.append((n, steps, *cells))
        head = ("surface", "steps", "sign: printed fps", "fps", "wrong", "Taylor: printed fps", "fps", "wrong")
        marched.append(table(head, lines))
        print(marched[-1], flush=True)
    device = irt.devices()[0]
    text = TEXT.format(
        device=f"{device.name}, {device.driver}, packets of {device.width}", size=size, judged=f"{JUDGED[0]} x {JUDGED[1]}",
        analytic=table(("surface", "printed fps", "fps", "wrong"), analytic), marching=marched[0], adaptive=marched[1],
    )  # fmt: skip
    (ROOT / "docs" / "table_s3.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
