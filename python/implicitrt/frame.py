"""Results: pictures (`Frame`), batches of rays (`Hits`), and what made them (`Stats`)."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt.errors import ArgumentError
from implicitrt.files import write_atomically

if TYPE_CHECKING:
    import numpy.typing as npt

    from implicitrt.bounds import Bounds
    from implicitrt.camera import Camera
    from implicitrt.expression import Expr

__all__ = ["Frame", "Hits", "Stats", "Status"]


class Status(IntEnum):
    """What is known of a pixel or ray.

    With a method whose guarantee is "inclusion" and rounding "outward": MISS is proven; HIT has a
    bracket with a proven sign change; TOUCH could neither be excluded nor proven; UNRESOLVED means
    that a budget was spent, or that only a pole was found.
    """

    MISS = 0
    HIT = 1
    TOUCH = 2
    UNRESOLVED = 3


@dataclass(frozen=True)
class Stats:
    """What ran, how long it took (seconds), and what came out."""

    method: str
    reason: str
    guarantee: str
    proven: bool
    algebra: str
    device: str
    driver: str
    engine: str
    precision: str
    width: int
    rounding: str
    builds: int
    seconds: Mapping[str, float]  # parse, build, launch, kernel, total; prepare (coefficients), driver (its first use)
    counts: Mapping[str, int] = field(default_factory=dict)  # by status
    wide: int = 0  # HITs whose bracket is wider than eps
    escalated: int = 0  # pixels redone in double, by the reference, or both
    by_reference: int = 0  # of these, those that the reference was asked about


class Frame:
    """A rendered picture: what the kernels found, pixel by pixel, and the colours.

    Attributes:
        rgb: (H, W, 3) uint8, sRGB.          rgba: the same with alpha.
        depth: (H, W), distance along the unit ray; +inf for MISS, start of the open piece for
            UNRESOLVED. float32; float64 where precision is "double" or "auto" had to use it.
        uncertainty: (H, W), half the width of the proven bracket around depth; nan elsewhere.
        normal: (H, W, 3) float32, unit, towards the viewer; nan where there is no hit or gradient.
        status: (H, W) uint8, see `Status`.   hit: (H, W) bool, HIT or TOUCH.
        points: (H, W, 3), nan where there is no hit.
        formula, camera, bounds, params: what was drawn.   stats: `Stats`.
    """

    def __init__(
        self, result: Mapping[str, Any], formula: Expr, camera: Camera, bounds: Bounds, params: Mapping[str, float], stats: Stats
    ) -> None:
        self._depth: npt.NDArray[Any] = result["depth"]
        self._uncertainty: npt.NDArray[Any] = result["uncertainty"]
        self._finer: tuple[npt.NDArray[np.int64], npt.NDArray[np.float64], npt.NDArray[np.float64]] | None = result.get("finer")
        self.status: npt.NDArray[np.uint8] = result["status"]
        self._normal: npt.NDArray[np.float32] | None = result.get("normal")
        self._rgba: npt.NDArray[np.uint8] | None = result.get("rgba")
        self._pieces: npt.NDArray[np.uint32] | None = result.get("pieces")
        self.formula = formula
        self.camera = camera
        self.bounds = bounds
        self.params = dict(params)
        self.stats = stats

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.status.shape[1], self.status.shape[0]

    @property
    def depth(self) -> npt.NDArray[Any]:
        """(H, W): distance along the unit ray; float32 or float64."""
        self._widen()
        return self._depth

    @property
    def uncertainty(self) -> npt.NDArray[Any]:
        """(H, W): half the width of the proven bracket around depth; float32 or float64."""
        self._widen()
        return self._uncertainty

    def _widen(self) -> None:
        """Both arrays in double, where some pixels are known in double: not before somebody asks, as it takes as long as finding these."""
        if self._finer is None:
            return
        where, depth, uncertainty = self._finer
        wide = [array.astype(np.float64, order="C") for array in (self._depth, self._uncertainty)]
        for array, some in zip(wide, (depth, uncertainty), strict=True):
            array.reshape(-1)[where] = some
        self._depth, self._uncertainty = wide
        self._finer = None

    @property
    def normal(self) -> npt.NDArray[np.float32]:
        """(H, W, 3) float32, unit, towards the viewer."""
        return self._asked(self._normal, "normal")

    @property
    def pieces(self) -> npt.NDArray[np.uint32]:
        """(H, W) uint32: how many pieces of its ray the root finder looked at; asked for with outputs."""
        return self._asked(self._pieces, "pieces")

    @property
    def rgba(self) -> npt.NDArray[np.uint8]:
        """(H, W, 4) uint8, sRGB and alpha."""
        return self._asked(self._rgba, "rgb")

    @property
    def rgb(self) -> npt.NDArray[np.uint8]:
        """(H, W, 3) uint8, sRGB."""
        return self._asked(self._rgba, "rgb")[..., :3]

    @staticmethod
    def _asked(array: Any, name: str) -> Any:
        if array is None:
            raise ArgumentError(f'this frame was rendered without "{name}"; ask for it in outputs')
        return array

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """(H, W) bool: HIT or TOUCH."""
        return (self.status == Status.HIT) | (self.status == Status.TOUCH)

    @property
    def points(self) -> npt.NDArray[Any]:
        """(H, W, 3): where the rays hit; nan where they do not."""
        origins, directions = self.camera.rays(self.size)
        depth = np.where(self.hit, self.depth, np.nan).astype(np.float64)
        return (origins + depth[..., None] * directions).astype(self.depth.dtype)

    def _png(self) -> bytes:
        from PIL import Image

        opaque = bool((self.rgba[..., 3] == 255).all())
        pixels = np.ascontiguousarray(self.rgb if opaque else self.rgba)
        out = io.BytesIO()
        Image.fromarray(pixels).save(out, "PNG")
        return out.getvalue()

    def _repr_png_(self) -> bytes | None:
        return None if self._rgba is None else self._png()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        rgb = self.rgb
        if dtype is not None and np.dtype(dtype) != rgb.dtype:
            if copy is False:
                raise ValueError("another dtype needs a copy")
            return rgb.astype(dtype)
        return rgb.copy() if copy else rgb

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture (`.png`) or everything (`.npz`); all of the file or nothing.

        In `.npz` the arrays have their names here, and `meta` is text of Python literals (`ast.literal_eval`): formula, camera,
        bounds, params and stats.

        Raises:
            ArgumentError: the name ends otherwise.   OSError: the file cannot be written.
        """
        file = Path(path)
        suffix = file.suffix.lower()
        if suffix == ".png":
            write_atomically(file, self._png())
        elif suffix == ".npz":
            out = io.BytesIO()
            arrays = {"depth": self.depth, "uncertainty": self.uncertainty, "status": self.status}
            if self._normal is not None:
                arrays["normal"] = self._normal
            if self._rgba is not None:
                arrays["rgba"] = self._rgba
            if self._pieces is not None:
                arrays["pieces"] = self._pieces
            np.savez_compressed(out, **arrays, meta=np.array(repr(self._meta())))  # type: ignore[arg-type]
            write_atomically(file, out.getvalue())
        else:
            raise ArgumentError(f"a frame is saved as .png or .npz, not as '{file.name}'")

    def _meta(self) -> dict[str, Any]:
        from dataclasses import asdict

        stats = {k: dict(v) if isinstance(v, Mapping) else v for k, v in vars(self.stats).items()}
        bounds = asdict(self.bounds) | {"clips": tuple(str(c.g) for c in self.bounds.clips)}
        return {"formula": str(self.formula), "camera": asdict(self.camera), "bounds": bounds, "params": self.params, "stats": stats}

    def __repr__(self) -> str:
        s = self.stats
        width, height = self.size
        shown = ", ".join(f"{n} {k}" for k, n in s.counts.items() if n)
        text = (
            f"<Frame {width} x {height}, {s.method} on {s.device} ({s.driver}), {s.precision}, "
            f"{1e3 * s.seconds['total']:.0f} ms: {shown}"
        )
        if s.counts.get("UNRESOLVED"):
            text += (
                "; UNRESOLVED pixels are poles, spent budgets, or rays from so far away that they may lie anywhere in the bounds: a larger "
                'max_pieces or time_limit, precision="double", a factored formula or a nearer camera may help'
            )
        return text + ">"


