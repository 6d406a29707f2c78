"""Formulas as immutable trees: operators, functions, parsing, and exchange with SymPy and NumPy.

Trees are canonical (arguments sorted, like terms collected, numbers folded exactly) and never
change where a function is defined. ``==`` and ``hash`` compare structure.

Between a formula and an object of SymPy, ``==`` is SymPy's, which converts the formula: ``x == sympy.Symbol("x")``.
Their hashes differ, so sets and keys of dictionaries should be of one kind.
"""

from __future__ import annotations

import numbers
import operator
import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NoReturn, Union

import numpy as np

from implicitrt import _core
from implicitrt.errors import ArgumentError, ExpressionError, LimitError

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = [
    "Abs", "And", "Condition", "E", "Eq", "Expr", "ExprLike", "Max", "Min", "Mod", "Ne", "Not",
    "Or", "Piecewise", "Rational", "acos", "asin", "atan", "atan2", "cbrt", "ceiling", "cos",
    "cosh", "exp", "floor", "log", "parse", "pi", "sign", "sin", "sinh", "sqrt", "symbols",
    "sympify", "tan", "tanh", "x", "y", "z",
]  # fmt: skip


class _Tree:
    """What formulas and conditions share."""

    __slots__ = ("_node",)
    __array_ufunc__ = None  # NumPy scalars and arrays leave the operators to us
    _node: _core.Node

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} objects are immutable")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} objects are immutable")

    def __hash__(self) -> int:
        return hash(self._node)

    def __str__(self) -> str:
        return str(self._node)

    def __repr__(self) -> str:
        return str(self._node)

    def __copy__(self) -> _Tree:
        return self

    def __deepcopy__(self, memo: dict[int, object]) -> _Tree:
        return self

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[list[tuple[str, Any]]]]:
        # By structure, each distinct part once and behind its arguments: text is read to a certain depth only, and trees may be deeper.
        nodes = _core.postorder(self._node)
        index = {node: i for i, node in enumerate(nodes)}
        return _from_parts, ([_part(node, index) for node in nodes],)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self._node.latex()}$"

    @property
    def latex(self) -> str:
        """The formula in LaTeX, without dollar signs."""
        return self._node.latex()

    @property
    def args(self) -> tuple[Any, ...]:
        """The arguments; ``f.func(*f.args) == f``. Those of Piecewise are pairs."""
        parts = [_wrap(a) for a in self._node.args]
        if self._node.op == "Piecewise":
            return tuple(zip(parts[::2], parts[1::2], strict=True))
        return tuple(parts)

    @property
    def func(self) -> Callable[..., Any]:
        """What builds this kind of tree from ``args``."""
        op = self._node.op
        if op in ("Number", "Symbol", "pi", "E", "True", "False"):
            return _Constant(self)
        return _Constructor(op)

    @property
    def free_symbols(self) -> set[Expr]:
        """The symbols in it, x, y and z included."""
        return {Expr(_core.symbol(name)) for name in _core.free_symbols(self._node)}

    def subs(self, *replacements: Any) -> Any:
        """Replaces sub-trees, all at once: ``f.subs({x: y, y: x})`` or ``f.subs(x, 2)``.

        Keys that are strings name symbols. Raises ExpressionError for keys that are no formulas, and where the result is undefined, such as 1/x at x = 0.
        """
        if len(replacements) == 2:
            pairs = [(replacements[0], replacements[1])]
        elif len(replacements) == 1 and isinstance(replacements[0], Mapping):
            pairs = list(replacements[0].items())
        elif len(replacements) == 1:
            pairs = [(old, new) for old, new in replacements[0]]
        else:
            raise TypeError("subs takes a mapping, or the old and the new expression")
        return _wrap(_core.substitute(self._node, [(sympify(old)._node, sympify(new)._node) for old, new in pairs]))


