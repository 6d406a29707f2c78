"""The command line: ``implicitrt render | compare | info | list``."""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import implicitrt as irt
from implicitrt.errors import ArgumentError, Error
from implicitrt.files import write_atomically

__all__ = ["main"]


def _size(text: str) -> tuple[int, int]:
    parts = text.lower().replace(",", "x").split("x")
    try:
        width, height = (int(p) for p in (parts * 2 if len(parts) == 1 else parts))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no size; write 640x480") from None
    return width, height


def _numbers(text: str) -> list[float]:
    try:
        return [float(p) for p in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' are no numbers; separate them by commas") from None


_BOUNDS = "R, X0,X1,Y0,Y1,Z0,Z1, sphere:X,Y,Z,R, halfspace:NX,NY,NZ,OFFSET or clip:FORMULA"


def _region(text: str) -> Any:
    kind, _, rest = text.rpartition(":")
    if kind == "clip":
        return irt.Clip(rest)
    try:
        values = [float(p) for p in rest.split(",")]
    except ValueError:
        values = []
    if kind == "sphere" and len(values) == 4:
        return irt.Sphere(values[:3], values[3])
    if kind == "halfspace" and len(values) == 4:
        return irt.HalfSpace(values[:3], values[3])
    if not kind and len(values) == 1:
        return values[0]
    if not kind and len(values) == 6:
        return tuple(zip(values[::2], values[1::2], strict=True))
    raise ArgumentError(f"'{text}' are no bounds; write {_BOUNDS}")


def _samples(text: str | None) -> Any:
    return int(text) if text is not None and text.isdecimal() else text


def _parameter(text: str) -> tuple[str, float]:
    name, equals, value = text.partition("=")
    try:
        if not equals:
            raise ValueError
        return name.strip(), float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no parameter; write a=0.5") from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="implicitrt", description="Ray traces any surface f(x, y, z) = 0 straight from its formula."
    )
    parser.add_argument("--version", action="version", version=f"implicitrt {irt.__version__}")
    commands = parser.add_subparsers(dest="command", required=True)
    render = commands.add_parser("render", help="draw a named surface or a formula to a file")
    render.add_argument("what", metavar="NAME_OR_FORMULA", help="a name (see list) or a formula")
    render.add_argument("-o", "--output", required=True, help="a .png, or .npz with everything")
    render.add_argument("--size", type=_size, default=(640, 480), help="640x480")
    render.add_argument(
        "--camera", type=_numbers, metavar="X,Y,Z[,TX,TY,TZ]", help="the eye, and the point it looks at"
    )
    render.add_argument("--up", type=_numbers, default=[0, 1, 0], metavar="X,Y,Z", help="up for --camera")
    render.add_argument("--fov", type=float, default=40, help="vertical field of view in degrees for --camera")
    render.add_argument(
        "--bounds", action="append", metavar="REGION", help=f"{_BOUNDS}; given several times, their intersection"
    )
    render.add_argument("--method", default="auto", help=", ".join(irt.methods()))
    render.add_argument("--eps", type=float, help="width of a hit's bracket")
    render.add_argument("--device", help="part of a device's or driver's name (see info)")
    render.add_argument("--precision", default="auto", choices=("auto", "single", "double"))
    render.add_argument("--rounding", default="outward", choices=("outward", "fast"))
    render.add_argument("--normals", default="gradient", choices=("gradient", "neighbours"))
    render.add_argument(
        "--antialias", metavar="N", help="means of N x N samples in each pixel, or 'silhouette': only where it shows"
    )
    compare = commands.add_parser("compare", help="chart speed against accuracy, method by method")
    compare.add_argument("what", metavar="NAME_OR_FORMULA", nargs="+", help="names (see list) or formulas")
    compare.add_argument("-o", "--output", required=True, help="a .png or .svg chart, or a .csv or .md table")
    compare.add_argument("--methods", type=lambda s: s.split(","), help="some of: " + ", ".join(irt.methods()))
    compare.add_argument("--eps", type=_numbers, default=[1e-2, 1e-3, 1e-4], help="1e-2,1e-3,1e-4")
    compare.add_argument("--size", type=_size, default=(256, 256), help="256x256")
    compare.add_argument("--runs", type=int, default=5, help="timed frames for each point")
    compare.add_argument("--device", help="part of a device's or driver's name (see info)")
    for command in (render, compare):
        command.add_argument("--param", type=_parameter, action="append", default=[], metavar="NAME=VALUE", help="a parameter's value")
    commands.add_parser("info", help="show every OpenCL driver found, and which is used")
    commands.add_parser("list", help="show the named surfaces")
    return parser