class Hits:
    """What `trace` found, ray by ray.

    Attributes:
        t: (N,), in lengths of the direction; +inf for MISS.    uncertainty: (N,), as in `Frame`.
        normal: (N, 3) float32.    status: (N,) uint8.    hit: (N,) bool.    points: (N, 3).
        stats: `Stats`.
    """

    def __init__(
        self,
        result: Mapping[str, Any],
        origins: npt.NDArray[np.float64],
        directions: npt.NDArray[np.float64],
        stats: Stats,
    ) -> None:
        self.t: npt.NDArray[Any] = result["depth"][0]
        self.uncertainty: npt.NDArray[Any] = result["uncertainty"][0]
        self.status: npt.NDArray[np.uint8] = result["status"][0]
        self.normal: npt.NDArray[np.float32] = result["normal"][0]
        self._origins = origins
        self._directions = directions
        self.stats = stats

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """(N,) bool: HIT or TOUCH."""
        return (self.status == Status.HIT) | (self.status == Status.TOUCH)

    @property
    def points(self) -> npt.NDArray[Any]:
        """(N, 3): where the rays hit; nan where they do not."""
        t = np.where(self.hit, self.t, np.nan).astype(np.float64)
        return (self._origins + t[:, None] * self._directions).astype(self.t.dtype)

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        shown = ", ".join(f"{n} {k}" for k, n in self.stats.counts.items() if n) or "no rays"
        return f"<Hits of {len(self)} rays, {self.stats.method} on {self.stats.device}: {shown}>"
