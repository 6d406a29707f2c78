"""The committed speed-accuracy chart, redrawn in part: no status lies, errors are no larger, no more stays open, and `auto` takes what it took. Times are not tested: at a size that
CI can afford kernels take milliseconds, and ratios of what is far apart in the chart turn round."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

import implicitrt as irt
from implicitrt.compare import Point

COMMITTED = Path(__file__).parents[2] / "docs" / "speed-accuracy.csv"
SURFACES = ["labs_7", "barth_sextic", "sin_blob", "menger_3"]
METHODS = ["ia", "raa", "contract", "auto"]
WIDTHS = [2.0**-8, 2.0**-14]
SIZE, DRAWN = (96, 96), (256, 256)


@pytest.fixture(scope="module")
def committed() -> dict[tuple[str, str, float], dict[str, str]]:
    with COMMITTED.open(encoding="utf-8", newline="") as file:
        return {(r["formula"], r["method"], float(r["eps"])): r for r in csv.DictReader(file)}


@pytest.fixture(scope="module")
def redrawn() -> dict[tuple[str, str, float], Point]:
    return {(p.formula, p.method, p.eps): p for p in irt.compare(SURFACES, METHODS, WIDTHS, SIZE, runs=3)}


def test_the_chart_has_every_method(committed: dict[tuple[str, str, float], dict[str, str]]) -> None:
    assert {method for _, method, _ in committed} == set(irt.methods())


def test_statuses_and_errors(committed, redrawn) -> None:  # type: ignore[no-untyped-def]
    for key, p in redrawn.items():
        before = committed[key]
        assert p.wrong_misses == int(before["wrong_misses"]) == 0 and p.wrong_hits == int(before["wrong_hits"]) == 0, key
        # Fewer pixels, so hardly a larger error; eps is what was promised.
        assert p.largest_error <= max(2 * float(before["largest_error"]), p.eps), key
        ran = [text.split(",")[0] for text in (p.ran, before["ran"])]
        assert ran[0] == ran[1], key
        shares = [(touching + unresolved + wide) / pixels for touching, unresolved, wide, pixels in (
            (p.touching, p.unresolved, p.wide, SIZE[0] * SIZE[1]),
            (int(before["touching"]), int(before["unresolved"]), int(before["wide"]), DRAWN[0] * DRAWN[1]),
        )]  # fmt: skip
        assert shares[0] <= shares[1] + 0.005, key
