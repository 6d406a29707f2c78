"""What beams bring to `contract` in dense and in sparse views: milliseconds with and without them, and what is left for the rays.

    python benchmarks/beams.py [--size 512]
"""

from __future__ import annotations

import argparse

import numpy as np
from common import CAMERA, median_seconds, table

import implicitrt as irt

NEAR = irt.Camera(origin=(0.4, 0.3, 1.6), target=(0, 0, 0), fov=40)
VIEWS = [
    ("barth_sextic", CAMERA, 3.0), ("barth_sextic", NEAR, 2.0), ("gyroid", None, None), ("sphere", None, None), ("sin_blob", None, None),
    ("icos_csg", None, None), ("blobby_molecule", None, None), ("menger_3", None, None),
]  # fmt: skip


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=512)
    size = parser.parse_args().size
    rows = []
    for name, camera, bounds in VIEWS:
        surface = irt.surfaces[name]
        camera, bounds = camera or surface.camera, bounds or surface.bounds
        keywords = {"bounds": bounds, "precision": "single", "eps": 1e-4}
        frame = irt.render(surface, camera=camera, size=(size, size), method=irt.Contraction(beams=True), outputs=("pieces",), **keywords)

        def seconds(beams: bool, surface=surface, camera=camera, keywords=keywords) -> float:
            method = irt.Contraction(beams=beams)
            return irt.render(surface, camera=camera, size=(size, size), method=method, outputs=("normal",), **keywords).stats.seconds["kernel"]

        ms, without = (1e3 * median_seconds(lambda on=on: seconds(on)) for on in (True, False))
        pieces = frame.pieces.reshape(size // 4, 4, size // 4, 4).max(axis=(1, 3))
        rows.append(
            (name, f"{frame.hit.mean():.2f}", f"{np.mean(pieces > 0):.2f}", f"{frame.pieces.mean():.2f}", f"{without:.1f}", f"{ms:.1f}", f"{without / ms:.2f}")
        )  # fmt: skip
        print(rows[-1], flush=True)
    print(table(("surface", "hit", "packets left", "pieces a ray", "ms without beams", "ms", "times"), rows))


if __name__ == "__main__":
    main()
