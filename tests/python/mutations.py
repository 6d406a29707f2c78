"""Kernels with their builtins at the bounds of OpenCL, with one pad made smaller, and arguments that notice it.

A pad is a constant that covers rounding. `perturbed` copies the kernels so that every builtin and every division errs by all that
OpenCL permits, upwards or downwards, and loses subnormal results; `pads` finds the constants; `Judge` makes one smaller and looks for a
value outside its enclosure. What is looked at is g(x, y) - z, where z is chosen so that nearly all of g cancels: the pads of the
subtraction and of the result are then tiny, and what is left over is what g itself was padded by.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

import implicitrt as irt
from implicitrt import _core
from implicitrt.enclose import _above, _below, _enclose_request

Array = npt.NDArray[np.float64]
WIDTH = 4  # narrow packets compile fast
LARGEST = float(np.finfo(np.float32).max)

# OpenCL's bounds in single precision, in ulp.
BOUNDS = {
    "sqrt": 3, "cbrt": 2, "exp": 3, "log": 3, "sin": 4, "cos": 4, "tan": 5, "asin": 4, "acos": 4, "atan": 5, "sinh": 4, "cosh": 4, "tanh": 5,
}  # fmt: skip
BOUNDS_OF_TWO = {"atan2": 6, "quotient": 2.5}

# y, a double that is right, moved by n ulp and rounded so that no more than that comes out.
MOVED = f"""
static inline F irt_moved(double{WIDTH} y, const double n) {{
  // The ulp below powers of two, which the value may have been rounded to.
  const double{WIDTH} size = fabs(y), unit = fmax(as_double{WIDTH}(as_long{WIDTH}(size * (1 - 0x1p-52)) & (long{WIDTH})0x7ff0000000000000) * 0x1p-23, (double{WIDTH})0x1p-149);
#if IRT_UP
  const F moved = convert_float{WIDTH}_rtn(y + n * unit);
#else
  const F moved = convert_float{WIDTH}_rtp(y - n * unit);
#endif
  const F kept = SELECT(EQ(convert_float{WIDTH}(y), (F)0) | ~LT(convert_float{WIDTH}(size), INF), convert_float{WIDTH}(y), moved);
  return SELECT(LT(fabs(kept), (F)TINY), (F)0, kept);
}}
static inline F irt_quotient(F a, F b) {{ return irt_moved(convert_double{WIDTH}(a) / convert_double{WIDTH}(b), {BOUNDS_OF_TWO["quotient"]}); }}
static inline F irt_atan2(F y, F x) {{ return irt_moved(atan2(convert_double{WIDTH}(y), convert_double{WIDTH}(x)), {BOUNDS_OF_TWO["atan2"]}.0); }}
#undef atan2
#define atan2(y, x) irt_atan2(y, x)
"""
# Drivers define builtins as macros of their own, so each is called from a function before its name is taken.
ONE = "static inline F irt_{0}(F v) {{ return irt_moved({0}(convert_double{2}(v)), {1}.0); }}\n#undef {0}\n#define {0}(v) irt_{0}(v)\n"

# The last two steps of g - z, without the pads that could cover for those of g.
SHARP = f"""
static inline RA ra_sub(RA a, RA b) {{
  const F x = a.x - b.x, y = a.y - b.y;
  const F bx = a.x - x, by = a.y - y;  // what each sum loses, exactly (two-sum)
  const F off_x = (a.x - (x + bx)) - (b.x - bx), off_y = (a.y - (y + by)) - (b.y - by);
  const double{WIDTH} off = convert_double{WIDTH}(fabs(off_x)) + convert_double{WIDTH}(fabs(off_y));
  return ra(x, y, convert_float{WIDTH}_rtp(convert_double{WIDTH}(a.z) + convert_double{WIDTH}(b.z) + off * (1 + 0x1p-50)));
}}
static inline IA ra_range(RA a) {{
  const double{WIDTH} x = convert_double{WIDTH}(a.x), size = fabs(convert_double{WIDTH}(a.y)) + convert_double{WIDTH}(a.z), r = size + 0x1p-50 * (size + fabs(x));
  return ia(NAN_TO(convert_float{WIDTH}_rtn(x - r), -INF), NAN_TO(convert_float{WIDTH}_rtp(x + r), INF));
}}
"""


# ---- kernel text


def _code(text: str) -> str:
    """Without comments."""
    return re.sub(r"//[^\n]*", "", text)


def _closing(text: str, at: int) -> int:
    """Where the parenthesis that opens at `at` closes."""
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] == "(") - (text[i] == ")")
        if depth == 0:
            return i
    raise ValueError(text[at : at + 80])


def _opening(text: str, at: int) -> int:
    depth = 0
    for i in range(at, -1, -1):
        depth += (text[i] == ")") - (text[i] == "(")
        if depth == 0:
            return i
    raise ValueError(text[max(0, at - 80) : at])


def _enclosing(text: str, at: int) -> str:
    """The line up to the parenthesis that is open at `at`."""
    depth = 1
    while depth:
        at -= 1
        depth += (text[at] == ")") - (text[at] == "(")
    return text[text.rfind("\n", 0, at) + 1 : at]


def _before(text: str, at: int) -> tuple[int, int]:
    """The operand that ends before `at`: a name, a number, a call, something in parentheses."""
    end = len(text[:at].rstrip())
    start = end
    while start and (text[start - 1] == ")" or re.match(r"[\w.]", text[start - 1])):
        start = _opening(text, start - 1) if text[start - 1] == ")" else start - 1
    return start, end


def _after(text: str, at: int) -> int:
    """Where the operand that begins at `at` ends."""
    while text[at] in " -" or re.match(r"\((?:F|real|I)\)", text[at:]):
        at += 1 if text[at] in " -" else text.index(")", at) - at + 1
    while at < len(text) and (text[at] == "(" or re.match(r"[\w.]", text[at])):
        at = _closing(text, at) + 1 if text[at] == "(" else at + 1
    return at


def with_quotients(text: str) -> str:
    """Divisions of packets become calls."""
    at = 0
    while (at := text.find(" / ", at)) >= 0:
        start, end = _before(text, at)
        stop = _after(text, at + 3)
        if text[at + 3 : stop] in ("ULP", "MODEST"):
            at += 3
            continue
        text = f"{text[:start]}irt_quotient((F)({text[start:end]}), (F)({text[at + 3 : stop]})){text[stop:]}"
    return text


def _as_tested(name: str, code: str, up: bool, sharp: bool) -> str:
    """A file with builtins at their bounds, from its text without comments."""
    if name == "packet.cl":
        return (
            code + f"\n#define IRT_UP {int(up)}\n" + MOVED + "".join(ONE.format(f, n, WIDTH) for f, n in BOUNDS.items())
        )
    if name == "affine.cl" and sharp:
        for function in ("RA ra_sub", "IA ra_range"):
            code = code.replace(f"static inline {function}(", f"static inline {function}_padded(")
        return code + SHARP
    return with_quotients(code) if name.startswith(("interval_", "affine_")) else code


def perturbed(kernels: Path, target: Path, up: bool, sharp: bool) -> None:
    """A copy of the kernels whose builtins err by all that is permitted, in one direction."""
    shutil.copytree(kernels, target)
    for file in target.glob("*.cl"):
        file.write_text(_as_tested(file.name, _code(file.read_text()), up, sharp))


@dataclass(frozen=True)
class Pad:
    """A constant that pads: text[start:end] of a file, and the function or macro in which it stands."""

    file: str
    start: int
    end: int
    text: str
    function: str

    def mutated(self, code: str, share: float) -> str:
        return f"{code[: self.start]}((real){share!r} * ({self.text})){code[self.end :]}"


# Calls with an argument that pads, and which.
PADDING = {"LOWER": (1,), "UPPER": (1,), "IA_OUT": (2,), "ra_smooth": (6,)}
HEAD = re.compile(
    r"^(?:static (?:inline )?\w+|__attribute__\(\(noinline\)\) void|#define) (\w+)(?:\([^)]*\))?", re.MULTILINE
)


def _arguments(text: str, at: int) -> list[tuple[int, int]]:
    """Where the arguments stand of a call whose parenthesis opens at `at`."""
    stop, depth, start, found = _closing(text, at), 0, at + 1, []
    for i in range(at + 1, stop + 1):
        if i == stop or (text[i] == "," and depth == 0):
            found.append((start + len(text[start:i]) - len(text[start:i].lstrip()), i))
            start = i + 1
        depth += (text[i] == "(") - (text[i] == ")")
    return found


def pads(kernels: Path, name: str) -> list[Pad]:
    """Every pad of a file."""
    code = _code((kernels / name).read_text())
    heads = [m.span() for m in HEAD.finditer(code)]
    spans = set()
    for call in re.finditer(rf"\b({'|'.join(PADDING)})\(", code):
        if not any(a <= call.start() < b for a, b in heads):
            arguments = _arguments(code, call.end() - 1)
            spans.update(arguments[k] for k in PADDING[call[1]])
    for product in re.finditer(r" \* ULP\b", code):
        spans.add(_before(code, product.start()))
    for plain in re.finditer(r"(?<=\(F\))(?:ULP|TINY)\b|\bR\(1\.2\)|\bPAD_SLACK(?=\))", code):
        start, end = plain.span()
        if plain[0] != "TINY" or code[:start].endswith("+ (F)") or _enclosing(code, start).endswith("fma"):
            spans.add((start, end))
    found = []
    for start, end in sorted(spans):
        function = [m[1] for m in HEAD.finditer(code, 0, start)][-1]
        if code[start:end] == "R(0.0)":
            continue
        # What LOWER and UPPER multiply by is their argument; WAVE_REACH and what it is compared with are no pads.
        if (function in ("LOWER", "UPPER") and "PAD_SLACK)" in code[start:end]) or function == "WAVE_REACH":
            continue
        found.append(Pad(name, start, end, code[start:end], function))
    return found


def is_operator(name: str) -> bool:
    """Whether a kernel file has operators of f; the pads of the others are in contracts.py."""
    return name in ("packet.cl", "interval.cl", "affine.cl", "polynomial.cl") or name.startswith(
        ("interval_", "affine_")
    )


def all_pads(kernels: Path) -> list[Pad]:
    """Every pad of the operators."""
    names = sorted(f.name for f in kernels.glob("*.cl") if is_operator(f.name))
    return [pad for name in names for pad in pads(kernels, name)]


# ---- arguments


def _short(v: Array, bits: int = 11) -> Array:
    """Rounded to so many bits: sums of them are exact."""
    mantissa, exponent = np.frexp(v)
    return np.asarray(np.ldexp(np.round(mantissa * 2.0**bits) / 2.0**bits, exponent))


def _single(v: Array) -> Array:
    with np.errstate(over="ignore"):
        return v.astype(np.float32).astype(np.float64)


def _ranges(f: irt.Expr, pieces: Array, algebra: str, device: str) -> Array:
    request = _enclose_request(f, f, algebra, None, "single", "outward", device)
    request["pieces"] = np.ascontiguousarray(pieces)
    return np.asarray(_core.enclose_pieces(f._node, request))


def _middles(rng: np.random.Generator, shape: tuple[int, int], kind: str) -> Array:
    """Floats of moderate size, or of all exponents."""
    moderate = np.where(rng.random(shape) < 0.7, rng.uniform(-2, 2, shape), rng.uniform(-12, 4, shape))
    exponent = rng.uniform(-148, 127.9, shape) if kind in ("wild", "tiny") else moderate
    sign = rng.choice([-1, 1], shape)
    middle = _single(sign * 2.0**exponent)
    whole = rng.random((len(middle), 1)) < 0.1  # powers of two, whose ulp is largest
    middle = np.where(whole, sign * 2.0 ** np.rint(exponent), middle)
    near_one = _single(sign * (1 - 2.0 ** rng.uniform(-20, -1, shape)))  # where domains end
    return np.asarray(np.where(rng.random(shape) < 0.1, near_one, middle))


def _radii(rng: np.random.Generator, middle: Array, zero: float) -> Array:
    """From 2^-30 to 2^12 of the middles, some zero, of few digits so that ends are exact."""
    shape = middle.shape
    size = np.where(rng.random(shape) < 0.7, rng.uniform(-30, 0.5, shape), rng.uniform(-2, 12, shape))
    radii = np.minimum(_single(_short(np.abs(middle) * 2.0**size)), 2.0**126)
    return np.asarray(np.where(rng.random(shape) < zero, 0, radii))


class Case:
    """Pieces of f, and exact values in them. Which f and which arguments depends on the kind:

    plain, wild: g - z, arguments of moderate size or of all exponents    many: plain, twenty times as many
    tiny: g z, where z makes small values large    bare: g    turns: intervals with an extreme of a wave near one end
    sums: radii that are sums of parts as large as their middles and as rounding, next to zero
    """

    def __init__(self, formula: str, algebra: str, kind: str, device: str, count: int) -> None:
        self.algebra, self.device = algebra, device
        self.f = irt.parse({"tiny": f"({formula})*z", "bare": formula}.get(kind, f"{formula} - z"))
        rng, count = np.random.default_rng(1), count * (20 if kind == "many" else 1)
        shape = (count, 2)
        middle = _middles(rng, shape, kind)
        if kind == "turns":
            points = np.round(2.0 ** rng.uniform(14, 18, shape)) * (np.pi / 2)
            near, far = (10.0 ** rng.uniform(-3, -1, shape) for _ in range(2))
            low, high = _below(points - near, "single"), _above(points + far, "single")
            pieces = np.stack([low, high, 0 * low], axis=-1)
        elif algebra == "ia":
            radius, side = _radii(rng, middle, 0.3), rng.integers(-1, 2, shape)
            low, high = (np.clip(_single(middle + r), -LARGEST, LARGEST) for r in (-radius, radius))
            points = np.where(side < 0, low, np.where(side > 0, high, middle))
            pieces = np.stack([low, high, 0 * low], axis=-1)
        else:
            slope, rest = _radii(rng, middle, 0.3) * rng.choice([-1, 1], shape), _radii(rng, middle, 0.6)
            from_zero = np.minimum(_single(np.abs(slope) + rest), LARGEST) * np.sign(middle)  # one end is near zero
            which = rng.random(shape) * (slope != 0)
            middle = np.where(which > 0.9, 0, np.where(which > 0.7, from_zero, middle))
            if kind == "sums":
                slope = rng.choice([-1, 1], shape) * _short(rng.uniform(0.7, 1, shape))
                rest = _short(2.0 ** rng.uniform(-26, -22, shape))
                middle = rng.choice([-1, 1], shape) * _single(rng.uniform(1.01, 1.6, shape))
            e, u = (
                np.where(rng.random(s) < 0.75, rng.choice([-1, 1], s), rng.integers(-8, 9, s) / 8)
                for s in ((count, 1), shape)
            )
            points = middle + slope * e + rest * u
            pieces = np.stack([middle, slope, rest], axis=-1)
        pieces = np.concatenate([pieces, np.zeros((count, 1, 3))], axis=1)
        found = _ranges(irt.parse(f"{formula} - z"), pieces.reshape(-1, 9), algebra, device)
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            # z is near an end of g, or (forms) near the middle and follows g along e, too.
            z = np.where(rng.random(count) < 0.5, found[:, 0], found[:, 1])
            follows = (rng.random(count) < 0.6) & (kind in ("plain", "wild", "many"))
            if algebra == "raa":
                z = np.where(follows | (rng.random(count) < 0.4), 0.5 * found[:, 0] + 0.5 * found[:, 1], z)
            if kind == "tiny":
                size = np.clip(-np.floor(np.log2(np.abs(found).max(axis=1))), -20, 119)
                z = np.where(np.isfinite(size), 2.0**size, 1)
            at = z = _usable(_single(z))
            if algebra == "ia":
                pieces[:, 2, 0] = pieces[:, 2, 1] = z
            else:
                steep = [irt.parse(formula).diff(v).evaluate(*middle.T, 0.0) for v in (irt.x, irt.y)]
                along = np.where(follows, _usable(_short(steep[0] * slope[:, 0] + steep[1] * slope[:, 1])), 0)
                along = np.where(np.abs(along) < np.abs(z) * 2.0**-28, 0, along)
                pieces[:, 2, 0], pieces[:, 2, 1] = z, along
                at = z + along * e[:, 0]
                exact = (np.abs(along) <= np.abs(z) * 2.0**20) | (z == 0)
                pieces, points, at = pieces[exact], points[exact], at[exact]
        self.points = np.column_stack([points, at])
        self.pieces = pieces.reshape(-1, 9)

    @cached_property
    def truth(self) -> Array:
        return np.asarray(_core.values(self.f._node, self.points))

    def lost(self) -> int:
        """How many values lie outside their enclosures."""
        found, known = _ranges(self.f, self.pieces, self.algebra, self.device), self.truth
        with np.errstate(invalid="ignore", over="ignore"):
            told = np.isfinite(known).all(axis=1) & (known[:, 1] <= np.nextafter(known[:, 0], np.inf))
            inside = (found[:, 0] <= known[:, 0]) & (known[:, 1] <= found[:, 1])
        return int((told & ~inside).sum())


def _usable(v: Array) -> Array:
    """Values that a coordinate may have."""
    return np.asarray(np.where(np.isfinite(v) & (np.abs(v) < 2.0**120) & (np.abs(v) > 2.0**-125), v, 0.0))


Look = tuple[str, str, str]  # formula, algebra, kind of arguments

SMOOTH = ("1/x", "log(x)", "asin(x)", "sqrt(x)", "exp(x)", "sin(x)")
POLYNOMIAL = ("x^7 - 3*x^6 + 2*x^5 - x/3", "32*x^6 - 48*x^4 + 18*x^2 - 1")
# What looks at the pads of a function; the others are called as their formula is.
FORMULAS = {
    "LOWER": ("x + y", "x*y"), "UPPER": ("x + y", "x*y"), "IA_OUT": ("x + y",), "ia_add": ("x + y",), "ia_sub": ("x - y",),
    "ia_mul": ("x*y",), "ia_mul_nonnegative": ("Abs(x)*Abs(y)", "exp(x)*y^2"), "ia_sqr": ("x^2",), "ia_scale": ("3*x", "2.3*x"),
    "ia_shift": ("x + 0.1", "pi - x"), "IA_POWER_ODD": ("x^3", "x^5", "x^7"), "ia_power_even": ("x^4", "x^6", "x^8"),
    "ia_recip": ("1/x",), "ia_div": ("x/y",), "ia_log_of_base": ("x^(3/2)", "x^y"), "ia_wave": ("sin(x)", "cos(x)"),
    "TURNS_ERROR": ("sin(x)", "cos(x)"), "ia_atan2": ("atan2(x, y)",), "taylor_form": POLYNOMIAL,
    "RA_ROUNDED": ("x + y", "x - y"), "ra_mul": ("x*y",), "ra_sqr": ("x^2",), "ra_scale": ("Min(3*x, 100)", "Min(2.3*x, 100)", "Min(1e-20*x, 100)"),
    "ra_scale_add": ("2.3*x + y", "3*x - y", "1e-20*x + y"),
    "ra_shift": ("Min(x + 1/3, 100)", "x + 0.1"), "ra_range": ("x",), "ra_from_range": ("Min(x, y)",), "RA_MOST": ("x^15", "x^31"),
    "ra_least": ("x^22", "x^40"), "ra_power": ("x^5", "x^6", "x^7", "x^8"), "ra_recip": ("1/x",), "ra_abs": ("Abs(x)",), "ra_pow_constant": ("x^(3/2)", "x^(7/3)"),
    "ra_smooth": SMOOTH, "ra_wave": ("sin(x)", "cos(x)"), "ra_atan2": ("atan2(x, y)",),
}  # fmt: skip
KINDS = {"RA_MOST": ("many",), "ra_least": ("plain", "sums"), "TURNS_ERROR": ("turns",), "ra_range": ("bare",)}


def looks_at(pad: Pad) -> list[Look]:
    """What may notice a pad, likeliest first."""
    affine = pad.function.lower().startswith("ra_") or pad.function == "taylor_form"
    kinds = KINDS.get(pad.function, ("tiny", "wild", "plain") if pad.text == "TINY" else ("plain", "wild"))
    formulas = FORMULAS.get(pad.function, (f"{pad.function[3:]}(x)",))
    return [(formula, "raa" if affine else "ia", kind) for formula in formulas for kind in kinds]


class Judge:
    """Looks for values that changed kernels lose."""

    def __init__(self, kernels: Path, folder: Path, driver: str, count: int = 4000) -> None:
        self.kernels, self.device, self.count = kernels, f"{driver}:{WIDTH}", count
        self.copies = {(up, sharp): folder / f"{up}{sharp}" for up in (True, False) for sharp in (True, False)}
        for key, copy in self.copies.items():
            perturbed(kernels, copy, *key)
        self.cases: dict[tuple[Path, Look], Case] = {}

    def _case(self, copy: Path, look: Look) -> Case:
        """Made by unchanged kernels, in which it loses nothing."""
        if (copy, look) not in self.cases:
            _core.set_kernel_directory(str(copy))
            case = self.cases[copy, look] = Case(*look, self.device, self.count)
            if lost := case.lost():
                raise AssertionError(f"{look}: {lost} values are outside though no pad is smaller")
        return self.cases[copy, look]

    def lost(self, pad: Pad, share: float, looks: Iterable[Look]) -> Look | None:
        """The first that loses a value where the pad is so much of itself."""
        code = pad.mutated(_code((self.kernels / pad.file).read_text()), share)
        for look in looks:
            for (up, sharp), copy in self.copies.items():
                if sharp == (pad.function == "ra_range"):  # which sharp kernels do without
                    continue
                file = copy / pad.file
                unchanged = file.read_text()
                try:
                    case = self._case(copy, look)
                    file.write_text(_as_tested(pad.file, code, up, sharp))
                    _core.set_kernel_directory(str(copy))
                    if case.lost():
                        return look
                finally:
                    file.write_text(unchanged)
                    _core.set_kernel_directory(str(self.kernels))
        return None
