"""Arithmetic without pads: the bound of all its roundings covers how far it is off, at points as well as over boxes and pieces of rays."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from changed_kernels import with_change
from conftest import working_devices
from formulas import CANCEL, composed

import implicitrt as irt
from implicitrt import _core

PIECES, INNER = 256, 8
RULES = ("({a} + {b})", "({a} - {b})", "({a}*{b})", "({a}*{b})", "({a})**2", "({a})**3", "({a}/3 - 7*{b}/11)", "({a} + pi)", "({a}*p + q)")
RANGE_RULES = ("Abs({a})", "Min({a}, {b})", "Max({a}, {b}/3)", "({a})**7")  # of intervals only


def _exactly(v: float) -> str:
    return "({}/{})".format(*v.as_integer_ratio())


def _contain(ranges: np.ndarray, f: irt.Expr, points: np.ndarray) -> bool:
    known = _core.values(f._node, points.reshape(-1, 3)).reshape(*points.shape[:-1], 2)
    return bool(((ranges[:, :1] <= known[..., 0]) & (known[..., 1] <= ranges[:, 1:])).all())


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("algebra", ["ia", "raa"])
def test_rounding_stays_within_its_bound(monkeypatch: pytest.MonkeyPatch, device: str, algebra: str, precision: str) -> None:
    pads = _core.enclose_pieces
    monkeypatch.setattr(_core, "enclose_pieces", lambda node, request: pads(node, {**request, "bare": True}))
    rng = np.random.default_rng([len(algebra), len(precision), *device.encode()])
    rules = RULES + RANGE_RULES if algebra == "ia" else RULES
    p, q = 0.1, -2.7
    texts = [CANCEL] + [composed(rng, rules) for _ in range(20)]
    tried = 0
    for text in texts:
        f = irt.parse(text)
        exact = irt.parse(re.sub(r"\bp\b", _exactly(p), re.sub(r"\bq\b", _exactly(q), text)))
        params = {"p": p, "q": q} if "*p + q" in text else {}
        given = {"params": params, "algebra": algebra, "precision": precision, "device": device}
        source = irt.kernel_source(f, algebra, precision=precision, bounds=3, params=params)
        if "#define IRT_SLACK 1" not in source:
            continue  # it may overflow
        tried += 1
        centre = rng.integers(-3000, 3001, (PIECES, 3)) / 1024.0 * 10.0 ** -rng.integers(0, 3, (PIECES, 1))
        centre = centre.astype(np.float32).astype(np.float64)
        half = rng.integers(0, 257, (PIECES, 3)) / 1024.0 * (np.arange(PIECES) % 2)[:, None]  # half of them are points
        inner = np.clip(centre[:, None] + (rng.integers(-4, 5, (PIECES, INNER, 3)) / 4.0) * half[:, None], (centre - half)[:, None], (centre + half)[:, None])
        found = irt.enclose(f, centre - half, centre + half, **given).astype(np.float64)
        assert _contain(found, exact, inner), (text, "boxes")
        if algebra == "raa":
            direction = np.where(half == 0, 1.0 / 1024, half)
            end = np.sort(rng.integers(-64, 65, (PIECES, 2)) / 64.0, axis=1)
            t = end[:, :1] + np.arange(INNER + 1) / INNER * (end[:, 1:] - end[:, :1])
            along = centre[:, None] + t[..., None] * direction[:, None]
            found = irt.enclose_rays(f, centre, direction, end[:, 0], end[:, 1], **given).astype(np.float64)
            assert _contain(found, exact, along), (text, "rays")
        if tried == 3:
            break
    assert tried == 3


def test_a_smaller_bound_is_noticed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    smaller = with_change(tmp_path, "form.cl", "r.slack = irt_slack(", "r.slack = (F)R(0.2) * irt_slack(")
    try:
        _core.set_kernel_directory(str(smaller))
        for algebra in ("ia", "raa"):
            with pytest.raises(AssertionError, match="boxes|rays"), monkeypatch.context() as patch:
                test_rounding_stays_within_its_bound(patch, working_devices()[0].driver, algebra, "single")
    finally:
        _core.set_kernel_directory(str(Path(_core.__file__).resolve().parent / "kernels"))


def test_kernels_have_it_where_there_is_a_bound() -> None:
    for text, has in (("x**2*y - z", True), ("x**2*sqrt(y) - z", False), ("x**2/y - z", False), ("exp(x) - y", False)):
        assert ("#define IRT_SLACK 1" in irt.kernel_source(text, "raa")) == has, text
        assert "#define IRT_SLACK 1" not in irt.kernel_source(text, "raa", rounding="fast")
        assert ("#define IRT_SLACK 1" in irt.kernel_source(text, "contract")) == has, text
    assert "#define IRT_SLACK 1" not in irt.kernel_source("x**40*y**40*z**40 - 1", "ia", bounds=1000)  # may overflow
    assert "#define IRT_SLACK 1" in irt.kernel_source("Max(Abs(x) - 1, y**6 - z)", "ia") and "#define IRT_SLACK 1" not in irt.kernel_source("Max(Abs(x) - 1, y**6 - z)", "raa")