class _Constructor:
    """Builds one kind of tree from its arguments."""

    __slots__ = ("__name__",)

    def __init__(self, op: str) -> None:
        self.__name__ = op

    def __call__(self, *args: Any) -> Any:
        if self.__name__ == "Piecewise":
            return Piecewise(*args)
        return _wrap(_core.call(self.__name__, [_tree(a)._node for a in args]))

    def __repr__(self) -> str:
        return self.__name__

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Constructor) and other.__name__ == self.__name__

    def __hash__(self) -> int:
        return hash(self.__name__)


class _Constant:
    """Rebuilds a tree without arguments."""

    __slots__ = ("_tree", "__name__")

    def __init__(self, tree: _Tree) -> None:
        self._tree = tree
        self.__name__ = tree._node.op

    def __call__(self) -> Any:
        return self._tree

    def __repr__(self) -> str:
        return self.__name__

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Constant) and other._tree == self._tree

    def __hash__(self) -> int:
        return hash(self._tree)


class Expr(_Tree):
    """An immutable formula over real numbers. Built by operators, functions, `parse`, `symbols`."""

    __slots__ = ()

    def __init__(self, value: Any) -> None:
        node = value if isinstance(value, _core.Node) else sympify(value)._node
        object.__setattr__(self, "_node", node)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Expr):
            return self._node == other._node
        if isinstance(other, (numbers.Number, np.number)) and not isinstance(other, bool):
            try:
                return self._node == sympify(other)._node
            except ExpressionError:
                return False
        return NotImplemented

    def __hash__(self) -> int:
        # Numbers equal Python's, so they hash as those do.
        return hash(Fraction(*self._node.ratio())) if self._node.op == "Number" else hash(self._node)

    def __bool__(self) -> bool:
        return self._node.op != "Number" or self._node.ratio()[0] != 0

    def __float__(self) -> float:
        if _core.free_symbols(self._node):
            raise TypeError(f"{self} has symbols, so it is no number; give them values with subs")
        return float(self.evaluate(0.0, 0.0, 0.0))

    def __lt__(self, other: Any) -> Condition:
        return _compare("Lt", self, other)

    def __le__(self, other: Any) -> Condition:
        return _compare("Le", self, other)

    def __gt__(self, other: Any) -> Condition:
        return _compare("Lt", other, self)

    def __ge__(self, other: Any) -> Condition:
        return _compare("Le", other, self)

    def __neg__(self) -> Expr:
        return _binary("Mul", -1, self)

    def __pos__(self) -> Expr:
        return self

    def __abs__(self) -> Expr:
        return Abs(self)

    def __add__(self, other: Any) -> Expr:
        return _binary("Add", self, other)

    def __radd__(self, other: Any) -> Expr:
        return _binary("Add", other, self)

    def __sub__(self, other: Any) -> Expr:
        return _binary("Add", self, _negated(other))

    def __rsub__(self, other: Any) -> Expr:
        return _binary("Add", other, -self)

    def __mul__(self, other: Any) -> Expr:
        return _binary("Mul", self, other)

    def __rmul__(self, other: Any) -> Expr:
        return _binary("Mul", other, self)

    def __truediv__(self, other: Any) -> Expr:
        return _binary("Mul", self, _reciprocal(other))

    def __rtruediv__(self, other: Any) -> Expr:
        return _binary("Mul", other, _reciprocal(self))

    def __pow__(self, other: Any) -> Expr:
        return _binary("Pow", self, other)

    def __rpow__(self, other: Any) -> Expr:
        return _binary("Pow", other, self)

    def __mod__(self, other: Any) -> Expr:
        return _binary("Mod", self, other)

    def __rmod__(self, other: Any) -> Expr:
        return _binary("Mod", other, self)

    @property
    def name(self) -> str:
        """The name of a symbol; empty for other formulas."""
        return self._node.name

    def diff(self, *by: Any) -> Expr:
        """The derivative: ``f.diff(x)``, ``f.diff(x, y)``, ``f.diff(x, 2)``.

        Abs, Min, Max and Piecewise are differentiated branch by branch; jumps are ignored.
        """
        if not by:
            raise TypeError("diff needs the symbol to differentiate by, such as f.diff(x)")
        node = self._node
        names: list[str] = []
        for b in by:
            if isinstance(b, int) and not isinstance(b, bool) and names and b >= 0:
                names.extend([names[-1]] * (b - 1)) if b else names.pop()
                continue
            symbol = sympify(b)._node
            if symbol.op != "Symbol":
                raise ExpressionError(f"{b} is no symbol; differentiate by x, y, z or a parameter")
            names.append(symbol.name)
        for name in names:
            node = _core.differentiate(node, name)
        return Expr(node)

    def expand(self) -> Expr:
        """Products and whole powers of sums multiplied out; parts that are undefined everywhere stay. Raises LimitError past the cap."""
        return Expr(_core.expand(self._node))

    def simplify(self) -> Expr:
        """The same function, smaller where that is sound; factored forms, even powers, and parts that are undefined everywhere stay."""
        return Expr(_core.simplify(self._node))

    def degree(self) -> int | None:
        """Total degree in x, y, z; None where the formula is not polynomial in them."""
        return _core.degree(self._node)

    def evaluate(
        self, X: npt.ArrayLike = 0.0, Y: npt.ArrayLike = 0.0, Z: npt.ArrayLike = 0.0, /, **params: Any
    ) -> npt.NDArray[np.float64]:
        """The values at points, in float64 on the host; nan where the formula is undefined (0/0 and 1/0 too), infinite where it is too large.

        Args:
            X, Y, Z: coordinates, any shapes that broadcast together. As keywords X, Y and Z are coordinates where the formula has no parameter of that name.
            params: a value for every other symbol; they broadcast as well.

        Returns:
            float64 of the broadcast shape.

        Raises:
            ArgumentError: a parameter is missing or unknown, or shapes do not broadcast.
        """
        names = _core.free_symbols(self._node)
        wanted = sorted(names - {"x", "y", "z"})
        coordinates = {
            axis: params.pop(axis.upper(), v) if axis.upper() not in names else v
            for axis, v in zip("xyz", (X, Y, Z), strict=True)
        }
        check_parameter_names(wanted, params)
        values = coordinates | params
        try:
            arrays = {k: np.asarray(v, dtype=np.float64) for k, v in values.items()}
            shape = np.broadcast_shapes(*(a.shape for a in arrays.values()))
        except (ValueError, TypeError, OverflowError) as error:
            raise ArgumentError(f"evaluate takes numbers and arrays that broadcast: {error}") from None
        full = {k: np.ascontiguousarray(np.broadcast_to(arrays[k], shape)) for k in names}
        return np.asarray(_core.evaluate(self._node, full, list(shape)))

    def _sympy_(self) -> Any:
        from implicitrt.sympy_exchange import to_sympy

        return to_sympy(self)


