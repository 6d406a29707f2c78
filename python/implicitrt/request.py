"""What render and trace ask of the core alike, and what is told of what ran."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from implicitrt import _core
from implicitrt.arguments import finite, one_of, positive, request_parameters, request_progress
from implicitrt.bounds import Bounds
from implicitrt.devices import open_device
from implicitrt.errors import ArgumentError, MethodError
from implicitrt.expression import Expr
from implicitrt.frame import Stats, Status
from implicitrt.methods import ENTRIES, Entry, checked_steps, resolve

# Where eps is below so many times what single precision resolves, in frames by these root finders single precision proves brackets of BRACKETS times that, which it
# does quickly, and they are narrowed down to eps in double, at once (kernels/refine.cl) or by a second pass (kernels/sharpen.cl). Below FINEST times that double cannot
# reach eps either, and would look twice.
BLUNT, BRACKETS, FINEST = 30.0, 300.0, 2.0**-22
SHARPENED = {"bisection", "contract", "mitchell"}
# Everything else begins in double where eps is below so many times what single precision resolves, or what it blurs zeros of the formula by is so
# many times eps: it would leave nearly all of it open (docs/speed-accuracy.md, docs/architecture.md).
HOPELESS = 3.0
# Between so many times what single precision resolves, it proves brackets of BRACKETED times that by the frustum form, and double narrows each down at
# once (kernels/frustum_fine.cl).
REFINED, BRACKETED = (0.02, 20.0), 60.0


def finder_request(
    f: Any, expr: Expr, bounds: Bounds, method: Any, eps: float | None, params: Mapping[str, float] | None,
    device: str | None, precision: str, rounding: str, isovalue: float | None, max_pieces: int | None,
    time_limit: float | None, progress: Callable[[float], None] | None, *, frames: bool = False, steps: int | None = None,
    shortest: float = 1.0,
) -> tuple[dict[str, Any], str]:  # fmt: skip
    """The part of a request that render and trace share, and why its method was chosen; `shortest`: the length of the shortest
    direction."""
    entry, reason = resolve(method, expr, frames and not bounds.clips)
    if bounds.clips and not entry.clips:
        able = ", ".join(sorted(name for name, e in ENTRIES.items() if e.clips))
        raise MethodError(f"{entry.method.name} knows boxes, balls and half-spaces, not irt.Clip; {able} know it")
    rounding = one_of(rounding, "rounding", ("outward", "fast"))
    if max_pieces is not None and not (isinstance(max_pieces, (int, np.integer)) and 0 < max_pieces < 2**31):
        raise ArgumentError(f"max_pieces must be a whole number from 1 to 2**31 - 1, not {max_pieces!r}")
    steps = _steps(entry, method, steps)
    width = bounds.default_eps if eps is None else positive(eps, "eps")
    asked = time.perf_counter()
    opened = open_device(device)
    opening = time.perf_counter() - asked
    precision = one_of(precision, "precision", ("auto", "single", "double"))
    values = request_parameters(f, expr, params, bounds)
    first_eps = 0.0
    how = ""
    if precision == "auto":
        resolved = bounds.single_resolution
        blur = 0.0
        if opened.fp64 and entry.marches:
            shifted = expr if isovalue is None else expr - finite(isovalue, "isovalue")
            blur = _blur(shifted, bounds.lower, bounds.upper, tuple(values.items()))
        unresolved = width * shortest < HOPELESS * resolved
        outward = frames and opened.fp64 and rounding == "outward"
        if outward and entry.finder in SHARPENED and FINEST * resolved < width < BLUNT * resolved and blur <= HOPELESS * BRACKETS * resolved:
            first_eps = BRACKETS * resolved
        elif outward and entry.finder == "frustum_newton" and REFINED[0] * resolved < width < REFINED[1] * resolved:
            first_eps = BRACKETED * resolved
        elif opened.fp64 and (unresolved or blur > HOPELESS * width * shortest):
            precision = "double"
            how = "single precision does not resolve eps" if unresolved else "rounding in single precision would drown it"
            how += ", so all is done in double"
        elif entry.steps:
            precision = "single"
        if first_eps:
            how = "eps is near what single precision resolves or below, so brackets found there are narrowed down in double"
    if method == "auto" and how:
        reason = f"{reason}; {how}"
    request = {
        "formula": entry.prepare(expr, isovalue)._node,
        "method": entry.method.name,
        "guarantee": entry.method.guarantee,
        "finder": entry.finder,
        "or_march": method == "auto",
        "reads": entry.reads,
        "defines": list(entry.defines),
        "steps": steps,
        "algebra": getattr(method, "algebra", entry.algebra),
        "beams": getattr(method, "beams", None),
        "precision": precision,
        # What samples proves nothing, however it rounds.
        "rounding": rounding if entry.method.guarantee == "inclusion" else "fast",
        "eps": width,
        "first_eps": first_eps,
        "params": values,
        "isovalue": None if isovalue is None else finite(isovalue, "isovalue"),
        # Enough for the shortest steps of the adaptive march.
        "max_pieces": int(max_pieces or (16 * steps + 4096 if steps else 0)),
        "time_limit": None if time_limit is None else positive(time_limit, "time_limit"),
        "progress": request_progress(progress),
        "device": opened,
        "opening": opening,
    } | bounds.request()
    return request, reason


@lru_cache(maxsize=256)
def _blur(
    shifted: Expr, lower: tuple[float, float, float], upper: tuple[float, float, float], values: tuple[tuple[str, float], ...]
) -> float:
    return _core.single_blur(shifted._node, lower, upper, dict(values))


def _steps(entry: Entry, method: Any, steps: int | None) -> int:
    """How many steps a method that samples takes; 0 for the others."""
    own = getattr(method, "steps", None)
    if steps is None:
        return own or entry.steps
    if not entry.steps:
        able = ", ".join(name for name, e in ENTRIES.items() if e.steps)
        raise ArgumentError(f"steps are for methods that sample ({able}); {entry.method.name} chooses its own")
    if own is not None:
        raise ArgumentError(f"steps are given twice: {own} to the method and {steps} to the call")
    return checked_steps(steps) or 0


def stats_of(request: dict[str, Any], result: dict[str, Any], reason: str, started: float, parsed: float) -> Stats:
    """What ran, from the request and the core's answer; `started` and `parsed` are of time.perf_counter()."""
    proven = request["rounding"] == "outward"
    device = request["device"]
    double = result["depth"].dtype == np.float64 or "finer" in result
    method = request["method"]
    # A driver is looked for, probed and loaded once in a process: seconds, which no parser took.
    driver = {"driver": request["opening"]} if request["opening"] > 1e-3 else {}
    if result.get("marched"):
        method, reason = "contract", "the frustum form was refused: coefficients leave the range of doubles, or a parameter is no polynomial's"
    return Stats(
        method=method,
        reason=reason, guarantee=request["guarantee"], proven=proven, algebra=request["algebra"],
        device=device.name, driver=device.driver, engine=result["engine"],
        precision="double" if double and (request["precision"] == "double" or result["in_double"]) else
                  "single and double" if double else "single",
        width=result["width"], rounding=request["rounding"], builds=int(result["builds"]),
        seconds={"parse": parsed - started - sum(driver.values()), **driver, **result["seconds"], "total": time.perf_counter() - started},
        counts={s.name: n for s, n in zip(Status, result["counts"], strict=True)}, wide=int(result["wide"]), escalated=int(result["escalated"]),
        by_reference=int(result["by_reference"]),
    )  # fmt: skip