def _progress() -> Callable[[float], None]:
    """Shows progress on a terminal, once a render has taken a second."""
    started = time.monotonic()

    def show(fraction: float) -> None:
        if sys.stderr.isatty() and time.monotonic() - started > 1:
            sys.stderr.write(f"\r{fraction:4.0%}" + ("\r     \r" if fraction >= 1 else ""))
            sys.stderr.flush()

    return show


def _check_output(path: Path, kinds: tuple[str, ...]) -> None:
    """Bad output names are told before the work, not after it."""
    if path.suffix.lower() not in kinds:
        raise ArgumentError(f"the output is a {', '.join(kinds[:-1])} or {kinds[-1]}, not '{path.name}'")
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ArgumentError(f"cannot write into '{path.parent}': {error.strerror}") from None


def _surface(what: str, params: list[tuple[str, float]]) -> Any:
    """A lone name that nobody gives a value is a surface, or one misspelt."""
    what = what.strip()
    named = what in irt.surfaces or (what.isidentifier() and what not in {"x", "y", "z", *dict(params)})
    return irt.surfaces[what] if named else what


def _render(args: argparse.Namespace) -> None:
    output = Path(args.output)
    _check_output(output, (".png", ".npz"))
    surface = _surface(args.what, args.param)
    camera = None
    if args.camera:
        if len(args.camera) not in (3, 6):
            raise ArgumentError("--camera takes X,Y,Z or X,Y,Z,TX,TY,TZ")
        camera = irt.Camera(args.camera[:3], args.camera[3:] or (0, 0, 0), args.up, args.fov)
    frame = irt.render(
        surface, bounds=args.bounds and [_region(text) for text in args.bounds], camera=camera, size=args.size, method=args.method, eps=args.eps,
        params=dict(args.param), device=args.device, precision=args.precision, rounding=args.rounding,
        normals=args.normals, antialias=_samples(args.antialias), progress=_progress(),
    )  # fmt: skip
    frame.save(output)
    stats = frame.stats
    times = ", ".join(f"{name} {1e3 * s:.0f}" for name, s in stats.seconds.items())
    print(f"{output}: {frame.size[0]} x {frame.size[1]}, method {stats.method} ({stats.reason})")
    print(f"device: {stats.device} by {stats.driver}, {stats.precision}, packets of {stats.width}")
    print(f"milliseconds: {times}")
    print("pixels: " + ", ".join(f"{n} {name}" for name, n in stats.counts.items()))


def _compare(args: argparse.Namespace) -> int:
    output = Path(args.output)
    _check_output(output, (".png", ".svg", ".csv", ".md"))
    found = irt.compare(
        [_surface(what, args.param) for what in args.what], args.methods, args.eps, args.size, args.device, runs=args.runs, params=dict(args.param) or None,
        progress=lambda line: print(line, file=sys.stderr, flush=True),
    )  # fmt: skip
    if output.suffix.lower() == ".csv":
        found.to_csv(output)
    elif output.suffix.lower() == ".md":
        write_atomically(output, (found.to_markdown() + "\n").encode())
    elif found or found.complete:
        found.plot(output)
    print(found)
    return 0 if found.complete else 130


def _list() -> None:
    for surface in irt.surfaces.values():
        degree = "-" if surface.degree is None else surface.degree
        print(f"{surface.name:24} degree {degree!s:4} {surface.notes}")


def _value(text: str) -> str:
    """Formulas and numbers that begin with a minus would be options to argparse; a blank before them tells it better."""
    return f" {text}" if re.match(r"-(?!-|h$|o)", text) else text


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command. Returns 0, 1 for errors, 130 after Ctrl-C; argparse exits with 2."""
    given = sys.argv[1:] if arguments is None else arguments
    args = _parser().parse_args([_value(a) for a in given])
    try:
        if args.command == "render":
            _render(args)
        elif args.command == "compare":
            return _compare(args)
        elif args.command == "info":
            from implicitrt.devices import describe

            print(describe())
        else:
            _list()
        sys.stdout.flush()
    except BrokenPipeError:  # before OSError, which it is: the reader of a pipe has had enough (| head), no error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (Error, OSError) as error:
        print(f"implicitrt: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("implicitrt: interrupted; nothing was written", file=sys.stderr)
        return 130
    return 0
