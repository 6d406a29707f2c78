"""Every Python example in README and docs runs, and every command of ours in them works."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def _blocks(language: str) -> list[pytest.ParameterSet]:
    found = []
    for page in PAGES:
        for i, block in enumerate(re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.M | re.S)):
            found.append(pytest.param(block, id=f"{page.name}-{i}"))
    return found


@pytest.mark.parametrize("code", _blocks("python"))
def test_python_examples(code: str, tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, timeout=120)


def _commands() -> list[str]:
    lines = [line.split("  #")[0].strip() for block in _blocks("sh") for line in str(block.values[0]).splitlines()]
    return [line for line in lines if line.startswith("implicitrt ")]


@pytest.mark.parametrize("command", _commands())
def test_commands(command: str, tmp_path: Path) -> None:
    arguments = shlex.split(command)[1:]
    subprocess.run([sys.executable, "-m", "implicitrt", *arguments], cwd=tmp_path, check=True, timeout=120)


def test_scripts_in_the_docs_exist() -> None:
    for page in PAGES:
        for script in re.findall(r"scripts/[a-z-]+", page.read_text()):
            assert (ROOT / script).exists() or (ROOT / f"{script}.sh").exists(), (page.name, script)


def test_links_in_the_docs_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
            assert (page.parent / target).exists(), (page.name, target)
