"""Expressions to SymPy and back. SymPy is imported only when one of its objects is at hand."""

from __future__ import annotations

from typing import Any

from implicitrt import _core
from implicitrt.errors import ExpressionError, LimitError
from implicitrt.expression import Condition, Expr, Rational, parse, symbol_node

# SymPy's classes by the names of our operators; the others are handled one by one.
_SAME = (
    "sin cos tan asin acos atan atan2 sinh cosh tanh exp log Abs sign floor ceiling Min Max Mod Add Mul Pow"
).split()
_OTHER_NAMES = {"Eq": "Equality", "Ne": "Unequality", "Lt": "StrictLessThan", "Le": "LessThan"}


def to_sympy(tree: Expr | Condition) -> Any:
    """The SymPy object with the same meaning over the reals."""
    import sympy

    done: dict[_core.Node, Any] = {}
    for node in _core.postorder(tree._node):
        try:
            done[node] = _one_to_sympy(sympy, node, [done[a] for a in node.args])
        except RecursionError:
            raise LimitError("the formula is nested too deeply for SymPy, which walks trees by recursion") from None
    return done[tree._node]


def _one_to_sympy(sympy: Any, node: _core.Node, args: list[Any]) -> Any:
    op = node.op
    if op == "Number":
        return sympy.Rational(*node.ratio())
    if op == "Symbol":
        return sympy.Symbol(node.name)
    if op in ("pi", "E"):
        return getattr(sympy, op)
    if op in ("True", "False"):
        return sympy.true if op == "True" else sympy.false
    if op == "cbrt":
        return sympy.real_root(args[0], 3)
    if op == "Piecewise":
        return sympy.Piecewise(*zip(args[::2], args[1::2], strict=True))
    return getattr(sympy, _OTHER_NAMES.get(op, op))(*args)


def from_sympy(value: Any) -> Expr:
    """The formula that a SymPy expression or equation (left minus right side) is."""
    import sympy

    if isinstance(value, sympy.Equality):
        return from_sympy(value.lhs) - from_sympy(value.rhs)
    if isinstance(value, sympy.logic.boolalg.Boolean) and not isinstance(value, sympy.Symbol):
        raise ExpressionError(f"{value} is a condition, not a formula; use it inside Piecewise")
    if not isinstance(value, sympy.Expr):
        raise ExpressionError(f"SymPy's {type(value).__name__} is not a formula")
    return Expr(_node(sympy, value))


def condition_from_sympy(value: Any) -> Condition:
    """The condition that a SymPy relation or Boolean is."""
    import sympy

    return Condition(_node(sympy, value))


def _node(sympy: Any, root: Any) -> _core.Node:
    done: dict[Any, _core.Node] = {}
    stack = [(root, False)]
    while stack:
        value, ready = stack.pop()
        if value in done:
            continue
        children = _children(sympy, value)
        if not ready and children:
            stack.append((value, True))
            stack.extend((c, False) for c in children)
            continue
        done[value] = _one_from_sympy(sympy, value, [done[c] for c in children])
    return done[root]


def _children(sympy: Any, value: Any) -> list[Any]:
    root = _real_root(sympy, value)
    if root is not None:
        return [root]
    if isinstance(value, sympy.Piecewise):
        return [part for pair in value.args for part in pair.args]
    return list(value.args)


def _real_root(sympy: Any, value: Any) -> Any:
    """The base b of `real_root(b, 3)`, else None: Abs(b)**(1/3)*sign(b), for complex symbols as the branch for real b."""
    if isinstance(value, sympy.Piecewise):
        first = value.args[0]
        base = _real_root(sympy, first.expr)
        return base if base is not None and first.cond == sympy.Eq(sympy.im(base), 0) else None
    if not isinstance(value, sympy.Mul) or len(value.args) != 2:
        return None
    sign_part, power = sorted(value.args, key=lambda a: not isinstance(a, sympy.sign))
    if (
        isinstance(sign_part, sympy.sign)
        and isinstance(power, sympy.Pow)
        and isinstance(power.base, sympy.Abs)
        and power.base.args[0] == sign_part.args[0]
        and power.exp == sympy.Rational(1, 3)
    ):
        return sign_part.args[0]
    return None


def _one_from_sympy(sympy: Any, value: Any, args: list[_core.Node]) -> _core.Node:
    if _real_root(sympy, value) is not None:
        return _core.call("cbrt", args)
    if isinstance(value, sympy.Rational):
        return _core.rational(int(value.p), int(value.q))
    if isinstance(value, sympy.Float):
        exact = sympy.Rational(value)
        return _core.rational(int(exact.p), int(exact.q))
    if isinstance(value, sympy.Symbol):
        return symbol_node(value.name)
    if value in (sympy.pi, sympy.E):
        return _core.call(str(value), [])
    if value is sympy.GoldenRatio:
        return parse("(1 + sqrt(5))/2")._node
    if value in (sympy.true, sympy.false):
        return _core.call(str(value), [])
    if isinstance(value, sympy.Piecewise):
        return _core.call("Piecewise", args)
    if isinstance(value, (sympy.StrictGreaterThan, sympy.GreaterThan)):
        return _core.call("Lt" if isinstance(value, sympy.StrictGreaterThan) else "Le", args[::-1])
    for name in ("And", "Or", "Not", *_SAME):
        if isinstance(value, getattr(sympy, name)):
            return _core.call(name, args)
    for ours, theirs in _OTHER_NAMES.items():
        if isinstance(value, getattr(sympy, theirs)):
            return _core.call(ours, args)
    extra = {"sec": "cos", "csc": "sin", "cot": "tan"}.get(type(value).__name__)
    if extra:
        minus_one = Rational(-1)._node
        return _core.call("Pow", [_core.call(extra, args), minus_one])
    raise ExpressionError(
        f"SymPy's {type(value).__name__} ({str(value)[:60]}) has no meaning here; formulas have real "
        "numbers, symbols, + - * / **, elementary functions, Abs, Min, Max, Mod and Piecewise"
    )
