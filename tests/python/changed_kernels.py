"""Copies of the kernels with one thing changed, which tests have to notice."""

from __future__ import annotations

import shutil
from pathlib import Path


def with_change(folder: Path, file: str, old: str, new: str) -> Path:
    """A copy of all kernels below `folder`, `old` in one file of them replaced: for `_core.set_kernel_directory`."""
    from implicitrt import _core  # which Oclgrind's script imports when its device is ready

    copy = folder / "kernels"
    shutil.copytree(Path(_core.__file__).resolve().parent / "kernels", copy)
    text = (copy / file).read_text()
    changed = text.replace(old, new)
    assert changed != text
    (copy / file).write_text(changed)
    return copy
