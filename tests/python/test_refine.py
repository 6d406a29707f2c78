"""Brackets narrowed down where they are found: what values in double are off by, and what frames make of them."""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contracts import compiler
from formulas import CANCEL, composed

import implicitrt as irt
from implicitrt import _core

RULES = (
    "({a} + {b})", "({a} - {b})", "({a}*{b})", "({a})**2", "({a})**3", "({a})**4", "({a}/3 - 7*{b}/11)", "({a} + pi)", "sin({a})", "cos({a}*2)",
    "exp(-({a})**2)", "Abs({a})", "Min({a}, {b})", "Max({a}, {b}/3)",
)  # fmt: skip
# A kernel's functions on the host. Builtins err by four ulp, upwards or downwards.
HOST = """
#include <cmath>
typedef double FW;
typedef float F;
typedef float real;
#define FINE(v) v
#define R(v) v##f
#define TINY 0x1p-126f
#define ULP 0x1p-23f
#define PARAMETERS
static int direction;
template <class T> T min(T a, T b) { return b < a ? b : a; }
template <class T> T max(T a, T b) { return a < b ? b : a; }
static double off(double v, int ulp) { for (; ulp > 0; --ulp) v = std::nextafter(v, direction * INFINITY); return v; }
static float fma(float a, float b, float c) { return std::fmaf(a, b, c); }
static double sine(double v) { return off(std::sin(v), 3); }
static double cosine(double v) { return off(std::cos(v), 3); }
static double exponential(double v) { return off(std::exp(v), 2); }
#define FINE_SIN sine
#define FINE_COS cosine
#define exp exponential
using std::fabs;
"""
CALL = """
extern "C" void values(int n, const double* at, const float* sizes, float place, int up, double* value, float* error) {
  direction = up;
  for (int i = 0; i < n; ++i, at += 3, sizes += 3) value[i] = irt_fine(at[0], at[1], at[2]), error[i] = irt_fine_error(sizes[0], sizes[1], sizes[2], place);
}
"""


def _source(f: irt.Expr, monkeypatch: pytest.MonkeyPatch, **options: Any) -> str:
    """Of a frame whose brackets are narrowed down."""
    plain = _core.kernel_source
    with monkeypatch.context() as m:
        m.setattr(_core, "kernel_source", lambda node, request: plain(node, {**request, "eps": 1e-6, "first_eps": 1e-4}))
        return irt.kernel_source(f, "contract", bounds=3, **options)


def _functions(source: str) -> str:
    return "\n".join(re.findall(r"^static inline \w+ irt_fine\w*\(.*?^}", source, re.MULTILINE | re.DOTALL))


