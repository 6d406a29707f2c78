"""Frames as arrays, pictures and files."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import implicitrt as irt


@pytest.fixture(scope="module")
def frame() -> irt.Frame:
    """A small sphere."""
    return irt.render("x^2 + y^2 + z^2 - 1", size=(12, 8))


def test_arrays(frame: irt.Frame) -> None:
    assert frame.size == (12, 8) and frame.depth.shape == frame.status.shape == frame.hit.shape == (8, 12)
    assert frame.depth.dtype == np.float32 and frame.status.dtype == np.uint8
    assert np.array_equal(frame.hit, np.isfinite(frame.depth))
    assert np.isnan(frame.points[~frame.hit]).all() and np.isfinite(frame.points[frame.hit]).all()
    assert np.isnan(frame.normal[~frame.hit]).all()
    assert np.allclose(np.linalg.norm(frame.normal[frame.hit], axis=1), 1, atol=1e-5)
    assert (frame.uncertainty[frame.status == irt.Status.HIT] > 0).all()


def test_as_numpy_array(frame: irt.Frame) -> None:
    assert np.array_equal(np.asarray(frame), frame.rgb)
    assert np.asarray(frame, dtype=np.float64).dtype == np.float64
    copied = np.array(frame)
    copied[:] = 0
    assert frame.rgb.any()


def test_npz_has_everything(tmp_path: Path) -> None:
    clip = irt.Clip("x - 1/10")
    camera = irt.Camera((0, 0, 5), projection=np.str_("orthographic"))
    made = irt.render("x^2 + y^2 + z^2 - 1", [2, clip], camera, (4, 4), irt.Bisection(np.str_("raa")), rounding=np.str_("outward"), outputs=("normal", "pieces"))
    made.save(tmp_path / "a.npz")
    stored = np.load(tmp_path / "a.npz")
    assert set(stored) == {"depth", "uncertainty", "status", "normal", "pieces", "meta"}
    meta = ast.literal_eval(str(stored["meta"]))
    assert irt.parse(meta["formula"]) == made.formula and meta["bounds"]["clips"] == (str(clip.g),)


def test_unwritable_files_are_named(frame: irt.Frame, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as error:
        frame.save(tmp_path / "nowhere" / "a.png")
    assert error.value.filename == str(tmp_path / "nowhere" / "a.png")


def test_long_names_and_links(frame: irt.Frame, tmp_path: Path) -> None:
    long = tmp_path / ("a" * 251 + ".png")
    frame.save(long)
    link = tmp_path / "link.png"
    link.symlink_to(long)
    long.write_bytes(b"")
    frame.save(link)
    assert link.is_symlink() and long.read_bytes()[:4] == b"\x89PNG"


def test_counts_and_repr(frame: irt.Frame) -> None:
    assert sum(frame.stats.counts.values()) == 96
    assert frame.stats.counts["HIT"] == (frame.status == irt.Status.HIT).sum()
    assert "12 x 8" in repr(frame) and "HIT" in repr(frame)
    assert set(frame.stats.seconds) - {"prepare", "driver"} == {"parse", "build", "launch", "kernel", "total"}


def test_the_background_is_stored_as_it_was_given() -> None:
    empty = irt.render("z + 10", size=(4, 4), background=(0.2, 0.5, 0.8))
    assert empty.rgb[0, 0].tolist() == [51, 128, 204]