class Condition(_Tree):
    """A condition for `Piecewise`: a comparison, `Eq`, `Ne`, `And`, `Or`, `Not`."""

    __slots__ = ()

    def __init__(self, node: _core.Node) -> None:
        object.__setattr__(self, "_node", node)

    def __eq__(self, other: object) -> bool:
        return self._node == other._node if isinstance(other, Condition) else NotImplemented

    __hash__ = _Tree.__hash__

    def __bool__(self) -> bool:
        if self._node.op in ("True", "False"):
            return self._node.op == "True"
        raise TypeError(
            f"the condition {self} has no truth value; use it in Piecewise. A chained comparison "
            "a < b < c is written And(a < b, b < c)"
        )

    def __and__(self, other: Any) -> Condition:
        return And(self, other)

    __rand__ = __and__

    def __or__(self, other: Any) -> Condition:
        return Or(self, other)

    __ror__ = __or__

    def __invert__(self) -> Condition:
        return Not(self)

    def _sympy_(self) -> Any:
        from implicitrt.sympy_exchange import to_sympy

        return to_sympy(self)


ExprLike = Union[Expr, str, float, Any]


def _wrap(node: _core.Node) -> Any:
    return Condition(node) if node.is_condition else Expr(node)


def _tree(value: Any) -> _Tree:
    if isinstance(value, (bool, np.bool_)):
        return _wrap(_core.call("True" if value else "False", []))
    return value if isinstance(value, Condition) else sympify(value)