@pytest.mark.skipif(compiler() is None, reason="functions of kernels are compiled in C++, and neither CXX nor c++, g++ or clang++ is there")
def test_values_in_double_are_no_more_than_this_off(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    rng = np.random.default_rng(12)
    texts = [CANCEL, str(irt.surfaces["barth_sextic"].expr)] + [composed(rng, RULES) for _ in range(40)]
    tried = 0
    for text in texts:
        f = irt.parse(text)
        functions = _functions(_source(f, monkeypatch))
        if not functions:
            continue  # it may overflow
        tried += 1
        (tmp_path / "f.cpp").write_text(HOST + functions + CALL)
        library = tmp_path / f"f{tried}.so"
        subprocess.run([str(compiler()), "-O1", "-ffp-contract=off", "-shared", "-fPIC", "-w", "-o", str(library), str(tmp_path / "f.cpp")], check=True)
        points = rng.uniform(-3, 3, (2000, 3)) * 10.0 ** -rng.integers(0, 4, (2000, 1))
        truth = np.asarray(_core.values(f._node, points))
        # Coordinates are off by a part of their sizes, or hardly.
        place = 2.0 ** -int(rng.integers(30, 50))
        at = points + rng.choice([-1, 1], points.shape) * np.abs(points) * place * rng.choice([0, 1], (2000, 1))
        sizes = np.nextafter(np.abs(points).astype(np.float32), np.float32(np.inf))
        value, error = np.empty(2000), np.empty(2000, np.float32)
        for up in (-1, 1):
            ctypes.CDLL(str(library)).values(
                2000, at.ctypes.data_as(ctypes.c_void_p), sizes.ctypes.data_as(ctypes.c_void_p), ctypes.c_float(place * (1 + 1e-6)), up, value.ctypes.data_as(ctypes.c_void_p),
                error.ctypes.data_as(ctypes.c_void_p),
            )  # fmt: skip
            assert (np.maximum(value - truth[:, 0], truth[:, 1] - value) <= error).all(), text
            assert np.isfinite(error).all() and (error > 0).all()
    assert tried > 25


def test_only_what_is_refined_has_values_in_double(monkeypatch: pytest.MonkeyPatch) -> None:
    for text, refined in (("x^2 + sin(y)*z - 1", True), ("1/x + y - z", False), ("x^2 + y*log(z + 4) - 1", False), ("a*x + y - z", False)):
        source = _source(irt.parse(text), monkeypatch)
        assert ("irt_fine" in source) == refined, text
        assert "irt_fine" not in irt.kernel_source(irt.parse(text), "contract", bounds=3)


@pytest.mark.parametrize("method", ["contract", "raa", "ia", "mitchell"])
@pytest.mark.parametrize(("text", "share"), [("(x^2 + y^2 + z^2 - 1.078125)*(x - 3)", 0.99), ("sin(3*x)*cos(2*y) + z - exp(-x^2)/2", 0.99), ("Min(Abs(x) - 1.078125, Max(Abs(y) - 0.5, Abs(z) - 0.75))", 0.98)])
def test_most_brackets_are_narrowed_down_at_once(method: str, text: str, share: float) -> None:
    camera = irt.Camera(origin=(2.5, 2.1, 6.3))
    frame = irt.render(text, bounds=2, camera=camera, size=(97, 64), method=method, eps=1e-7, outputs=("pieces",))
    truth = irt.reference(text, 2, camera, (97, 64))
    hit = frame.status == irt.Status.HIT
    both = hit & truth.hit
    assert both.sum() > 500 and frame.stats.precision == "single and double"
    assert not (hit & (truth.kind == irt.Status.MISS)).any() and not (truth.hit & (frame.status == irt.Status.MISS)).any()
    assert (np.abs(frame.depth[both] - truth.depth[both]) <= frame.uncertainty[both] + 1e-13).all()
    assert (2 * frame.uncertainty[hit] <= 1e-7).all()
    assert frame.stats.escalated <= (1 - share) * hit.sum()


@pytest.mark.parametrize(("distance", "eps"), [(1e4, 1e-6), (1e6, 1e-6), (1e6, 2e-7)])
def test_far_cameras_leave_few_brackets_wide(distance: float, eps: float) -> None:
    """The farthest have a second pass, which tells their rounding apart from errors of values."""
    f = "4*(2.618*x^2 - y^2)*(2.618*y^2 - z^2)*(2.618*z^2 - x^2) - 4.236*(x^2 + y^2 + z^2 - 1)^2"
    camera = irt.Camera(origin=(0.48 * distance, 0.36 * distance, 0.8 * distance), fov=math.degrees(4 / distance))
    frame, truth = irt.render(f, bounds=2, camera=camera, size=(40, 40), method="contract", eps=eps, outputs=()), irt.reference(f, 2, camera, (40, 40))
    hit = truth.hit & (frame.status == irt.Status.HIT)
    assert (np.abs(frame.depth[hit] - truth.depth[hit]) <= frame.uncertainty[hit] + truth.uncertainty[hit] + 1e-15 * distance).all()
    assert hit.sum() > 500 and frame.stats.escalated < 0.05 * hit.sum()


def test_one_kernel_is_built() -> None:
    f = "x^2 + 1.2890625*y^2 + cos(z) - 1.0390625"
    assert irt.render(f, bounds=2, size=(64, 48), method="contract", eps=1e-7).stats.builds == 1


def test_roots_that_nearly_meet_are_told_apart() -> None:
    """Where slopes change sign within a bracket nothing is narrowed down, and the first root stays the first."""
    down = irt.Camera(origin=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), projection="orthographic", height=3)
    for k in range(10, 34, 6):
        gap = 2.0**-k
        frame = irt.render(f"(z - 1/3)*(z - 1/3 + {gap}) + x^2*2^-60", bounds=2, camera=down, size=(4, 4), method="contract", eps=2e-7, outputs=())
        hit = frame.status == irt.Status.HIT
        assert (np.abs(frame.depth[hit] - (9 - 1 / 3)) <= frame.uncertainty[hit] + 1e-12).all(), k
        assert (frame.status != irt.Status.MISS).all()


def test_drivers_and_widths_agree(device: str) -> None:
    f, camera = "sin(3*x)*cos(2*y) + z - exp(-x^2)/2", irt.Camera(origin=(2.5, 2.1, 6.3))
    truth = irt.reference(f, 2, camera, (53, 37))
    for beams in (False, True):
        frame = irt.render(f, bounds=2, camera=camera, size=(53, 37), method=irt.Contraction(beams=beams), eps=1e-7, device=device, outputs=())
        hit = truth.hit & (frame.status == irt.Status.HIT)
        assert (frame.status == truth.kind).mean() > 0.99
        assert (np.abs(frame.depth[hit] - truth.depth[hit]) <= frame.uncertainty[hit] + 1e-13).all() and (2 * frame.uncertainty[hit] <= 1e-7).all()
