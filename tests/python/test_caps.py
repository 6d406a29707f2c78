"""Caps that methods and calls have; those of formulas are tested in tests/cpp/caps_test.cpp. At each cap it works, one past it does not."""

from __future__ import annotations

import numpy as np
import pytest

import implicitrt as irt
from implicitrt import _core
from implicitrt.arguments import request_size


def test_pixels() -> None:
    side = int(_core.MAX_PIXELS**0.5)
    assert side * side == _core.MAX_PIXELS and request_size((side, side)) == (side, side)
    with pytest.raises(irt.LimitError, match="pixels"):
        irt.render("x", size=(side, side + 1))


def test_one_side() -> None:
    assert irt.render("x", size=(_core.MAX_SIDE, 1), outputs=()).size == (_core.MAX_SIDE, 1)
    with pytest.raises(irt.LimitError, match="on a side"):
        irt.render("x", size=(_core.MAX_SIDE + 1, 1))


def test_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_core, "MAX_PIXELS", 100)  # as many as are allowed take half a gigabyte an array
    ends = np.zeros((101, 3))
    assert len(irt.trace("z", ends[:100] + 1, (0, 0, -1), bounds=2)) == 100
    with pytest.raises(irt.LimitError, match="rays"):
        irt.trace("z", ends + 1, (0, 0, -1), bounds=2)
    with pytest.raises(irt.LimitError, match="boxes"):
        irt.enclose("z", ends, ends + 1)


def test_degree_of_the_frustum_form() -> None:
    assert irt.render("z^32 - 1/2", size=(8, 8), bounds=1, method="frustum-clip").stats.counts["HIT"] > 0
    with pytest.raises(irt.MethodError, match="33"):
        irt.render("z^33 - 1/2", size=(8, 8), bounds=1, method="frustum-clip")


def test_pieces() -> None:
    ball = "x^2 + y^2 + z^2 - 1"
    needed = int(irt.render(ball, size=(8, 8), method="raa", precision="single", outputs=("pieces",)).pieces.max())
    assert irt.render(ball, size=(8, 8), method="raa", precision="single", max_pieces=needed).stats.counts["UNRESOLVED"] == 0
    short = irt.render(ball, size=(8, 8), method="raa", precision="single", max_pieces=needed - 1)
    assert short.stats.counts["UNRESOLVED"] > 0 and "max_pieces" in repr(short)
