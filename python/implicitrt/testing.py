"""For users' own pytest: reference frames by Mitsuba 3, and comparisons that say what differs.

Mitsuba (`pip install "mitsuba>=3.6,<3.10"`) is imported only when `mitsuba_frame` is called.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt.camera import Camera
from implicitrt.errors import ArgumentError
from implicitrt.frame import Frame, Status

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["ReferenceFrame", "assert_matches", "mitsuba_frame"]


@dataclass(frozen=True)
class ReferenceFrame:
    """What another renderer found: depth (H, W), +inf for misses; normal (H, W, 3), towards the viewer."""

    depth: npt.NDArray[np.float64]
    normal: npt.NDArray[np.float64]
    camera: Camera

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """(H, W) bool."""
        return np.isfinite(self.depth)


def mitsuba_frame(shapes: Mapping[str, Any], camera: Camera, size: tuple[int, int]) -> ReferenceFrame:
    """Depth, normals and mask of Mitsuba's shapes, seen by one of our cameras.

    Every ray is ours and goes through Mitsuba's `ray_intersect`, in the variant `scalar_rgb`: it is
    deterministic, needs no LLVM, and agrees with closed forms to a few 1e-5 (float32).

    Args:
        shapes: Mitsuba dictionaries by name, such as {"ball": {"type": "sphere", "radius": 1}}. A
            `sdfgrid` must be cubic, which Mitsuba needs but does not check.
        camera: perspective or orthographic.    size: (width, height).

    Raises:
        ArgumentError: Mitsuba is missing or runs another variant, or a grid is not cubic.
    """
    try:
        import mitsuba as mi
    except ImportError:
        raise ArgumentError('mitsuba_frame needs Mitsuba: pip install "mitsuba>=3.6,<3.10"') from None
    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    elif mi.variant() != "scalar_rgb":
        raise ArgumentError(f"mitsuba_frame needs the variant scalar_rgb; {mi.variant()} is set already")
    for name, shape in shapes.items():
        _check_grid(name, shape)
    # Without the option a ray slips through a mesh's edge now and then.
    scene = mi.load_dict({"type": "scene", "embree_use_robust_intersections": True, **shapes})
    origins, directions = camera.rays(size)
    width, height = size
    depth = np.full((height, width), np.inf)
    normal = np.full((height, width, 3), np.nan)
    for row in range(height):
        for column in range(width):
            o, d = origins[row, column], directions[row, column]
            hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(*o.tolist()), mi.Vector3f(*d.tolist())))
            if hit.is_valid():
                depth[row, column] = np.linalg.norm(np.array(hit.p, dtype=np.float64) - o)
                n = np.array(hit.sh_frame.n, dtype=np.float64)
                normal[row, column] = -n if n @ d > 0 else n
    return ReferenceFrame(depth, normal, camera)


def _check_grid(name: str, shape: Any) -> None:
    if not isinstance(shape, Mapping) or shape.get("type") != "sdfgrid" or "grid" not in shape:
        return
    sides = tuple(shape["grid"].shape)[:3]
    if len(set(sides)) != 1:
        raise ArgumentError(f"the sdfgrid '{name}' is {sides}; Mitsuba is silently wrong unless it is cubic")


def _band(mask: npt.NDArray[np.bool_], pixels: int) -> npt.NDArray[np.bool_]:
    """The pixels within `pixels` of a change of the mask."""
    band = np.zeros_like(mask)
    for axis in (0, 1):
        for step in range(1, min(pixels, mask.shape[axis] - 1) + 1):
            change = np.take(mask, range(step, mask.shape[axis]), axis) != np.take(
                mask, range(mask.shape[axis] - step), axis
            )
            low = [slice(None)] * 2
            high = [slice(None)] * 2
            low[axis], high[axis] = slice(0, mask.shape[axis] - step), slice(step, None)
            band[tuple(low)] |= change
            band[tuple(high)] |= change
    return band


def assert_matches(
    frame: Frame,
    reference: Frame | ReferenceFrame,
    depth: float = 1e-4,
    normal: float | None = 1e-3,
    silhouette: int = 1,
    allowed: int = 0,
    save: str | os.PathLike[str] | None = None,
) -> None:
    """Raises AssertionError unless two frames show the same surface.

    Args:
        frame, reference: what is tested, and what it should be.
        depth: largest difference of depth, in world units.
        normal: largest angle between normals, in radians; None compares none. A normal that only the frame lacks is off by pi.
        silhouette: pixels this near to a change of the reference's mask are not compared.
        allowed: how many pixels may differ.
        save: a folder for three pictures (frame, reference, difference) when it fails; default
            "out/mismatch".

    The error says how many pixels differ in mask, depth and normals, where the worst is, and by how
    much.
    """
    if not depth >= 0 or not (normal is None or normal >= 0):
        raise ArgumentError(f"depth and normal are the largest differences allowed, not {depth!r} and {normal!r}")
    if frame.depth.shape != reference.depth.shape:
        raise AssertionError(f"the frames have different sizes: {frame.depth.shape} and {reference.depth.shape}")
    compared = ~_band(reference.hit, silhouette)
    # What the frame could not decide agrees with nothing.
    mask = compared & ((frame.hit != reference.hit) | (frame.status == Status.UNRESOLVED))
    both = compared & frame.hit & reference.hit
    with np.errstate(invalid="ignore"):
        depth_error = np.where(both, np.abs(frame.depth.astype(np.float64) - reference.depth), 0.0)
    angle = np.zeros(frame.depth.shape)
    if normal is not None:
        a, b = frame.normal.astype(np.float64), np.asarray(reference.normal, dtype=np.float64)
        # The chord keeps digits that the cosine loses for small angles.
        chord = np.linalg.norm(a - b, axis=2)
        angle = np.where(both & np.isfinite(chord), 2 * np.arcsin(np.minimum(chord / 2, 1)), 0.0)
        angle[both & np.isnan(a).any(axis=2) & np.isfinite(b).all(axis=2)] = math.pi  # a normal that is missing
    wrong_depth = depth_error > depth
    wrong_normal = angle > (math.inf if normal is None else normal)
    wrong = mask | wrong_depth | wrong_normal
    if np.count_nonzero(wrong) <= allowed:
        return
    lines = [f"{np.count_nonzero(wrong)} of {compared.sum()} compared pixels differ ({allowed} may)"]
    for what, where, size, unit in (
        ("mask", mask, None, ""),
        ("depth", wrong_depth, depth_error, ""),
        ("normal", wrong_normal, angle, " rad"),
    ):
        if where.any():
            worst = np.argwhere(where)[0] if size is None else np.unravel_index(int(np.argmax(size)), size.shape)
            row, column = (int(i) for i in worst)
            by = "" if size is None else f", worst by {size[row, column]:.3g}{unit}"
            lines.append(f"  {what}: {np.count_nonzero(where)}{by} at row {row}, column {column}")
    folder = Path(save if save is not None else "out/mismatch")
    lines.append(f"  pictures: {_save(folder, frame, reference, wrong)}")
    raise AssertionError("\n".join(lines))


def _save(folder: Path, frame: Frame, reference: Frame | ReferenceFrame, wrong: npt.NDArray[np.bool_]) -> Path:
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    near = min((float(f.depth[f.hit].min()) for f in (frame, reference) if f.hit.any()), default=0.0)
    far = max((float(f.depth[f.hit].max()) for f in (frame, reference) if f.hit.any()), default=1.0)

    def grey(depth: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
        with np.errstate(invalid="ignore"):
            shade = 1 - 0.8 * (depth - near) / max(far - near, 1e-30)
        return np.where(np.isfinite(depth), 255 * np.clip(shade, 0, 1), 0).astype(np.uint8)

    Image.fromarray(grey(frame.depth)).save(folder / "frame.png")
    Image.fromarray(grey(reference.depth)).save(folder / "reference.png")
    Image.fromarray((255 * wrong).astype(np.uint8)).save(folder / "difference.png")
    return folder
