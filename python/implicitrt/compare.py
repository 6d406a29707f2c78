"""Speed against accuracy: methods side by side on the same pictures, judged by `reference`."""

from __future__ import annotations

import csv
import html
import io
import statistics
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from implicitrt.arguments import positive, request_progress
from implicitrt.devices import open_device
from implicitrt.errors import ArgumentError, MethodError
from implicitrt.expression import Expr, ExprLike, sympify
from implicitrt.files import write_atomically
from implicitrt.frame import Frame, Status
from implicitrt.methods import methods as known_methods
from implicitrt.reference import Reference, reference
from implicitrt.render import render
from implicitrt.surfaces import NamedSurface, surfaces

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["Comparison", "Point", "compare"]

# Frames of each point before those that are timed: the first builds its kernel, behind the second one that is needed at times may be built.
UNTIMED = 2


@dataclass(frozen=True)
class Point:
    """One method on one formula at one eps."""

    formula: str
    method: str
    eps: float
    milliseconds: float  # of a frame's kernels and, by the frustum form, of its coefficients before them; median
    kernel_milliseconds: float  # of the kernels alone
    of_limit: float  # the same, in times of what one look and one gradient a pixel take
    largest_error: float  # of depth, over the pixels that both call hits
    median_error: float
    normal_error: float  # radians, median
    wrong_misses: int  # MISS where the reference has a root
    wrong_hits: int  # HIT where the reference proves that there is none
    touching: int
    unresolved: int
    wide: int  # HITs whose bracket is wider than eps
    ran: str  # the method and precision that ran


