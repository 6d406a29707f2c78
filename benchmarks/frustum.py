"""The frustum form beside `surf` and beside the yardstick's hand-written frustum kernels, in one run.

    IMPLICITRT_TEST_DATA=... python benchmarks/frustum.py [surf] [yardstick] [coefficients] [--runs 5] [--method auto]

surf: the whole of `render()`, warm, at 512 x 512, against surf's wall time, eight orthographic views. Needs the
Debian package surf-alggeo-nox. yardstick: kernel time at 1024 x 1024, three views. Needs pyopencl. Ratios are of
medians over runs that alternate, so that other load on the machine hits both alike. coefficients: what a frame of degree 10 whose camera and
coefficients have moved spends on them, host and device together, and what it builds.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time

import numpy as np
from common import external, table, yardstick

import implicitrt as irt

FRAMES = 9  # whose median is a run's figure, as the yardstick's is
FORWARD, UP = (0.47943, -0.30092, 0.82438), (0, 0.93937, 0.34290)
# The yardstick's views: where the eye is, between which depths, and a cube that holds that part of the frustum.
VIEWS = {
    "barth_sextic": ((-3.57213, 2.64456, -6.66155), 5.4, 10.6, 16.0),
    "barth_decic": ((-2.80505, 2.16309, -5.34254), 4.32, 8.48, 16.0),
    "supersphere_16": ((-1.07912, 1.07977, -2.37478), 1.89, 3.71, 8.0),
}


def counts(stats: irt.Stats) -> str:
    """Statuses and escalated pixels in short."""
    n = stats.counts
    return f"{n['MISS']} {n['HIT']} {n['TOUCH']} {n['UNRESOLVED']}, {stats.escalated}"


def against_surf(runs: int, method: str) -> str:
    """The table of the eight views."""
    sys.path.insert(0, str(external("peers")))
    from surf_bench import surf_render

    views = json.loads(external("peers", "surf_views.json").read_text())
    calls = {}
    for v in views:
        expr, ball = irt.parse(v["polynomial"]), irt.Sphere((0, 0, 0), v["clip"])
        camera = irt.Camera(
            (0, 0, 2 * v["clip"]), target=(0, 0, 0), up=(0, 1, 0), projection="orthographic", height=v["window"]
        )
        calls[v["name"]] = lambda expr=expr, ball=ball, camera=camera: irt.render(
            expr, bounds=ball, camera=camera, size=(512, 512), method=method
        )
    times: dict[str, list[tuple[float, float, float]]] = {}
    frames, masks = {}, {}
    for run in range(runs + 1):
        empty = surf_render("x**2+y**2+z**2+1", 1.0, 512, 3.0, runs=1)["wall"]
        for v in views:
            surf = surf_render(v["polynomial"], v["clip"], 512, v["window"], runs=1)
            masks[v["name"]] = surf["mask"]
            ours = []
            for _ in range(3):
                start = time.perf_counter()
                frames[v["name"]] = calls[v["name"]]()
                ours.append(time.perf_counter() - start)
            if run:  # the first run warms everything up
                times.setdefault(v["name"], []).append((statistics.median(ours), surf["wall"], surf["wall"] - empty))
    rows = []
    for v in views:
        ours, wall, net = (1e3 * statistics.median(t) for t in zip(*times[v["name"]], strict=True))
        frame = frames[v["name"]]
        differ = 100 * float(np.mean(frame.hit != masks[v["name"]]))
        rows.append((
            v["name"], v["degree"], frame.stats.method, f"{ours:.1f}", f"{wall:.0f}", f"{net:.0f}", f"{wall / ours:.1f}", f"{net / ours:.1f}",
            f"{differ:.3f} %", counts(frame.stats),
        ))  # fmt: skip
    head = (
        "view",
        "degree",
        "method",
        "render() ms",
        "surf ms",
        "less empty",
        "ratio",
        "less empty",
        "masks differ",
        "statuses, escalated",
    )
    return table(head, rows)


def against_yardstick(runs: int, method: str) -> str:
    """The table of the three views."""
    width = irt.devices()[0].width
    times: dict[str, list[tuple[float, float, float]]] = {}
    frames = {}
    for run in range(runs + 1):
        rows = yardstick(1024, width)
        for name, (eye, near, far, reach) in VIEWS.items():
            depth = float(np.dot(FORWARD, eye))
            slab = [
                reach,
                irt.HalfSpace(FORWARD, depth + far),
                irt.HalfSpace([-c for c in FORWARD], -(depth + near)),
            ]
            camera = irt.Camera(eye, target=tuple(np.add(eye, FORWARD)), up=UP, fov=48.4555)
            found = []
            for _ in range(FRAMES):
                frames[name] = irt.render(
                    irt.surfaces[name].expr,
                    bounds=slab,
                    camera=camera,
                    size=(1024, 1024),
                    method=method,
                    eps=1e-3,
                    outputs=(),
                )
                seconds = frames[name].stats.seconds
                found.append((seconds["kernel"], seconds.get("prepare", 0)))
            if run:
                kernel, prepare = (statistics.median(t) for t in zip(*found, strict=True))
                times.setdefault(name, []).append((kernel, prepare, rows[f"frustum {name}"]))
    lines = []
    for name in VIEWS:
        kernel, prepare, theirs = (statistics.median(t) for t in zip(*times[name], strict=True))
        stats = frames[name].stats
        lines.append(
            (
                name,
                stats.method,
                f"{1e3 * kernel:.1f}",
                f"{1e3 * prepare:.1f}",
                f"{theirs:.1f}",
                f"{theirs / (1e3 * kernel):.2f}",
                counts(stats),
            )
        )
    return table(
        ("view", "method", "kernel ms", "coefficients ms", "yardstick ms", "ratio", "statuses, escalated"), lines
    )


def of_coefficients(runs: int, method: str) -> str:
    """The table of the Barth decic, as printed and multiplied out, every frame another polynomial from another place."""
    decic = irt.surfaces["barth_decic"]
    polynomials = {"barth_decic": decic.expr, "barth_decic, multiplied out": decic.expr.expand()}
    frames: dict[tuple[str, int], list[irt.Frame]] = {}
    for run in range(10 * runs + 3):
        for name, f in polynomials.items():
            for size in (512, 1024):
                angle = 0.05 * run
                camera = irt.Camera((5 * np.sin(angle), 2, 5 * np.cos(angle)))
                frame = irt.render(f + irt.Rational(run, 100000), camera=camera, bounds=decic.bounds, size=(size, size), method=method, outputs=())
                if run > 2:  # the first ones build
                    frames.setdefault((name, size), []).append(frame)
    rows = []
    for (name, size), found in frames.items():
        ms = [1e3 * f.stats.seconds.get("prepare", 0) for f in found]
        rows.append((name, f"{size} x {size}", found[0].stats.method, f"{statistics.median(ms):.1f}", f"{min(ms):.1f}",
                     sum(f.stats.builds for f in found), int(statistics.median(f.stats.escalated for f in found))))  # fmt: skip
    return table(("polynomial", "size", "method", "coefficients ms, median", "least", "builds", "escalated, median"), rows)


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("which", nargs="*", default=["surf", "yardstick"])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--method", default="auto")
    args = parser.parse_args()
    device = irt.devices()[0]
    print(
        f"{device.name}, {device.driver}, medians of {args.runs} alternating runs; statuses: MISS HIT TOUCH UNRESOLVED\n"
    )
    for which in args.which:
        print({"surf": against_surf, "yardstick": against_yardstick, "coefficients": of_coefficients}[which](args.runs, args.method), "\n")


if __name__ == "__main__":
    main()
