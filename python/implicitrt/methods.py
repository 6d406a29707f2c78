"""The methods: what each accepts and guarantees, which kernel file it runs, and which one auto takes."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from implicitrt import _core
from implicitrt.errors import ArgumentError, LimitError
from implicitrt.expression import Expr, ExprLike, sympify
from implicitrt.set_operations import closed_polynomial, set_form

__all__ = ["Analytic", "Bisection", "Contraction", "CsgAnalytic", "Marching", "Method", "Mitchell", "SampledNewton", "explain", "methods"]


@dataclass(frozen=True)
class Method:
    """A root finder: what it accepts, what it guarantees ("inclusion", "numerical", "sampled"), and which options of calls and of its class change what it does."""

    name: str
    accepts: str
    guarantee: str
    options: tuple[str, ...]
    source: str


def _algebra(given: Any) -> str:
    if not isinstance(given, str) or given not in ("ia", "raa"):
        raise ArgumentError(f'algebra must be "ia" or "raa", not {given!r}')
    return str(given)


@dataclass(frozen=True)
class Bisection:
    """Bisection with an inclusion algebra, "ia" or "raa", and for "ia" with a `stack`; "ia", "raa" and "ia-stack" are its shorthand."""

    algebra: str = "raa"
    stack: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "algebra", _algebra(self.algebra))
        if not isinstance(self.stack, (bool, np.bool_)):
            raise ArgumentError(f"stack must be True or False, not {self.stack!r}")
        if self.stack and self.algebra != "ia":
            raise ArgumentError('bisection with a stack is there for algebra "ia" only')

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return f"{self.algebra}-stack" if self.stack else self.algebra


@dataclass(frozen=True)
class Contraction:
    """The forward march with affine contraction; "contract" is its shorthand.

    beams: whether frames bound the rays of 4 x 4 pixels by one enclosure first. None: frames of more than
        640 x 480 pixels do, for which compiling them pays.
    """

    beams: bool | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.beams, (bool, np.bool_, type(None))):
            raise ArgumentError(f"beams must be True, False or None, not {self.beams!r}")

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return "contract"


@dataclass(frozen=True)
class Mitchell:
    """Mitchell's method: roots isolated by enclosures of f and of its derivative along the ray, by the algebra "ia" or "raa", then Newton
    steps; "mitchell" is its shorthand."""

    algebra: str = "raa"

    def __post_init__(self) -> None:
        object.__setattr__(self, "algebra", _algebra(self.algebra))

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return "mitchell"


@dataclass(frozen=True)
class Analytic:
    """Closed forms of polynomials up to degree 4 along the ray; "analytic" is its shorthand."""

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return "analytic"


@dataclass(frozen=True)
class CsgAnalytic:
    """Closed forms of polynomials up to degree 4 under Min, Max and R-functions; "csg-analytic" is its shorthand."""

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return "csg-analytic"


@dataclass(frozen=True)
class Marching:
    """Steps along the ray, `steps` of them between the bounds: with the sign `test` or S3's "taylor", of equal length or `adaptive`.

    "marching-sign", "marching-taylor", "adaptive-sign" and "adaptive-taylor" are its shorthand.
    """

    test: str = "sign"
    adaptive: bool = False
    steps: int | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.test, str) or self.test not in ("sign", "taylor"):
            raise ArgumentError(f'test must be "sign" or "taylor", not {self.test!r}')
        if not isinstance(self.adaptive, (bool, np.bool_)):
            raise ArgumentError(f"adaptive must be True or False, not {self.adaptive!r}")
        checked_steps(self.steps)

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return f"{'adaptive' if self.adaptive else 'marching'}-{self.test}"


@dataclass(frozen=True)
class SampledNewton:
    """`steps` of equal length along the ray, then Newton's method and regula falsi; "sampled-newton" is its shorthand."""

    steps: int | None = None

    def __post_init__(self) -> None:
        checked_steps(self.steps)

    @property
    def name(self) -> str:
        """The method's name in `methods()`."""
        return "sampled-newton"


def checked_steps(steps: Any) -> int | None:
    """Steps of a method that samples: a whole number, or None for its own."""
    if steps is None:
        return None
    if not isinstance(steps, (int, np.integer)) or isinstance(steps, bool) or not 0 < steps <= MAX_STEPS:
        raise ArgumentError(f"steps must be a whole number from 1 to {MAX_STEPS}, not {steps!r}")
    return int(steps)


def _as_it_is(f: Expr, isovalue: float | None) -> Expr:
    return f


