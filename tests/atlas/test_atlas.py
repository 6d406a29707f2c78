"""The atlas of failures: each method does on each hard case what is expected of it, no worse and no better."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from implicitrt.devices import devices

sys.path.insert(0, str(Path(__file__).parent))
from cases import CASES
from outcomes import PINNED, TOLERANCE, draw, expected, lies, names, outcome, proven_methods, rates, truth

UPDATE = "python tests/atlas/outcomes.py {case} --method {method}"


def _pinned() -> bool:
    driver, width = PINNED
    return any(d.ok and d.driver == driver and d.width == width for d in devices())


@pytest.mark.skipif(not _pinned(), reason=f"expectations are of {PINNED[0]} at width {PINNED[1]}")
@pytest.mark.parametrize("case", CASES)
def test_methods_do_what_is_expected(case: str) -> None:
    known, wrong = expected().get(case, {}), []
    for method in names():
        update = UPDATE.format(case=case, method=method)
        if method not in known:
            wrong.append(f"{method} has no expectation; if what it does is right: {update}")
            continue
        before, now = known[method], rates(draw(CASES[case], method, PINNED[0]), truth(case))
        if before is None or now is None:
            if before != now:
                wrong.append(f"{method} was {outcome(before)}, now is {outcome(now)}; if that is meant: {update}")
            continue
        for what, rate in now.items():
            if rate > before[what] + TOLERANCE:
                wrong.append(f"{method} got worse: {what} {before[what]:.2%} -> {rate:.2%}")
            elif rate < before[what] - TOLERANCE:
                wrong.append(f"{method} got better: {what} {before[what]:.2%} -> {rate:.2%}; keep that by: {update}")
    assert not wrong, f"{case} ({CASES[case].why}):\n" + "\n".join(wrong)


def test_nothing_is_expected_of_what_does_not_exist() -> None:
    assert list(expected()) == list(CASES)
    assert {m for row in expected().values() for m in row} == set(names())


def test_proven_methods_are_never_expected_to_lie() -> None:
    for case, row in expected().items():
        for method in proven_methods():
            found = row[method]
            assert found is None or not (found["missed"] or found["false"] or found["elsewhere"]), (case, method)


def test_the_page_says_what_is_expected() -> None:
    """docs/where-methods-fail.md and its pictures are drawn by benchmarks/atlas.py."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
    from atlas import FOLDER, PAGE, section, summary

    page = PAGE.read_text(encoding="utf-8")
    assert summary() in page
    stale = [case for case in CASES if section(case, draws=False).strip() not in page]
    assert not stale, f"written anew by: python benchmarks/atlas.py {' '.join(stale)}"
    assert {p.name for p in FOLDER.iterdir()} == {line.split("(atlas/")[1].split(")")[0] for line in page.splitlines() if "](atlas/" in line}


def _others() -> list[str]:
    return [d.driver for d in devices() if d.ok and d.driver != PINNED[0]]


# Each other driver takes its share of the cases; `outcomes.py --honest DEVICE` takes all of them, by all methods.
@pytest.mark.parametrize(
    ("case", "driver"), [(c, d) for k, d in enumerate(_others()) for i, c in enumerate(CASES) if i % 4 == k]
)
def test_statuses_do_not_lie_on_other_drivers(case: str, driver: str) -> None:
    found = [lies(case, method, driver) for method in ("ia", "contract")]
    assert not any(found), found
