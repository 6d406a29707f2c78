"""The command line, in its own process where that matters."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from implicitrt.cli import main


def test_render_a_name_and_a_formula(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "sphere", "-o", str(tmp_path / "a.png"), "--size", "32x24"]) == 0
    out = capsys.readouterr().out
    assert "32 x 24" in out and "milliseconds" in out and "HIT" in out
    arguments = ["render", "x^2 + y^2 + z^2 = a", "-o", str(tmp_path / "b.npz"), "--size", "16", "--param", "a=0.5"]
    assert main([*arguments, "--bounds", "1", "--camera", "0,0,4", "--eps", "1e-4", "--method", "raa"]) == 0
    assert np.load(tmp_path / "b.npz")["depth"].shape == (16, 16)
    for samples in ("silhouette", "2"):
        more = ["--antialias", samples, "--normals", "neighbours", "--bounds", "1"]
        assert main([*arguments[:3], str(tmp_path / f"{samples}.npz"), *arguments[4:], *more]) == 0
        assert len(np.unique(np.load(tmp_path / f"{samples}.npz")["rgba"][..., 0])) > 8


def test_values_may_begin_with_a_minus(tmp_path: Path) -> None:
    output = tmp_path / "a.npz"
    options = ["--size", "8", "--camera", "-3,-1,5", "--bounds", "-1,1,-1,1,-1,1"]
    assert main(["render", "-x^2+y^2+z", "-o", str(output), *options]) == 0
    meta = ast.literal_eval(str(np.load(output)["meta"]))
    assert meta["formula"] == "-x**2 + y**2 + z" and meta["camera"]["origin"] == (-3, -1, 5) and meta["bounds"]["lower"] == (-1, -1, -1)


def test_list_and_info(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    assert "barth_sextic" in capsys.readouterr().out
    assert main(["info"]) == 0
    out = capsys.readouterr().out
    assert "works" in out and "Used" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["render", "sen(x)", "-o", "a.png"], "did you mean 'sin'"),
        (["render", "barth_sextc", "-o", "a.png"], "did you mean barth_sextic"),
        (["render", "x + a", "-o", "a.png"], "'a' has no value"),
        (["render", "x", "-o", "a.gif"], ".png or .npz"),
        (["render", "x", "-o", "nowhere/a.png"], "cannot write"),
        (["render", "x", "-o", "a.png", "--device", "none such"], "none such"),
        (["render", "x", "-o", "a.png", "--antialias", "much"], "antialias must be"),
    ],
)
def test_errors_are_one_line_and_leave_nothing(
    arguments: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["info", "list"])
def test_a_closed_pipe_is_no_error(command: str) -> None:
    child = subprocess.Popen([sys.executable, "-m", "implicitrt", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert child.stdout and child.stderr
    child.stdout.close()  # as `| head` does
    assert child.stderr.read() == b"" and child.wait(60) == 1


def test_bad_options_exit_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["render", "x", "-o", "a.png", "--size", "big"])
    assert stop.value.code == 2


def test_ctrl_c_returns_soon_and_leaves_nothing(tmp_path: Path) -> None:
    output = tmp_path / "long.png"
    what = "sin(30*x)*sin(30*y)*sin(30*z) + 0.9999"
    command = [sys.executable, "-m", "implicitrt", "render", what, "-o", str(output), "--size", "4000x4000", "--method", "ia"]
    master, terminal = os.openpty()  # on a terminal it shows its progress, and so when it is under way
    child = subprocess.Popen(command, stderr=terminal)
    os.close(terminal)
    said = b""
    while b"%" not in said:
        said += os.read(master, 100)
    child.send_signal(signal.SIGINT)
    started = time.monotonic()
    assert child.wait(30) == 130 and time.monotonic() - started < 10
    assert b"interrupted" in os.read(master, 1000)
    assert list(tmp_path.iterdir()) == []
