"""S3's (Singh and Narayanan) table of closed forms, redrawn beside the printed numbers.

    python benchmarks/table_s3.py [--size 512]        writes docs/table_s3.md

Frames per second by kernel time at 512 x 512, with normals and shading, from the cameras of the named surfaces; the paper's are
not known. The paper counts frames only; here is also the share of pixels that are wrong, by `irt.reference`: MISS where there is a
root, HIT where there is none, another root than the first.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "atlas"))
from common import median_seconds, table
from outcomes import marks

import implicitrt as irt

ROOT = Path(__file__).resolve().parent.parent
JUDGED = (64, 64)  # pixels that are compared with the reference

ANALYTIC = {"sphere": 5821, "cylinder": 4358, "cayley": 3750, "ding_dong": 3400, "steiner": 1400, "tooth": 1100, "torus": 1200}
TEXT = """# Closed forms: a table of Singh and Narayanan, redrawn

Written by `python benchmarks/table_s3.py` on {device}. Frames per second by kernel time at {size} x {size} with normals and shading;
printed: an NVIDIA 8800 GTX. *Wrong* is the share of {judged} pixels that `irt.reference` contradicts, in our pictures; the paper has no such
number. Views are ours: the paper's are not known.

{analytic}
"""


def fps(name: str, method: str, size: int) -> str:
    """Frames per second by kernel time."""

    def once() -> float:
        frame = irt.render(irt.surfaces[name], size=(size, size), method=method, precision="single", rounding="fast")
        return float(frame.stats.seconds["kernel"])

    return f"{1 / median_seconds(once, 3):.0f}"


def wrong(name: str, method: str, truth: irt.Reference) -> str:
    """The share of pixels that the reference contradicts."""
    frame = irt.render(irt.surfaces[name], size=JUDGED, method=method, precision="single", outputs=())
    bad = marks(frame, truth)
    return f"{float((bad['missed'] | bad['false'] | bad['elsewhere']).mean()):.2%}"


def main() -> None:
    """Measures, prints and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=512)
    size = parser.parse_args().size
    truths = {n: irt.reference(irt.surfaces[n], size=JUDGED, time_limit=60) for n in ANALYTIC}
    rows = [(n, printed, fps(n, "analytic", size), wrong(n, "analytic", truths[n])) for n, printed in ANALYTIC.items()]
    device = irt.devices()[0]
    text = TEXT.format(
        device=f"{device.name}, {device.driver}, packets of {device.width}", size=size, judged=f"{JUDGED[0]} x {JUDGED[1]}",
        analytic=table(("surface", "printed fps", "fps", "wrong"), rows),
    )  # fmt: skip
    print(text)
    (ROOT / "docs" / "table_s3.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