def _operand(value: Any) -> Expr | None:
    """`value` as the other side of an operator, or None where it should speak for itself."""
    if isinstance(value, Expr):
        return value
    if isinstance(value, Condition):
        raise TypeError("a condition cannot be used as a number; use Piecewise to give it values")
    if isinstance(value, (str, bytes, np.ndarray, list, tuple, dict, set, bool, np.bool_)):
        return None
    if isinstance(value, (numbers.Number, np.number)) or hasattr(value, "_sympy_") or _is_sympy(value):
        return sympify(value)
    return None


def _binary(op: str, a: Any, b: Any) -> Expr:
    left, right = _operand(a), _operand(b)
    if left is None or right is None:
        return NotImplemented
    return Expr(_core.call(op, [left._node, right._node]))


def _negated(value: Any) -> Any:
    operand = _operand(value)
    return value if operand is None else -operand


def _reciprocal(value: Any) -> Any:
    operand = _operand(value)
    return value if operand is None else _binary("Pow", operand, -1)


def _compare(op: str, a: Any, b: Any) -> Condition:
    left, right = _operand(a), _operand(b)
    if left is None or right is None:
        return NotImplemented
    return Condition(_core.call(op, [left._node, right._node]))


def _is_sympy(value: Any) -> bool:
    # Classes of undefined functions, sympy.Function("g"), have no module.
    return any((t.__module__ or "").split(".")[0] == "sympy" for t in type(value).__mro__)


def _part(node: _core.Node, index: Mapping[_core.Node, int]) -> tuple[str, Any]:
    """A node for pickles: its operator, and its ratio, its name or the numbers of its arguments."""
    if node.op == "Number":
        return node.op, node.ratio()
    return node.op, node.name if node.op == "Symbol" else tuple(index[a] for a in node.args)


def _from_parts(parts: list[tuple[str, Any]]) -> Any:
    """The tree of a pickle, by the constructors that built it."""
    nodes: list[_core.Node] = []
    for op, what in parts:
        if op == "Number":
            nodes.append(_core.rational(*what))
        elif op == "Symbol":
            nodes.append(_core.symbol(what))
        else:
            nodes.append(_core.call(op, [nodes[i] for i in what]))
    return _wrap(nodes[-1])


def check_parameter_names(wanted: list[str], given: Mapping[str, Any], way: str = "NAME=...") -> None:
    """Raises ArgumentError unless `given` has a value for each wanted parameter, and no other; `way`: how the call takes them."""
    import difflib

    for name in wanted:
        if name not in given:
            raise ArgumentError(
                f"the parameter '{name}' has no value; give it as {way.replace('NAME', name)} (the formula's "
                f"parameters: {', '.join(wanted)})"
            )
    for name in given:
        if name not in wanted:
            close = difflib.get_close_matches(str(name), wanted, 1)
            hint = f"; did you mean '{close[0]}'?" if close else ""
            have = ", ".join(wanted) if wanted else "none"
            raise ArgumentError(f"unknown parameter '{name}'{hint} (the formula has: {have})")


def parse(text: str) -> Expr:
    """The formula that a text is: ``parse("x^2 + y^2 = 1 - z^2")`` is left minus right side.

    ``^`` and ``**`` are powers, ``2x`` multiplies, ``xy`` is one symbol, ``E`` and ``pi`` are
    numbers. Raises ExpressionError that names the column, LimitError for monstrous input.
    """
    if not isinstance(text, str):
        raise ExpressionError(f"parse takes a string, not {type(text).__name__}; see sympify")
    node = _core.parse(_utf8(text))
    if node.is_condition:
        raise ExpressionError(
            f"'{text[:60]}' is a condition, not a formula; a surface is an equation with '=' or "
            "a Piecewise of conditions"
        )
    return Expr(node)