@dataclass(frozen=True)
class Entry:
    """A method as it runs: kernels/<finder>.cl, with an algebra, whether it asks the formula of `Clip`, and what it reads of f
    along the ray (kReaders in cpp/kernel/assemble.cpp).

    `prepare` takes a formula and an isovalue and gives the formula that the kernel is made from, or raises MethodError;
    `defines` are macros that the kernel file tests; `steps` is how many a method that samples takes.
    """

    method: Method
    finder: str
    algebra: str
    clips: bool
    reads: str = "enclosures"
    prepare: Callable[[Expr, float | None], Expr] = _as_it_is
    defines: tuple[str, ...] = ()
    steps: int = 0

    @property
    def marches(self) -> bool:
        """Whether signs of f itself, in the arithmetic of the kernel, decide."""
        return self.reads == "enclosures" and not self.finder.startswith("frustum_")


_FRUSTUM_FINDERS = {
    "lr": "the frustum form; Bezier subdivision at the control polygon's first zero",
    "lr-mult": "the same with an estimate of the root's multiplicity",
    "mr": "the frustum form; knots inserted at the control polygon's first zero",
    "mr-mult": "the same with an estimate of the root's multiplicity",
    "clip": "the frustum form; Bezier clipping",
    "midpoint": "the frustum form; subdivision at the middle",
}

_INCLUSION_OPTIONS = ("eps", "max_pieces")
_BISECTION_OPTIONS = (*_INCLUSION_OPTIONS, "algebra", "stack")
_FRUSTUM_OPTIONS = (*_INCLUSION_OPTIONS, "previous")
_SAMPLED_OPTIONS = ("eps", "steps", "max_pieces")

MAX_STEPS = 1 << 20  # a little less than positions on a ray that single precision tells apart
FIXED_STEPS = 200  # S3 takes 50 to 400, by surface
ADAPTIVE_STEPS = 100  # and 24 to 100

# To add a method: its row here, and kernels/<finder>.cl.
ENTRIES = MappingProxyType({
    e.method.name: e
    for e in (
        Entry(Method("ia", "every formula", "inclusion", _BISECTION_OPTIONS,
                     "S1 section 4.2: stackless bisection by interval arithmetic"), "bisection", "ia", True),
        Entry(Method("raa", "every formula", "inclusion", _BISECTION_OPTIONS,
                     "S1 section 4.3: stackless bisection by reduced affine arithmetic"), "bisection", "raa", True),
        Entry(Method("ia-stack", "every formula", "inclusion", _BISECTION_OPTIONS,
                     "S4 section 3.1.2: bisection by interval arithmetic with a stack, to compare"), "ia_stack", "ia", True),
        Entry(Method("contract", "every formula", "inclusion", (*_INCLUSION_OPTIONS, "beams"),
                     "ours: a march that cuts away what the affine form excludes (docs/architecture.md)"), "contract", "raa", True),
        Entry(Method("mitchell", "every formula", "inclusion", (*_INCLUSION_OPTIONS, "algebra"),
                     "S3: roots isolated by enclosures of f and of its derivative along the ray, then Newton steps"), "mitchell", "raa", True),
        *(Entry(Method(f"frustum-{name}", "polynomials in x, y, z of degree 1 to 32", "inclusion", _FRUSTUM_OPTIONS,
                       f"S2 section 4.2: {what}"), f"frustum_{name.replace('-', '_')}", "raa", True)
          for name, what in _FRUSTUM_FINDERS.items()),
        Entry(Method("frustum-newton", "polynomials in x, y, z of degree 1 to 32", "inclusion", _FRUSTUM_OPTIONS,
                     "ours, on the frustum form of S2 section 3: cutting at valleys until a root stands alone, then evaluations only"),
              "frustum_newton", "raa", True),
        Entry(Method("analytic", "polynomials in x, y, z up to degree 4", "numerical", (),
                     "S3, S4 section 3.1.1: closed forms along the ray"), "analytic", "raa", False, "coefficients", closed_polynomial),
        Entry(Method("csg-analytic", "polynomials up to degree 4 under Min, Max and R-functions", "numerical", (),
                     "S4 section 4.1.2: closed forms of the leaves, the tree decides"), "csg_analytic", "raa", False, "coefficients", set_form),
        *(Entry(Method(f"{kind}-{test}", "every formula", "sampled", (*_SAMPLED_OPTIONS, "test", "adaptive"), f"S3: {what} points, {test.title()} test"),
                "marching", "point", True, reads, defines=defines, steps=steps)
          for kind, test, what, reads, defines, steps in (
              ("marching", "sign", "marching", "slopes", (), FIXED_STEPS),
              ("marching", "taylor", "marching", "slopes", ("TAYLOR",), FIXED_STEPS),
              ("adaptive", "sign", "adaptive marching", "gradients", ("ADAPTIVE",), ADAPTIVE_STEPS),
              ("adaptive", "taylor", "adaptive marching", "gradients", ("ADAPTIVE", "TAYLOR"), ADAPTIVE_STEPS),
          )),
        Entry(Method("sampled-newton", "every formula", "sampled", _SAMPLED_OPTIONS,
                     "S4 section 3.1.3: sampled search, then Newton's method and regula falsi"),
              "marching", "point", True, "slopes", defines=("FALSI",), steps=FIXED_STEPS),
    )
})  # fmt: skip

