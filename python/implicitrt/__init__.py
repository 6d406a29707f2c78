"""Ray traces any surface f(x, y, z) = 0 straight from its formula, and says what it has proven."""

from __future__ import annotations

from pathlib import Path as _Path

from implicitrt import _core
from implicitrt.bounds import Clip, HalfSpace, Sphere
from implicitrt.camera import Camera
from implicitrt.compare import Comparison, compare
from implicitrt.devices import Device, devices
from implicitrt.enclose import enclose, enclose_rays
from implicitrt.errors import (
    ArgumentError,
    BuildError,
    DeviceError,
    Error,
    ExpressionError,
    LimitError,
    MethodError,
)
from implicitrt.expression import (
    Abs,
    And,
    Condition,
    E,
    Eq,
    Expr,
    Max,
    Min,
    Mod,
    Ne,
    Not,
    Or,
    Piecewise,
    Rational,
    acos,
    asin,
    atan,
    atan2,
    cbrt,
    ceiling,
    cos,
    cosh,
    exp,
    floor,
    log,
    parse,
    pi,
    sign,
    sin,
    sinh,
    sqrt,
    symbols,
    sympify,
    tan,
    tanh,
    x,
    y,
    z,
)
from implicitrt.frame import Frame, Hits, Stats, Status
from implicitrt.methods import (
    Analytic,
    Bisection,
    Contraction,
    CsgAnalytic,
    Marching,
    Method,
    Mitchell,
    SampledNewton,
    explain,
    methods,
)
from implicitrt.reference import Reference, reference
from implicitrt.render import kernel_source, render
from implicitrt.set_operations import r_intersection, r_subtraction, r_union
from implicitrt.surfaces import NamedSurface, surfaces
from implicitrt.trace import trace

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    # For those who test: nobody else waits for it.
    if name == "testing":
        import importlib

        return importlib.import_module("implicitrt.testing")
    raise AttributeError(f"module 'implicitrt' has no attribute {name!r}")


# The kernel library lies beside the extension, which an editable install keeps elsewhere.
_core.set_kernel_directory(str(_Path(_core.__file__).resolve().parent / "kernels"))

__all__ = [
    "Abs", "Analytic", "And", "ArgumentError", "Bisection", "BuildError", "Camera", "Clip", "Comparison", "Condition", "Contraction", "CsgAnalytic", "Device", "DeviceError", "E", "Eq",
    "Error", "Expr", "ExpressionError", "Frame", "HalfSpace", "Hits", "LimitError", "Marching", "Max", "Method", "MethodError", "Min", "Mitchell", "Mod",
    "NamedSurface", "Ne", "Not", "Or", "Piecewise", "Rational", "Reference", "SampledNewton", "Sphere", "Stats", "Status", "acos", "asin", "atan",
    "atan2", "cbrt", "ceiling", "compare", "cos", "cosh", "devices", "enclose", "enclose_rays", "exp", "explain", "floor",
    "kernel_source", "log", "methods", "parse", "pi", "r_intersection", "r_subtraction", "r_union", "reference", "render", "sign", "sin", "sinh", "sqrt", "surfaces", "symbols",
    "sympify", "tan", "tanh", "trace", "x", "y", "z",
]  # fmt: skip