def _utf8(text: str) -> str:
    """The text, if it can be handed to the core, which half of a surrogate pair cannot."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ExpressionError(
            f"unknown character {text[error.start]!a} at column {error.start + 1}; names and signs are ASCII, but for − · ² ³ π √"
        ) from None
    return text


def sympify(value: Any) -> Expr:
    """Anything that is a formula as an `Expr`.

    Takes Expr, str (parsed), int, float (exactly), Fraction, Decimal, NumPy scalars, named surfaces, SymPy
    expressions and equations, and objects with ``_sympy_``. Raises ExpressionError for the rest.
    """
    if isinstance(value, Expr):
        return value
    if isinstance(value, str):
        return parse(value)
    if isinstance(value, (bool, np.bool_, Condition)):
        raise ExpressionError(f"{value!r} is a truth value, not a formula")
    if isinstance(value, (int, np.integer)):
        return Expr(_core.rational(operator.index(value), 1))
    if isinstance(value, (float, np.floating)):
        double = float(value)
        if double != value and not np.isnan(double):
            raise ExpressionError(
                f"{value!r} is no float64; numbers with more digits are given as Fraction, Decimal or Rational"
            )
        return Expr(_core.from_double(double))
    if isinstance(value, Decimal) and value.is_finite():
        value = _fraction(value)
    if isinstance(value, numbers.Rational):
        return Expr(_core.rational(int(value.numerator), int(value.denominator)))
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return sympify(value[()])
    if _is_sympy(value):
        from implicitrt.sympy_exchange import from_sympy

        return from_sympy(value)
    expr = getattr(value, "expr", None)
    if isinstance(expr, Expr):
        return expr
    if hasattr(value, "_sympy_"):
        from implicitrt.sympy_exchange import from_sympy

        return from_sympy(value._sympy_())
    raise ExpressionError(
        f"a {type(value).__name__} is not a formula; use a string, a number, an expression of "
        "implicitrt or SymPy, or a named surface"
    )


def symbols(names: str) -> Any:
    """Symbols by name, separated by blanks or commas: one, or a tuple of several.

    Raises ExpressionError for names that `parse` reads as something else: functions, `E`, `pi`.
    """
    parts = names.replace(",", " ").split() if isinstance(names, str) else []
    if not parts:
        raise ExpressionError("symbols takes at least one name, such as symbols('x y z')")
    made = tuple(Expr(symbol_node(p)) for p in parts)
    return made[0] if len(made) == 1 else made


def symbol_node(name: str) -> _core.Node:
    """The symbol of that name, which must parse back from str and repr."""
    node = _core.symbol(_utf8(name))
    try:
        if node.op == "Symbol" and _core.parse(name) == node:
            return node
    except ExpressionError:
        pass
    raise ExpressionError(f"'{name}' has a meaning of its own in formulas; choose another name for a symbol")


def Rational(p: Any, q: Any = 1) -> Expr:
    """The exact quotient of two integers, or of a decimal string such as "0.1". Raises LimitError past 65536 bits."""
    try:
        value = _fraction(p) / _fraction(q)
    except (ZeroDivisionError, TypeError, ValueError, OverflowError) as error:
        raise ExpressionError(f"Rational takes two integers, the second not zero, or a decimal string: {str(error)[:100]}") from None
    return Expr(_core.rational(value.numerator, value.denominator))


def _fraction(value: Any) -> Fraction:
    """`Fraction(value)`, but for exponents that would make a number beyond the cap: it could take all memory."""
    exponent: Any = 0
    if isinstance(value, Decimal):
        exponent = value.as_tuple().exponent if value.is_finite() else 0
    elif isinstance(value, str) and (written := re.search(r"[eE]([-+]?[\d_]+)\s*$", value)):
        exponent = int(written[1])
    if abs(exponent) > _core.NUMBER_BITS:
        raise LimitError(
            f"the number {str(value)[:40]} has the exponent {exponent}; the limit of numbers is {_core.NUMBER_BITS} bits"
        )
    return Fraction(operator.index(value) if hasattr(value, "__index__") else value)


def _function(name: str, meaning: str) -> Callable[..., Expr]:
    def build(*args: Any) -> Expr:
        return Expr(_core.call(name, [sympify(a)._node for a in args]))

    build.__name__ = build.__qualname__ = name
    build.__doc__ = meaning
    return build


sin = _function("sin", "Sine of an angle in radians.")
cos = _function("cos", "Cosine of an angle in radians.")
tan = _function("tan", "Tangent of an angle in radians; poles are never surface.")
asin = _function("asin", "Inverse sine, defined on [-1, 1].")
acos = _function("acos", "Inverse cosine, defined on [-1, 1].")
atan = _function("atan", "Inverse tangent.")
atan2 = _function("atan2", "The angle of the point (second argument, first argument).")
sinh = _function("sinh", "Hyperbolic sine.")
cosh = _function("cosh", "Hyperbolic cosine.")
tanh = _function("tanh", "Hyperbolic tangent.")
exp = _function("exp", "E to the power of the argument.")
log = _function("log", "Natural logarithm, defined for positive arguments.")
cbrt = _function("cbrt", "The real cube root, also of negative numbers.")
Abs = _function("Abs", "The absolute value.")
sign = _function("sign", "-1, 0 or 1.")
floor = _function("floor", "The largest integer not above the argument.")
ceiling = _function("ceiling", "The least integer not below the argument.")
Min = _function("Min", "The least of the arguments.")
Max = _function("Max", "The largest of the arguments.")
Mod = _function("Mod", "The remainder with the sign of the divisor.")


def sqrt(value: Any) -> Expr:
    """The square root, defined for arguments not below zero."""
    return _binary("Pow", sympify(value), Rational(1, 2))


def Piecewise(*branches: Any) -> Expr:
    """``Piecewise((value, condition), ...)``: the value of the first condition that holds."""
    args: list[_core.Node] = []
    for branch in branches:
        if not isinstance(branch, (tuple, list)) or len(branch) != 2:
            raise ExpressionError("Piecewise takes pairs (value, condition)")
        args.append(sympify(branch[0])._node)
        args.append(_condition(branch[1])._node)
    return Expr(_core.call("Piecewise", args))


def _condition(value: Any) -> Condition:
    if isinstance(value, Condition):
        return value
    if isinstance(value, (bool, np.bool_)):
        return Condition(_core.call("True" if value else "False", []))
    if _is_sympy(value):
        from implicitrt.sympy_exchange import condition_from_sympy

        return condition_from_sympy(value)
    raise ExpressionError(f"{value!r} is not a condition; use <, <=, >, >=, Eq, Ne, And, Or, Not or True")


def Eq(a: Any, b: Any) -> Condition:
    """The condition a = b."""
    return Condition(_core.call("Eq", [sympify(a)._node, sympify(b)._node]))


def Ne(a: Any, b: Any) -> Condition:
    """The condition a != b."""
    return Condition(_core.call("Ne", [sympify(a)._node, sympify(b)._node]))


def And(*conditions: Any) -> Condition:
    """All of the conditions."""
    return Condition(_core.call("And", [_condition(c)._node for c in conditions]))


def Or(*conditions: Any) -> Condition:
    """Any of the conditions."""
    return Condition(_core.call("Or", [_condition(c)._node for c in conditions]))


def Not(condition: Any) -> Condition:
    """The opposite of the condition."""
    return Condition(_core.call("Not", [_condition(condition)._node]))


x, y, z = symbols("x y z")
pi = Expr(_core.call("pi", []))
E = Expr(_core.call("E", []))