_METHODS = MappingProxyType(
    {name: e.method for name, e in ENTRIES.items()}
    | {"auto": Method("auto", "every formula", "inclusion", _FRUSTUM_OPTIONS,
                      "contract, ia for planes, frames of polynomials by frustum-newton; see explain")}
)  # fmt: skip


def methods() -> Mapping[str, Method]:
    """Every method that is built, by name."""
    return _METHODS


_CURVED = frozenset({
    "Pow", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "cbrt",
})  # fmt: skip


# Degrees at which frames by the frustum form are faster than by contraction, and those at which they are for formulas of degree**4 / _LONG parts or more: there
# coefficients take as long as contraction (docs/performance.md).
_FORM_DEGREES, _LONG_DEGREES, _LONG = range(2, 15), range(15, 25), 600


@lru_cache(maxsize=256)
def degree_of(expr: Expr) -> int | None:
    """The degree in x, y, z; None where there is none, or none that is within the caps."""
    try:
        return expr.degree()
    except LimitError:
        return None


@lru_cache(maxsize=256)
def _choose_for_frames(expr: Expr) -> tuple[str, str]:
    """The same for frames: polynomials have their frustum form."""
    degree = degree_of(expr)
    if degree is not None and (degree in _FORM_DEGREES or (degree in _LONG_DEGREES and _core.count_nodes(expr._node) >= degree**4 / _LONG)):
        if degree > 8 and expr._node.op == "Add" and all(len({s.name for s in part.free_symbols} & {"x", "y", "z"}) < 2 for part in expr.args):
            return "contract", "it is a sum of polynomials of one coordinate each, of a high degree: affine forms know their Taylor forms"
        return "frustum-newton", f"it is a polynomial of degree {degree}, and its frustum form depends on nothing else"
    return _choose(expr)


@lru_cache(maxsize=256)
def _choose(expr: Expr) -> tuple[str, str]:
    """The method that auto takes for rays in any order, and why."""
    choice = curved = 0
    stack, seen = [expr._node], set()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        choice += node.op in ("Min", "Max", "Abs")
        curved += node.op in _CURVED or (node.op == "Mul" and sum(a.op != "Number" for a in node.args) > 1)
        stack.extend(node.args)
    if choice and not curved:
        return "ia", "it is made of planes and what chooses between them or jumps, whose ranges along a ray interval arithmetic knows exactly"
    return "contract", "affine forms tell along the ray where zeros may lie"


def explain(f: ExprLike) -> str:
    """Which method "auto" takes for frames of f, and why; where another is taken for rays in any order, which."""
    expr = sympify(f)
    (method, reason), (traced, _) = _choose_for_frames(expr), _choose(expr)
    also = "" if traced == method else f" trace takes {traced}, and so does render with irt.Clip."
    return f"auto takes {method}: {reason}.{also}"


def resolve(method: Any, expr: Expr, frames: bool = False) -> tuple[Entry, str]:
    """The method that runs, and why; `frames`: for a whole frame without clip formulas."""
    name = getattr(method, "name", method)
    if isinstance(name, str) and name == "auto":
        name, reason = _choose_for_frames(expr) if frames else _choose(expr)
        return ENTRIES[name], reason
    if not isinstance(name, str) or name not in ENTRIES:
        close = difflib.get_close_matches(str(method), list(_METHODS), 1)
        hint = f" (did you mean '{close[0]}'?)" if close else ""
        raise ArgumentError(f"unknown method {method!r}{hint}; known are: {', '.join(_METHODS)}")
    return ENTRIES[name], "asked for"
