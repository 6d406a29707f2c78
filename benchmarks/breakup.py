"""Where S2 and S3 report that pictures break up: their ways in single precision beside ours.

    python benchmarks/breakup.py [--size 160] [--picture docs/frustum-breakup.png]

Columns: marching points with the sign test on the polynomial as printed, in single precision (S3); one frustum form over the whole view,
interpolated at Chebyshev points in double and used in single precision (S2 sections 3 and 4.1; its roots are looked for in 400 samples,
so that the form alone is judged); `frustum-newton`. Counted are pixels whose hit is not the reference's, and hits more than a hundredth of the
bounds away from its root.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from common import table

import implicitrt as irt

SAMPLES = 400
# The heart in a large frustum: bounds thirty times as large, around the eye.
VIEWS = (("heart", 40.0, "heart, large frustum"), ("barth_decic", None, "Barth decic"), ("chmutov_20", None, "Chmutov 20"), ("chmutov_30", None, "Chmutov 30"))

Depths = npt.NDArray[np.floating]


def bernstein(degree: int, u: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """B_i(u): (len(u), degree + 1)."""
    rows = np.ones((len(u), 1))
    for _ in range(degree):
        rows = np.pad((1 - u)[:, None] * rows, ((0, 0), (0, 1))) + np.pad(u[:, None] * rows, ((0, 0), (1, 0)))
    return rows


def one_form(f: irt.Expr, box: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]], camera: irt.Camera, size: int) -> Depths:
    """Depths by one frustum form in single precision; inf for a miss."""
    degree = f.degree()
    assert degree is not None
    right, up, forward = camera.basis()
    eye, half = np.array(camera.origin), np.tan(np.radians(camera.fov) / 2)
    corners = np.array([[box[i][0], box[j][1], box[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    reach = (corners - eye) @ forward
    near, far = max(reach.min(), 0.01 * reach.max()), reach.max()

    def points(u: Depths, v: Depths, w: Depths) -> Depths:
        across = (2 * u[:, None, None, None] - 1) * half * right + (1 - 2 * v[None, :, None, None]) * half * up
        return eye + (near + w[None, None, :, None] * (far - near)) * (forward + across)

    nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    inverse = np.linalg.inv(bernstein(degree, nodes))
    p = points(nodes, nodes, nodes)
    form = np.einsum("ip,jq,kr,pqr->ijk", inverse, inverse, inverse, f.evaluate(p[..., 0], p[..., 1], p[..., 2]), optimize=True)
    single = (form / np.abs(form).max()).astype(np.float32)
    centres, w = (np.arange(size) + 0.5) / size, np.linspace(0, 1, SAMPLES)
    basis = bernstein(degree, centres).astype(np.float32)
    along = np.einsum("pi,qj,ijk->qpk", basis, basis, single, optimize=True)  # rows first
    values = along @ bernstein(degree, w).astype(np.float32).T
    places = np.swapaxes(points(centres, centres, w), 0, 1)
    inside = ((places >= box[0]) & (places <= box[1])).all(-1)
    changes = (values[..., 1:] * values[..., :-1] <= 0) & inside[..., 1:] & inside[..., :-1]
    first = changes.argmax(-1)
    a, b = (np.take_along_axis(values, (first + k)[..., None], -1)[..., 0].astype(float) for k in (0, 1))
    share = (first + a / np.where(a == b, 1, a - b)) / (SAMPLES - 1)
    length = np.linalg.norm(places[:, :, 1] - places[:, :, 0], axis=-1) * (SAMPLES - 1) / (far - near)
    return np.where(changes.any(-1), (near + share * (far - near)) * length, np.inf)


def shaded(f: irt.Expr, camera: irt.Camera, depth: Depths) -> npt.NDArray[np.float64]:
    """Lit from the eye, by the gradient of f itself."""
    origins, directions = camera.rays((depth.shape[1], depth.shape[0]))
    hit = np.isfinite(depth)
    p = origins + np.where(hit, depth, 0)[..., None] * directions
    gradient = np.stack([np.broadcast_to(f.diff(v).evaluate(p[..., 0], p[..., 1], p[..., 2]), depth.shape) for v in (irt.x, irt.y, irt.z)], -1)
    facing = np.abs((gradient * directions).sum(-1)) / np.maximum(np.linalg.norm(gradient, axis=-1), 1e-300)
    return np.where(hit[..., None], (0.15 + 0.85 * facing)[..., None] * (0.36, 0.61, 0.84), 1)


def main() -> None:
    """Prints the table, and draws the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=160)
    parser.add_argument("--picture")
    args = parser.parse_args()
    rows, pictures = [], []
    for name, reach, title in VIEWS:
        surface = irt.surfaces[name]
        f, camera = surface.expr, surface.camera
        call = {"bounds": reach or surface.bounds, "camera": camera, "size": (args.size, args.size)}
        truth = irt.reference(f, **call)
        sampled = irt.render(f, method="marching-sign", precision="single", **call)
        ours = irt.render(f, method="frustum-newton", **call)
        box = tuple(np.array(b, float) for b in (sampled.bounds.lower, sampled.bounds.upper))
        scale = float((np.array(surface.bounds.upper) - surface.bounds.lower).max())
        ways: dict[str, Callable[[], Depths]] = {
            "marching points, single": lambda frame=sampled: frame.depth,
            "one frustum form, single": lambda f=f, box=box, camera=camera: one_form(f, box, camera, args.size),
            "frustum-newton": lambda frame=ours: frame.depth,
        }
        for way, find in ways.items():
            depth = find()
            both = np.isfinite(depth) & truth.hit
            off = np.abs(depth[both] - truth.depth[both]) > 0.01 * scale
            rows.append((title, way, int((np.isfinite(depth) != truth.hit).sum()), int(off.sum())))
            pictures.append((f"{title}: {way}", shaded(f, camera, depth)))
    print(table(("surface", "way", "hits that are none, or missed", "hits elsewhere"), rows))
    if args.picture:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7.5, 10.2), layout="constrained")
        for axes, (title, picture) in zip(figure.subplots(len(VIEWS), 3).flat, pictures, strict=True):
            axes.imshow(np.clip(picture, 0, 1), interpolation="nearest")
            axes.set_title(title, fontsize=7)
            axes.set_axis_off()
        figure.savefig(args.picture, dpi=100)


if __name__ == "__main__":
    main()
