"""What render and trace ask of the core alike, and what is told of what ran."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from implicitrt.arguments import finite, one_of, positive, request_parameters
from implicitrt.bounds import Bounds
from implicitrt.devices import open_device
from implicitrt.errors import ArgumentError, MethodError
from implicitrt.expression import Expr
from implicitrt.frame import Stats, Status
from implicitrt.methods import ENTRIES, resolve


def finder_request(
    f: Any, expr: Expr, bounds: Bounds, method: Any, eps: float | None, params: Mapping[str, float] | None,
    device: str | None, precision: str, rounding: str, isovalue: float | None, max_pieces: int | None,
    time_limit: float | None, progress: Callable[[float], None] | None, *, frames: bool = False,
) -> tuple[dict[str, Any], str]:  # fmt: skip
    """The part of a request that render and trace share, and why its method was chosen."""
    entry, reason = resolve(method, expr, frames and not bounds.clips)
    if bounds.clips and not entry.clips:
        able = ", ".join(sorted(name for name, e in ENTRIES.items() if e.clips))
        raise MethodError(f"{entry.method.name} knows boxes, balls and half-spaces, not irt.Clip; {able} know it")
    one_of(rounding, "rounding", ("outward", "fast"))
    if max_pieces is not None and not (isinstance(max_pieces, (int, np.integer)) and 0 < max_pieces < 2**31):
        raise ArgumentError(f"max_pieces must be a whole number from 1 to 2**31 - 1, not {max_pieces!r}")
    request = {
        "formula": entry.prepare(expr, isovalue)._node,
        "method": entry.method.name,
        "guarantee": entry.method.guarantee,
        "finder": entry.finder,
        "or_march": method == "auto",
        "reads": entry.reads,
        "algebra": entry.algebra,
        "beams": getattr(method, "beams", None),
        "precision": one_of(precision, "precision", ("auto", "single", "double")),
        # What samples proves nothing, however it rounds.
        "rounding": rounding if entry.method.guarantee == "inclusion" else "fast",
        "eps": bounds.default_eps if eps is None else positive(eps, "eps"),
        "params": request_parameters(f, expr, params, bounds),
        "isovalue": None if isovalue is None else finite(isovalue, "isovalue"),
        "max_pieces": int(max_pieces or 0),
        "time_limit": None if time_limit is None else positive(time_limit, "time_limit"),
        "progress": progress,
        "device": open_device(device),
    } | bounds.request()
    return request, reason


def stats_of(request: dict[str, Any], result: dict[str, Any], reason: str, started: float, parsed: float) -> Stats:
    """What ran, from the request and the core's answer; `started` and `parsed` are of time.perf_counter()."""
    proven = request["rounding"] == "outward"
    device = request["device"]
    depth = result["depth"]
    double = depth.dtype == np.float64
    method = request["method"]
    if result.get("marched"):
        method, reason = "contract", "the frustum form was refused: coefficients leave the range of doubles, or a parameter is no polynomial's"
    return Stats(
        method=method,
        reason=reason, guarantee=request["guarantee"], proven=proven, algebra=request["algebra"],
        device=device.name, driver=device.driver, engine=result["engine"],
        precision="double" if double and request["precision"] == "double" else
                  "single and double" if double else "single",
        width=result["width"], rounding=request["rounding"], builds=int(result["builds"]),
        seconds={"parse": parsed - started, **result["seconds"], "total": time.perf_counter() - started},
        counts={s.name: n for s, n in zip(Status, result["counts"], strict=True)}, wide=int(result["wide"]), escalated=int(result["escalated"]),
    )  # fmt: skip
