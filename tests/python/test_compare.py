"""The speed-accuracy chart: what it counts, its table, its picture, and the command."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt
from implicitrt.cli import main


@pytest.fixture(scope="module")
def chart() -> irt.Comparison:
    return irt.compare(["sphere", "x^2 + y^2 - z^2 - 1/5"], ["ia", "raa", "contract"], [1e-2, 1e-4], (48, 40), runs=1)


def test_points(chart: irt.Comparison) -> None:
    assert len(chart) == 2 * 3 * 2 and chart.complete
    for p in chart:
        assert p.wrong_misses == p.wrong_hits == p.unresolved == 0
        assert 0 < p.milliseconds and 0 < p.of_limit
        assert p.median_error <= p.largest_error <= p.eps
        assert p.normal_error < 0.02


def test_table(chart: irt.Comparison, tmp_path: Path) -> None:
    text = chart.to_csv(tmp_path / "chart.csv")
    assert (tmp_path / "chart.csv").read_text() == text
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == 12 and rows[0]["formula"] == "sphere" and float(rows[0]["milliseconds"]) > 0
    assert "<th>largest_error</th>" in chart._repr_html_() and "| sphere |" in chart.to_markdown()
    assert "sphere" in repr(chart)


def test_pareto_front(chart: irt.Comparison) -> None:
    front = chart.pareto("sphere")
    assert front and all(
        a.milliseconds <= b.milliseconds and a.largest_error > b.largest_error
        for a, b in zip(front, front[1:], strict=False)
    )


def test_plot(chart: irt.Comparison, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    figure = chart.plot(tmp_path / "chart.png")
    assert (tmp_path / "chart.png").stat().st_size > 10_000
    assert [a.get_title() for a in figure.axes if a.get_visible()] == ["sphere", "x**2 + y**2 - z**2 - 1/5"] or len(
        figure.axes
    ) == 2


def test_interrupted_keeps_what_is_done() -> None:
    done: list[str] = []

    def stop(line: str) -> None:
        done.append(line)
        if len(done) == 2:
            raise KeyboardInterrupt

    found = irt.compare("sphere", ["ia", "raa"], [1e-2, 1e-3], (16, 16), runs=1, progress=stop)
    assert not found.complete and len(found) == 2 and "interrupted" in repr(found)


def test_bad_arguments() -> None:
    with pytest.raises(irt.ArgumentError, match="unknown method"):
        irt.compare("sphere", ["rai"], size=(8, 8))
    with pytest.raises(irt.ArgumentError, match="runs"):
        irt.compare("sphere", runs=0)
    for eps in ("a", [None], 10**400, 0):
        with pytest.raises(irt.ArgumentError, match="eps"):
            irt.compare("sphere", eps=eps, size=(8, 8))
    for runs in ("a", 2.5, np.nan, True):
        with pytest.raises(irt.ArgumentError, match="runs"):
            irt.compare("sphere", runs=runs, size=(8, 8))  # type: ignore[arg-type]
    with pytest.raises(irt.ExpressionError):
        irt.compare("sphere + )", size=(8, 8))


def test_parameters() -> None:
    call = {"methods": ["contract"], "eps": 1e-2, "size": (16, 16), "runs": 1}
    (point,) = irt.compare("x^2 + y^2 + z^2 - a", params={"a": 1}, **call)
    assert point.wrong_misses == point.wrong_hits == 0 and point.largest_error < 1e-2
    with pytest.raises(irt.ArgumentError, match="params"):
        irt.compare("x^2 + y^2 + z^2 - a", **call)


@pytest.mark.parametrize("name", ["a.csv", "a.svg"])
def test_files_are_whole_or_not_there(chart: irt.Comparison, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space"):
        (chart.to_csv if name.endswith("csv") else chart.plot)(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "chart.md"
    assert (
        main(["compare", "sphere", "-o", str(out), "--methods", "raa", "--eps", "1e-2", "--size", "16", "--runs", "1"])
        == 0
    )
    assert "| sphere | raa |" in out.read_text() and "sphere" in capsys.readouterr().out
    assert main(["compare", "sphere", "-o", str(tmp_path / "chart.txt")]) == 1
    assert main(["compare", "sphare", "-o", str(out)]) == 1 and "did you mean sphere" in capsys.readouterr().err
    assert main(["compare", "x - a", "--param", "a=0.2", "-o", str(out), "--methods", "ia", "--eps", "1e-2", "--size", "16", "--runs", "1"]) == 0
    assert main(["compare", "sin(x)", "-o", str(tmp_path / "none.png"), "--methods", "frustum-lr", "--size", "8", "--runs", "1"]) == 1


@pytest.mark.parametrize(
    ("formulas", "options", "words"),
    [
        (["sphere", "x - a"], {}, "parameter 'a'"),
        ([], {}, "formulas is empty"),
        ("sphere", {"methods": []}, "methods is empty"),
        ("sphere", {"eps": []}, "eps is empty"),
        ("sin(x)", {"methods": ["analytic"]}, "none of these methods"),
        ("sphere", {"progress": 3}, "progress must be"),
    ],
)
def test_what_is_wrong_is_told_before_anything_is_drawn(formulas: object, options: dict[str, object], words: str) -> None:
    told: list[str] = []
    with pytest.raises(irt.Error, match=words):
        irt.compare(formulas, **({"methods": ["ia"], "eps": 1e-2, "size": (16, 16), "runs": 1, "progress": told.append} | options))
    assert not told


def test_charts_of_unknown_kinds_are_refused(chart: irt.Comparison, tmp_path: Path) -> None:
    with pytest.raises(irt.ArgumentError, match="a chart is saved as"):
        chart.plot(tmp_path / "chart.xyz")
