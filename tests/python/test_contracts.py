"""Pads outside the operators: what functions promise holds, and each pad made smaller breaks it. benchmarks/mutations.py finds how much smaller."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from contracts import STEERING, Judge, all_contracts, compiler, contract_pads, contracts_of, other_numbers

from implicitrt import _core

KERNELS = Path(_core.__file__).resolve().parent / "kernels"
DOCUMENT = Path(__file__).resolve().parent.parent.parent / "docs" / "rounding.md"


@pytest.fixture(scope="module")
def judge(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Judge]:
    if compiler() is None:
        pytest.skip(
            "contracts of kernels are held against exact arithmetic in C++, and neither CXX nor c++, g++ or clang++ is there"
        )
    judge = Judge(KERNELS, tmp_path_factory.mktemp("contracts"))
    yield judge
    judge.close()


def test_contracts_hold(judge: Judge) -> None:
    assert len(all_contracts()) > 30
    for contract in all_contracts():
        broken = judge.broken(contract)
        assert broken and max(broken.values()) < 0, (contract, broken)


def test_each_pad_made_smaller_is_noticed(judge: Judge) -> None:
    """At a little less of it than the table says."""
    rows = [
        [cell.strip().strip("`") for cell in line.split("|")[1:-1]]
        for line in DOCUMENT.read_text().splitlines()
        if "contract `" in line
    ]
    assert [row[:3] for row in rows] == [[pad.file, pad.function, pad.text] for pad in judge.pads]
    for pad, row in zip(judge.pads, rows, strict=True):
        assert judge.breaks(pad, max(float(row[3]) - 0.05, 0.0)), pad


def test_every_constant_is_a_pad_with_a_contract_or_steers() -> None:
    known = set(all_contracts())
    assert all(set(contracts_of(pad)) <= known for pad in contract_pads(KERNELS))
    assert other_numbers(KERNELS) == STEERING
