"""What the package is as a whole: quick to import, complete, independent of any OpenCL library."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import implicitrt as irt
from implicitrt import _core

ROOT = Path(__file__).parents[2]


def _python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.strip()


def test_import_is_quick_and_loads_no_driver() -> None:
    code = (
        "import numpy, time; t = time.process_time(); import implicitrt; t = time.process_time() - t\n"
        "maps = open('/proc/self/maps').read().lower()\n"
        "assert 'pocl' not in maps and 'libopencl' not in maps and 'intelocl' not in maps\n"
        "import sys; assert 'sympy' not in sys.modules and 'PIL' not in sys.modules\n"
        "print(t)"
    )
    assert sorted(float(_python(code)) for _ in range(3))[1] < 0.3


def test_expressions_work_without_any_driver() -> None:
    code = (
        "import os; os.environ['OCL_ICD_VENDORS'] = '/nonexistent'\n"
        "import implicitrt as irt; print(irt.parse('2x').diff('x'))"
    )
    assert _python(code) == "2"


def test_the_extension_links_no_opencl() -> None:
    text = Path(_core.__file__).read_bytes()
    assert b"libOpenCL" not in text


@pytest.mark.parametrize("check", ["mypy", "stubtest"])
def test_types(check: str) -> None:
    stub = ["mypy.stubtest", "implicitrt._core", "--allowlist", str(Path(__file__).with_name("stub_allowlist.txt"))]
    command = {"mypy": ["mypy", str(ROOT / "python" / "implicitrt")], "stubtest": stub}[check]
    done = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_files_are_inside() -> None:
    folder = Path(irt.__file__).parent
    for name in ("py.typed", "_core.pyi", "surfaces.json"):
        assert (folder / name).is_file(), name
    assert (Path(_core.__file__).resolve().parent / "kernels" / "bisection.cl").is_file()


def test_version_is_said_once() -> None:
    text = (ROOT / "pyproject.toml").read_text()
    match = re.search(r'^version = "(.+)"$', text, re.M)
    assert match and match[1] == irt.__version__


def test_public_names_exist_and_are_documented() -> None:
    for name in irt.__all__:
        value = getattr(irt, name)
        if callable(value):
            assert value.__doc__, name
