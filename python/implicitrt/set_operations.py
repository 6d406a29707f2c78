"""R-functions (S4 section 2, after Rvachev): union, intersection and difference of solids as one formula, and the way back.

S4's convention: a solid is where its formula is positive, so that a ball is ``1 - x**2 - y**2 - z**2``. Unlike Min and Max,
R-functions are smooth but where both arguments vanish.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from implicitrt import _core
from implicitrt.errors import MethodError
from implicitrt.expression import Expr, ExprLike, Max, Min, Rational, sqrt, sympify

__all__ = ["r_intersection", "r_subtraction", "r_union"]

_DEPTH = 100  # of set operations inside one another; the limit of leaves is below it
_OTHERS = '"contract", "raa" and "ia" draw every formula'


def r_union(a: ExprLike, b: ExprLike) -> Expr:
    """The solid of points in a or in b: a + b + sqrt(a**2 + b**2); solids are where formulas are positive (S4 section 2)."""
    f, g = sympify(a), sympify(b)
    return f + g + sqrt(f**2 + g**2)


def r_intersection(a: ExprLike, b: ExprLike) -> Expr:
    """The solid of points in a and in b: a + b - sqrt(a**2 + b**2); solids are where formulas are positive (S4 section 2)."""
    f, g = sympify(a), sympify(b)
    return f + g - sqrt(f**2 + g**2)


def r_subtraction(a: ExprLike, b: ExprLike) -> Expr:
    """The solid of points in a and not in b: a - b - sqrt(a**2 + b**2); solids are where formulas are positive (S4 section 2)."""
    f, g = sympify(a), sympify(b)
    return f - g - sqrt(f**2 + g**2)


def closed_polynomial(f: Expr, isovalue: float | None) -> Expr:
    """f, for a method that knows polynomials up to degree 4 only.

    Raises:
        MethodError: it is none, or of a higher degree.
    """
    degree = f.degree()
    if degree is not None and degree <= _core.CLOSED_DEGREE:
        return f
    if degree is None:
        raise MethodError(
            f'analytic knows polynomials in x, y, z up to degree {_core.CLOSED_DEGREE}; this is none; "csg-analytic" knows Min, Max '
            f"and R-functions of such, {_OTHERS}"
        )
    raise MethodError(
        f"analytic knows polynomials in x, y, z up to degree {_core.CLOSED_DEGREE}; this one's degree is {degree}; "
        f'"frustum-lr" draws polynomials up to degree 32, {_OTHERS}'
    )


def set_form(f: Expr, isovalue: float | None) -> Expr:
    """The tree of Min and Max of polynomials up to degree 4 that has the zeros and the signs of f.

    An R-union is positive where one of its arguments is, and zero where Max of them is; an R-intersection likewise with Min.

    Raises:
        MethodError: f is no such tree; the message says what was found.
    """
    if isovalue is not None:
        raise MethodError(
            "csg-analytic draws solids, whose surface is f = 0, and no other isovalue; "
            f"subtract it from the leaves of the formula; {_OTHERS}"
        )
    return _set_form(f, {}, 0)


def _set_form(f: Expr, known: dict[Expr, Expr], depth: int) -> Expr:
    if f not in known:
        known[f] = _resolved(f, known, depth)
    return known[f]


def _resolved(f: Expr, known: dict[Expr, Expr], depth: int) -> Expr:
    degree, op = f.degree(), f._node.op
    if degree is not None:
        if degree <= _core.CLOSED_DEGREE:
            return f
        raise MethodError(
            f"csg-analytic knows polynomials up to degree {_core.CLOSED_DEGREE} under set operations; one here has degree {degree}; {_OTHERS}"
        )
    if depth == _DEPTH:
        raise MethodError(f"csg-analytic knows {_DEPTH} set operations inside one another, not more; {_OTHERS}")

    def inner(g: Expr) -> Expr:
        return _set_form(g, known, depth + 1)

    if op in ("Min", "Max"):
        return f.func(*map(inner, f.args))
    if op == "Mul" and _factor(f)[1] != f:
        k, rest = _factor(f)
        return inner(rest) if k > 0 else -inner(rest)
    if op == "Add":
        for term in f.args:
            parts = _r_function(f, term)
            if parts:
                choice, a, b = parts
                return choice(inner(a), inner(b))
        # Min(a, b) + c is Min(a + c, b + c); with a number k in front of Min, k a and k b; a negative one makes it Max.
        odd = [t for t in f.args if t.degree() is None]
        if len(odd) == 1:
            k, rest = _factor(odd[0])
            if rest._node.op in ("Min", "Max"):
                others = _without(f, odd[0])
                choice = Max if (rest._node.op == "Max") == (k > 0) else Min
                return choice(*(inner(k * a + others) for a in rest.args))
    raise MethodError(
        f"csg-analytic knows Min, Max and R-functions (irt.r_union, ...) of polynomials up to degree {_core.CLOSED_DEGREE}, not {op}; {_OTHERS}"
    )


def _factor(term: Expr) -> tuple[Fraction, Expr]:
    """The number in front of a term, and the rest."""
    if term._node.op == "Mul" and len(term.args) == 2 and term.args[0]._node.op == "Number":
        return Fraction(*term.args[0]._node.ratio()), term.args[1]
    return Fraction(1), term


def _without(f: Expr, term: Expr) -> Expr:
    """The sum f less one of its terms."""
    rest = [t for t in f.args if t != term]
    return f.func(*rest) if len(rest) > 1 else rest[0]


def _r_function(f: Expr, term: Expr) -> tuple[Callable[..., Expr], Expr, Expr] | None:
    """Max or Min, and a and b, where the sum f is a + b + `term` and `term` is sqrt(a**2 + b**2) or less that."""
    k, root = _factor(term)
    if abs(k) != 1 or root._node.op != "Pow" or root.args[1] != Rational(1, 2) or root.args[0]._node.op != "Add":
        return None
    squares = [_square_root(s) for s in root.args[0].args]
    if len(squares) != 2 or squares[0] is None or squares[1] is None:
        return None
    rest = _without(f, term)
    for a in (squares[0], -squares[0]):
        for b in (squares[1], -squares[1]):
            if a + b == rest:
                return (Max if k > 0 else Min), a, b
    return None


def _square_root(s: Expr) -> Expr | None:
    """What s is the square of, but for the sign, if that shows."""
    op = s._node.op
    if op == "Number":
        p, q = s._node.ratio()
        a, b = math.isqrt(max(p, 0)), math.isqrt(q)
        return Rational(a, b) if p >= 0 and a * a == p and b * b == q else None
    if op == "Pow" and s.args[1]._node.op == "Number":
        p, q = s.args[1]._node.ratio()
        return s.args[0] ** (p // 2) if q == 1 and p > 0 and p % 2 == 0 else None
    if op == "Mul":
        result = Rational(1)
        for part in s.args:
            root = _square_root(part)
            if root is None:
                return None
            result = result * root
        return result
    return None
