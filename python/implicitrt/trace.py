"""trace: batches of rays."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt import _core
from implicitrt.arguments import ray_batch
from implicitrt.expression import ExprLike, sympify
from implicitrt.frame import Hits
from implicitrt.request import finder_request, stats_of

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["trace"]


def trace(
    f: ExprLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    tmin: npt.ArrayLike = 0,
    tmax: npt.ArrayLike = math.inf,
    bounds: Any = None,
    method: Any = "auto",
    eps: float | None = None,
    params: Mapping[str, float] | None = None,
    device: str | None = None,
    precision: str = "auto",
    rounding: str = "outward",
    *,
    isovalue: float | None = None,
    max_pieces: int | None = None,
    steps: int | None = None,
    time_limit: float | None = None,
) -> Hits:
    """Traces any batch of rays to the first zero of f.

    Args:
        f, method, eps, params, device, precision, rounding, isovalue, max_pieces, steps, time_limit:
            as in `render`; eps and t count in lengths of the direction.
        origins, directions: (3,) or (N, 3), any float type; they broadcast.
        tmin, tmax: the part of each ray that counts; numbers or (N,).
        bounds: as in `render`; default: the named surface's, else none, and then tmax must be finite.

    Returns:
        `Hits` with arrays of length N. N = 0 works.

    Raises:
        ArgumentError: a ray is left infinite, a direction is zero or not finite, shapes do not fit.
    """
    started = time.perf_counter()
    expr = sympify(f)
    o, d, near, far, region = ray_batch(f, origins, directions, tmin, tmax, bounds)
    request, reason = finder_request(
        f, expr, region, method, eps, params, device, precision, rounding, isovalue, max_pieces, time_limit, None,
        steps=steps, shortest=float(np.hypot(np.hypot(d[:, 0], d[:, 1]), d[:, 2]).min(initial=np.inf)),
    )
    request |= {
        "want": {"normal"},
        "origins": o,
        "directions": d,
        "tmin": np.maximum(near, -1e300),
        "tmax": np.minimum(far, 1e300),
    }
    parsed = time.perf_counter()
    result = _core.trace_rays(request["formula"], request)
    return Hits(result, o, d, stats_of(request, result, reason, started, parsed))
