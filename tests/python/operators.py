"""Every operator against MPFR: arguments, references, and pieces whose enclosures must contain them.

One kernel holds four operators: a Piecewise over z, which is the operator's number at every lane. So each combination of driver,
packet width, precision and algebra costs few builds, and all are judged by the same references.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import implicitrt as irt
from implicitrt import _core
from implicitrt.enclose import _above, _below, _enclose_request

Array = npt.NDArray[np.float64]

# Values stay within single precision for moderate arguments: these run in kernels without the code for infinities, too.
BOUNDED = (
    "-x", "x + y", "x - y", "x*y", "3*x", "2.3*x", "3*x - y", "2.3*x + y", "x + 0.1", "pi - x", "x^2", "x^3", "x^4", "x^5", "x^7", "x^8", "sqrt(x)", "cbrt(x)",
    "x^(3/2)", "x^(7/3)", "exp(x)", "sinh(x)", "cosh(x)", "tanh(x)", "sin(x)", "cos(x)", "asin(x)", "acos(x)", "atan(x)", "atan2(x, y)",
    "Abs(x)", "sign(x)", "floor(x)", "ceiling(x)", "Min(x, y)", "Max(x, y)", "Piecewise((x, x < y), (y^2, True))",
    "Piecewise((x, And(x <= y, y > 1)), (-y, Or(Eq(x, y), Not(x > 2))), (1/3, True))",
)  # fmt: skip
# Affine programs return these as ranges where nothing follows; times 3 shows their forms.
UNBOUNDED = (
    "3/x", "3*x/y", "3*x^-2", "3*x^-3", "3/sqrt(x)", "3*x^(-1/3)", "3*x^(-3/7)", "3*Abs(x)^y", "3*x^y", "3*log(x)", "3*tan(x)", "Mod(x, y)", "Mod(x, 1)",
)  # fmt: skip
OPERATORS = BOUNDED + UNBOUNDED
MODERATE = 16.0  # the largest argument of the kernels without infinities
GROUP = 4  # operators in one kernel: some compilers take minutes for fifty


def combined(formulas: tuple[str, ...]) -> irt.Expr:
    """One formula of x and y for each whole z."""
    cases = "".join(f"({f}, z < {2 * k + 1}/2), " for k, f in enumerate(formulas[:-1]))
    return irt.parse(f"Piecewise({cases}({formulas[-1]}, True))")


def special_values() -> Array:
    """Zeros, subnormal and extreme numbers, halves, ends of domains, poles and multiples of pi/2 from both sides."""
    single = [
        2.0**-149,
        2.0**-130,
        2.0**-126,
        2.0**-125,
        float(np.finfo(np.float32).max),
        2.0**24,
        2.0**127,
        88.72283,
        87.33655,
        103.97208,
    ]
    double = [
        2.0**-1074,
        2.0**-1040,
        2.0**-1022,
        1.7976931348623157e308,
        2.0**53,
        2.0**1000,
        709.782712893384,
        745.1332191019411,
    ]
    plain = [0.0, 0.1, 1 / 3, 0.5, 0.99, 1.0, 1.5, 2.0, 2.5, 3.0, 7.0, 8.0, 10.0, 27.0, 1e6 + 0.5]
    turns = [k * np.pi / 2 for k in (0.5, 1, 2, 3, 4, 5, 101, 1e5, 1e9)]
    around = []
    for v in [*turns, 0.5, 1.0, 2.0, 3.0]:
        f = np.float32(v)
        around += [float(np.nextafter(f, np.float32(s))) for s in (-np.inf, np.inf)]
        around += [float(f), float(np.nextafter(v, -np.inf)), float(np.nextafter(v, np.inf))]
    all_of = np.unique(np.array(single + double + plain + turns + around))
    return np.concatenate([all_of, -all_of])


def arguments(count: int, seed: int) -> Array:
    """(count, 2) finite doubles: pairs of special values, floats and doubles of all exponents, and moderate ones."""
    rng = np.random.default_rng(seed)
    special = special_values()
    n = min(count // 4, len(special) ** 2)
    pairs = rng.choice(len(special) ** 2, n, replace=False)
    first = np.stack([special[pairs // len(special)], special[pairs % len(special)]], axis=-1)
    kind = rng.random((count - n, 2))
    low, high = (
        np.where(kind < 0.3, -149, np.where(kind < 0.5, -1074, -20)),
        np.where(kind < 0.3, 127, np.where(kind < 0.5, 1023, 8)),
    )
    exponent = np.floor(rng.uniform(low, high + 1.0)).astype(np.int64)
    mantissa = rng.uniform(1, 2, kind.shape)
    short = (kind < 0.3) | (kind > 0.75)  # floats
    mantissa = np.where(short, np.floor(mantissa * 2**23) / 2**23, mantissa)
    value = np.ldexp(mantissa, exponent) * np.where(rng.random(kind.shape) < 0.5, -1, 1)
    with np.errstate(over="ignore"):
        value = np.where(short, value.astype(np.float32).astype(np.float64), value)
    out = np.concatenate([first, value])
    # Some exact relations that random pairs never have.
    some = rng.random(count) < 0.02
    out[some, 1] = out[some, 0] * rng.choice([1.0, -1.0, 0.5, 0.25], int(some.sum()))
    return out[rng.permutation(count)]


def references(points: Array) -> dict[str, Array]:
    """For each operator the doubles around its value at each point, (N, 2); nan where it has none."""
    at = np.column_stack([points, np.zeros(len(points))])
    parts = [at[i : i + 20_000] for i in range(0, len(at), 20_000)]
    with ThreadPoolExecutor() as pool:
        tasks = {f: [pool.submit(_core.values, irt.parse(f)._node, part) for part in parts] for f in OPERATORS}
        return {f: np.concatenate([t.result() for t in row]) for f, row in tasks.items()}


def pieces(points: Array, algebra: str, precision: str, seed: int) -> Array:
    """(N, 9): for each point boxes or affine forms that contain it: half of them as tight as can be, the others up to ten times as wide."""
    rng = np.random.default_rng(seed)
    shape = points.shape
    wide = np.minimum(np.abs(points), 1e300) * 10.0 ** rng.uniform(-8, 1, shape) * (rng.random(shape) < 0.5)
    with np.errstate(over="ignore", invalid="ignore"):
        if algebra == "ia":
            kind = rng.integers(0, 3, shape)  # the point is the lower end, the upper end, inside
            low = _below(points - wide * (kind != 0), precision)
            high = _above(points + wide * (kind != 1), precision)
            xy = np.stack([low, high, np.zeros(shape)], axis=-1)
        else:
            # The point at e = +1 or -1 of a form; what rounding its middle leaves over goes into the last term.
            e = rng.choice([-1.0, 1.0], (len(points), 1))
            slope = _below(wide, precision) * rng.choice([-1.0, 1.0], shape)
            aim = points - slope * e
            middle = _below(aim, precision)
            back = aim - points
            lost = np.abs((points - (aim - back)) + (-slope * e - back))  # of the subtraction (two-sum)
            rest = np.abs(aim - middle) + lost
            rest = np.where(rest > 0, np.nextafter(rest, np.inf), 0)
            fat = wide * (rng.random(shape) < 0.3)
            xy = np.stack(
                [middle, slope, _above(np.where(fat > 0, np.nextafter(rest + fat, np.inf), rest), precision)], axis=-1
            )
            endless = ~np.isfinite(xy).all(axis=-1)
            xy[endless] = (0, 0, np.inf)
    return np.concatenate([xy.reshape(len(points), 6), np.zeros((len(points), 3))], axis=1)


@dataclass
class Violation:
    """An enclosure that lacks its value."""

    formula: str
    point: tuple[float, float]
    piece: list[float]
    value: list[float]
    range: list[float]


def check(
    points: Array,
    truth: dict[str, Array],
    algebra: str,
    precision: str,
    device: str,
    rounding: str = "outward",
    thorough: bool = True,
) -> tuple[int, list[Violation]]:
    """How many enclosures were compared with values that exist, and (the first of) those that lack theirs.

    thorough: also in kernels without the code for infinities.
    """
    moderate = (np.abs(points) <= MODERATE).all(axis=1)
    compared, bad = 0, []
    everything = np.ones(len(points), dtype=bool)
    parts = (
        [(BOUNDED, moderate), (BOUNDED, ~moderate), (UNBOUNDED, everything)] if thorough else [(OPERATORS, everything)]
    )
    for table, some in parts:
        boxes = pieces(points[some], algebra, precision, len(points))
        for first in range(0, len(table), GROUP):
            formulas = table[first : first + GROUP]
            f = combined(formulas)
            request = _enclose_request(f, f, algebra, None, precision, rounding, device)
            for k, formula in enumerate(formulas):
                boxes[:, 6], boxes[:, 7] = k, k if algebra == "ia" else 0
                request["pieces"] = boxes
                n, wrong = _compare(
                    formula, points[some], truth[formula][some], boxes, _core.enclose_pieces(f._node, request)
                )
                compared += n
                bad += wrong
    return compared, bad


def _compare(formula: str, points: Array, known: Array, boxes: Array, found: Array) -> tuple[int, list[Violation]]:
    with np.errstate(invalid="ignore", over="ignore"):
        # Values that 4096 bits cannot tell (at jumps) prove nothing.
        told = (known[:, 0] == known[:, 1]) | (np.nextafter(known[:, 0], np.inf) == known[:, 1])
        inside = (found[:, 0] <= known[:, 0]) & (known[:, 1] <= found[:, 1])
    wrong = np.flatnonzero(told & ~inside)[:20]
    return int(told.sum()), [
        Violation(formula, tuple(points[i].tolist()), boxes[i].tolist(), known[i].tolist(), found[i].tolist())
        for i in wrong
    ]