class Comparison:
    """A table of `Point`s: iterate over it, `to_csv`, `plot`; shows itself in Jupyter."""

    def __init__(self, points: Sequence[Point], size: tuple[int, int], device: str, complete: bool = True) -> None:
        self.points = tuple(points)
        self.size = size
        self.device = device
        self.complete = complete  # False where it was interrupted

    def __iter__(self) -> Any:
        return iter(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        head = [f.name for f in fields(Point)]
        return head, [[_short(getattr(p, name)) for name in head] for p in self.points]

    def to_csv(self, path: str | Path | None = None) -> str:
        """The table as CSV, in full precision; written to `path` as well where one is given."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow([f.name for f in fields(Point)])
        writer.writerows([[getattr(p, f.name) for f in fields(Point)] for p in self.points])
        if path is not None:
            write_atomically(path, out.getvalue().encode())
        return out.getvalue()

    def to_markdown(self) -> str:
        """The table as Markdown."""
        head, rows = self._cells()
        lines = ["| " + " | ".join(r) + " |" for r in [head, *rows]]
        return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]]) + self._ending("\n\n")

    def _repr_html_(self) -> str:
        head, rows = self._cells()
        cells = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in rows)
        return "<table><tr>" + "".join(f"<th>{h}</th>" for h in head) + f"</tr>{cells}</table>" + self._ending("")

    def __repr__(self) -> str:
        head, rows = self._cells()
        widths = [max(len(r[k]) for r in [head, *rows]) for k in range(len(head))]
        text = "\n".join("  ".join(c.rjust(w) for c, w in zip(r, widths, strict=True)) for r in [head, *rows])
        return text + self._ending("\n")

    def _ending(self, before: str) -> str:
        return "" if self.complete else before + "(interrupted)"

    def pareto(self, formula: str) -> list[Point]:
        """The points of a formula that no other one beats in time and in largest error, fastest first. What misses roots, or
        sees some that are not there, is beaten by everything."""
        points = [p for p in self.points if p.formula == formula and not p.wrong_misses and not p.wrong_hits]
        front: list[Point] = []
        for p in sorted(points, key=lambda p: (p.milliseconds, p.largest_error)):
            if not front or p.largest_error < front[-1].largest_error:
                front.append(p)
        return front

    def plot(self, path: str | Path | None = None) -> Any:
        """Largest error against time, a panel for each formula, a line for each method, dashed where it proves nothing; rings mark the
        Pareto front.

        Returns:
            the Matplotlib figure, saved to `path` where one is given.
        """
        try:
            from matplotlib import colormaps
            from matplotlib.figure import Figure
        except ImportError:
            raise ArgumentError(
                'plot needs Matplotlib: pip install "implicitrt[plot]"; to_csv and to_markdown need nothing'
            ) from None
        names = list(dict.fromkeys(p.formula for p in self.points))
        if not names:
            raise ArgumentError("there is nothing to plot: the comparison has no points")
        kind = "png" if path is None else Path(path).suffix.lower().lstrip(".") or "png"
        columns = min(3, len(names))
        rows = -(-len(names) // columns)
        figure = Figure(figsize=(4.6 * columns, 3.6 * rows), layout="constrained")
        if kind not in (formats := figure.canvas.get_supported_filetypes()):
            raise ArgumentError(f"a chart is saved as {', '.join(sorted(formats))}, not as '{path}'")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        kinds = list(dict.fromkeys(p.method for p in self.points))
        colors = colormaps["tab20"].colors  # type: ignore[attr-defined]
        proven = {name for name, m in known_methods().items() if m.guarantee == "inclusion"}
        for panel, name in zip(panels, names, strict=False):
            for k, method in enumerate(kinds):
                line = sorted((p for p in self.points if (p.formula, p.method) == (name, method)), key=lambda p: -p.eps)
                if line:
                    panel.plot([p.milliseconds for p in line], [max(p.largest_error, 1e-16) for p in line], marker="o", markersize=3.5,
                               color="black" if method == "auto" else colors[k % len(colors)], linestyle="-" if method in proven else "--", label=method)  # fmt: skip
                    wrong = [p for p in line if p.wrong_misses or p.wrong_hits]
                    panel.plot(
                        [p.milliseconds for p in wrong], [max(p.largest_error, 1e-16) for p in wrong], "x", color="red"
                    )
            front = self.pareto(name)
            panel.plot([p.milliseconds for p in front], [max(p.largest_error, 1e-16) for p in front], "o", markersize=9,
                       fillstyle="none", color="0.3")  # fmt: skip
            panel.set(xscale="log", yscale="log", title=name[:40], xlabel="ms per frame", ylabel="largest depth error")
            panel.grid(True, which="both", alpha=0.25)
            panel.tick_params(axis="x", which="minor", labelsize=6, labelrotation=45)
        for panel in panels[len(names) :]:
            panel.set_visible(False)
        lines = {text: line for p in panels for line, text in zip(*p.get_legend_handles_labels(), strict=True)}
        figure.legend(lines.values(), lines.keys(), loc="outside lower center", ncols=3 * columns, fontsize="small")
        figure.suptitle(
            f"{self.size[0]} x {self.size[1]}, {self.device}; rings: Pareto front, red: wrong statuses",
            fontsize="small",
        )
        if path is not None:
            picture = io.BytesIO()
            figure.savefig(picture, dpi=130, format=kind)
            write_atomically(path, picture.getvalue())
        return figure


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return str(value)


def _named(f: ExprLike | NamedSurface) -> tuple[str, ExprLike | NamedSurface]:
    """What to call a formula, and the formula; a known surface's name wins."""
    if isinstance(f, NamedSurface):
        return f.name, f
    if isinstance(f, str) and f in surfaces:
        return f, surfaces[f]
    return str(f), f


def _list(value: Any, kinds: tuple[type, ...]) -> list[Any]:
    return [value] if isinstance(value, kinds) or not isinstance(value, Iterable) else list(value)


def true_normals(
    f: Any, truth: Reference, camera: Any, size: tuple[int, int], params: Mapping[str, float] | None = None
) -> npt.NDArray[np.float64]:
    """Unit gradients at the reference's points, towards the viewer; nan where there is none."""
    expr = f.expr if isinstance(f, NamedSurface) else sympify(f)
    values = (dict(f.params) if isinstance(f, NamedSurface) else {}) | dict(params or {})
    origins, directions = camera.rays(size)
    with np.errstate(all="ignore"):
        points = origins + np.where(truth.hit, truth.depth, np.nan)[..., None] * directions
        parts = [_values(expr.diff(axis), points, values) for axis in "xyz"]
        gradient = np.stack(parts, axis=-1)
        gradient /= np.linalg.norm(gradient, axis=-1, keepdims=True)
        towards = -np.sign((gradient * directions).sum(-1, keepdims=True))
    return gradient * towards


def _values(e: Expr, points: npt.NDArray[np.float64], params: dict[str, float]) -> npt.NDArray[np.float64]:
    used = {k: v for k, v in params.items() if k in {s.name for s in e.free_symbols}}
    return np.broadcast_to(e.evaluate(*np.moveaxis(points, -1, 0), **used), points.shape[:-1])


def _judged(
    name: str, method: str, eps: float, frame: Frame, times: Sequence[tuple[float, float]], limit: float, truth: Reference, normals: Any
) -> Point:
    both = truth.hit & frame.hit
    with np.errstate(invalid="ignore"):
        error = np.abs(frame.depth - truth.depth)[both]
        cosine = np.clip((frame.normal * normals).sum(-1), -1, 1)[both]
    angle = np.arccos(cosine[np.isfinite(cosine)])
    status = frame.status
    milliseconds, kernels = (statistics.median(column) for column in zip(*times, strict=True))
    return Point(
        formula=name, method=method, eps=eps, milliseconds=milliseconds, kernel_milliseconds=kernels,
        of_limit=milliseconds / limit,
        largest_error=float(error.max(initial=0)), median_error=float(np.median(error)) if error.size else 0.0,
        normal_error=float(np.median(angle)) if angle.size else 0.0,
        wrong_misses=int((truth.hit & (status == Status.MISS)).sum()),
        wrong_hits=int(((truth.kind == Status.MISS) & (status == Status.HIT)).sum()),
        touching=int((status == Status.TOUCH).sum()), unresolved=int((status == Status.UNRESOLVED).sum()),
        wide=frame.stats.wide, ran=f"{frame.stats.method}, {frame.stats.precision}",
    )  # fmt: skip


def _in_turns(
    f: Any, methods: Sequence[Any], runs: int, keywords: dict[str, Any]
) -> tuple[dict[str, Frame], dict[str, list[tuple[float, float]]], bool]:
    """The last frame and the times of each method that takes the formula (milliseconds in all, and of the kernels), and whether Ctrl-C cut it short. Methods take
    turns, so that other load on the machine hits all alike; the first two turns do not count."""
    last: dict[str, Frame] = {}
    times: dict[str, list[tuple[float, float]]] = {}
    able = {m if isinstance(m, str) else repr(m): m for m in methods}
    try:
        for run in range(-UNTIMED, runs):
            if run == 0:
                open_device(keywords["device"]).finish()
            for label, method in list(able.items()):
                try:
                    frame = render(f, method=method, **keywords)
                except MethodError:  # it does not take this formula
                    del able[label]
                    continue
                if run >= 0:
                    last[label] = frame
                    kernels = 1e3 * frame.stats.seconds["kernel"]
                    times.setdefault(label, []).append((kernels + 1e3 * frame.stats.seconds.get("prepare", 0.0), kernels))
    except KeyboardInterrupt:
        return last, times, True
    return last, times, False


def compare(
    formulas: Any,
    methods: Any = None,
    eps: Any = (1e-2, 1e-3, 1e-4),
    size: tuple[int, int] = (256, 256),
    device: str | None = None,
    *,
    bounds: Any = None,
    params: Mapping[str, float] | None = None,
    runs: int = 5,
    precision: str = "auto",
    rounding: str = "outward",
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Charts speed against accuracy: every method at every eps on every formula, judged by `reference`.

    Args:
        formulas: a formula or a list of them; a known surface's name wins over the formula of that name.
        methods: names of `methods()`, default all of them.
        eps: a number or several, in units of distance.
        size: of the pictures, (width, height).
        bounds, params: as in `render`, for all of the formulas.
        runs: timed frames of each point, whose median counts; two more go before them. Methods take turns.
        precision, rounding: as in `render`.
        progress: called with a line for each point; default: a line on standard error where that is a terminal.

    Returns:
        a `Comparison`. Ctrl-C ends it and keeps what is done. Milliseconds are of the kernels and of the frustum form's coefficients, which the host
        makes for each frame; `of_limit` divides them by the time, measured just before, of a frame that looks once at each ray and takes its gradient.

    Raises:
        ArgumentError, ExpressionError, MethodError, DeviceError.
    """
    if not isinstance(runs, (int, np.integer)) or isinstance(runs, bool) or runs < 1:
        raise ArgumentError(f"runs must be a whole number, at least 1, not {runs!r}")
    request_progress(progress)
    widths = [positive(e, "eps") for e in _list(eps, (int, float, str))]
    chosen = list(known_methods()) if methods is None else _list(methods, (str,))
    asked = [_named(f) for f in _list(formulas, (str, Expr, NamedSurface))]
    for what, given in {"formulas": asked, "methods": chosen, "eps": widths}.items():
        if not given:
            raise ArgumentError(f"{what} is empty; give at least one")
    if progress is None and sys.stderr.isatty():

        def progress(line: str) -> None:
            print(line, file=sys.stderr, flush=True)

    points: list[Point] = []
    used = device or ""
    keywords: dict[str, Any] = {
        "bounds": bounds, "params": params, "size": size, "device": device, "precision": precision, "outputs": ("normal",),
    }  # fmt: skip

    def look(formula: Any, size: tuple[int, int]) -> Frame:
        """One look at each ray and a gradient: what no root finder can go below."""
        return render(formula, eps=1e6, method="raa", rounding="fast", **keywords | {"precision": "single", "size": size})

    try:
        for _, formula in asked[1:]:  # what is wrong with the last is told before the first is drawn
            look(formula, (1, 1))
        for name, formula in asked:
            looks = [look(formula, size) for _ in range(runs + 1)]
            limit = 1e3 * statistics.median(g.stats.seconds["kernel"] for g in looks[1:])
            used, camera = looks[0].stats.device, looks[0].camera
            truth = reference(formula, bounds=bounds, size=size, params=params)
            normals = true_normals(formula, truth, camera, size, params)
            for width in widths:
                last, times, interrupted = _in_turns(formula, chosen, runs, {"eps": width, "rounding": rounding, **keywords})
                for method, frame in last.items():
                    points.append(_judged(name, method, width, frame, times[method], limit, truth, normals))
                    if progress:
                        p = points[-1]
                        progress(f"{name}  {method}  eps {width:g}: {p.milliseconds:.1f} ms, largest error {p.largest_error:.1e}")
                if interrupted:
                    return Comparison(points, size, used, complete=False)
    except KeyboardInterrupt:
        return Comparison(points, size, used, complete=False)
    if not points:
        raise MethodError("none of these methods takes any of these formulas; irt.methods() says what each is for")
    return Comparison(points, size, used)
