"""The tables of S3 (Singh and Narayanan) for closed forms, Mitchell's method and marching points, redrawn beside the printed numbers.

    python benchmarks/table_s3.py [SECTION ...] [--size 512]        writes docs/table_s3.md, or of it these sections only

Frames per second by kernel time at 512 x 512, with normals and shading, from the cameras of the named surfaces; the paper's are
not known. Marching methods take as many steps as the paper's did. The paper counts frames only; here each method also has the
share of its pixels that are wrong, by `irt.reference`: MISS where there is a root, HIT where there is none, another root than the first.
Mitchell's method rounds outward, as it does by default; an iteration encloses f and, where rays of the packet wait for it, the derivative.
"""

from __future__ import annotations

import argparse
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "atlas"))
from common import median_seconds, table
from outcomes import marks

import implicitrt as irt

SECTIONS = ("Closed forms", "Mitchell's method", "Marching points", "Adaptive marching points")
ROOT = Path(__file__).resolve().parent.parent
JUDGED = (64, 64)  # pixels that are compared with the reference

ANALYTIC = {"sphere": 5821, "cylinder": 4358, "cayley": 3750, "ding_dong": 3400, "steiner": 1400, "tooth": 1100, "torus": 1200}
# Iterations, and frames per second.
MITCHELL = {
    "dervish": (86, 60), "kiss": (65, 77), "peninsula": (60, 85), "cushion": (53, 170), "crosscap": (52, 195), "miter": (52, 186), "tooth": (50, 195),
    "cayley": (27, 580), "ding_dong": (18, 965),
}  # fmt: skip
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
number. Views are ours: the paper's are not known. Mitchell's method rounds outward here, the others do not; in one of its iterations f is
enclosed and, where rays of the packet wait for it, the derivative: how many a ray takes on average and at most, waiting included.

"""


def fps(name: str, method: Any, size: int, **options: Any) -> str:
    """Frames per second by kernel time."""

    def once() -> float:
        frame = irt.render(irt.surfaces[name], size=(size, size), method=method, precision="single", **{"rounding": "fast", **options})
        return float(frame.stats.seconds["kernel"])

    return f"{1 / median_seconds(once, 3):.0f}"


@cache
def truth(name: str) -> irt.Reference:
    """What a surface's pixels are."""
    return irt.reference(irt.surfaces[name], size=JUDGED, time_limit=60)


def wrong(name: str, method: Any, real: irt.Reference, **options: Any) -> str:
    """The share of pixels that the reference contradicts."""
    frame = irt.render(irt.surfaces[name], size=JUDGED, method=method, precision="single", outputs=(), **options)
    bad = marks(frame, real)
    return f"{float((bad['missed'] | bad['false'] | bad['elsewhere']).mean()):.2%}"


def analytic(size: int) -> str:
    """Closed forms."""
    rows = [(n, printed, fps(n, "analytic", size), wrong(n, "analytic", truth(n))) for n, printed in ANALYTIC.items()]
    return table(("surface", "printed fps", "fps", "wrong"), rows)


def mitchell(size: int) -> str:
    """Mitchell's method, in both algebras."""
    rows = []
    for n, printed in MITCHELL.items():
        cells: list[object] = [n, *printed]
        for method in (irt.Mitchell("ia"), irt.Mitchell("raa")):
            frame = irt.render(irt.surfaces[n], size=(size, size), method=method, precision="single", outputs=("pieces",))
            looked = frame.pieces[frame.pieces > 0]
            cells += [f"{looked.mean():.0f}, {looked.max()}", fps(n, method, size, rounding="outward"), wrong(n, method, truth(n))]
        rows.append(cells)
    return table(("surface", "printed iterations", "printed fps", "ia: iterations", "fps", "wrong", "raa: iterations", "fps", "wrong"), rows)


def marching(kind: str, rows: dict[str, tuple[int, int, int]], size: int) -> str:
    """Marching or adaptive marching points."""
    lines = []
    for n, (steps, *printed) in rows.items():
        cells: list[object] = [n, steps]
        for test, of_paper in zip(("sign", "taylor"), printed, strict=True):
            method = f"{kind}-{test}"
            cells += [of_paper, fps(n, method, size, steps=steps), wrong(n, method, truth(n), steps=steps)]
        lines.append(cells)
    return table(("surface", "steps", "sign: printed fps", "fps", "wrong", "Taylor: printed fps", "fps", "wrong"), lines)


def main() -> None:
    """Measures, prints and writes the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"default: all; {', '.join(SECTIONS)}")
    parser.add_argument("--size", type=int, default=512)
    options = parser.parse_args()
    if unknown := set(options.sections) - set(SECTIONS):
        parser.error(f"no section is called {', '.join(sorted(unknown))}")
    file, size = ROOT / "docs" / "table_s3.md", options.size
    measure = dict(zip(SECTIONS, (
        lambda: analytic(size), lambda: mitchell(size), lambda: marching("marching", MARCHING, size), lambda: marching("adaptive", ADAPTIVE, size),
    ), strict=True))  # fmt: skip
    kept = dict(re.findall(r"^## (.*)\n\n((?:\|.*\n)+)", file.read_text(encoding="utf-8"), re.MULTILINE)) if options.sections else {}
    for name in options.sections or SECTIONS:
        kept[name] = measure[name]()
        print(kept[name], flush=True)
    device = irt.devices()[0]
    text = TEXT.format(device=f"{device.name}, {device.driver}, packets of {device.width}", size=size, judged=f"{JUDGED[0]} x {JUDGED[1]}")
    file.write_text(text + "\n".join(f"## {name}\n\n{kept[name].rstrip()}\n" for name in SECTIONS if name in kept), encoding="utf-8")


if __name__ == "__main__":
    main()
