"""Pads outside the operators: what each function promises, held against exact arithmetic with one pad made smaller.

End-to-end no ray notices them, because other pads are wider. So tests/pads/*.cpp compile the kernel files as C++, with quotients and roots that err by all that
OpenCL permits, and state for each function what must hold of its results whatever rounding did (a contract). `contract_pads` finds the constants,
`Judge` compiles once and makes one of them smaller as it runs.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mutations import HEAD, Pad, _before, _code, is_operator

SOURCES = Path(__file__).resolve().parent.parent / "pads"
VARIANTS = ("single", "single alone", "double")  # 0: rays are set up in double; 1: a device without double, 2
FLAGS = ("-std=c++20", "-O1", "-ffp-contract=off", "-w")

# What pads: a constant times ULP, ULP itself, POSITION_PAD, and these, which pad without ULP: errors that count more than once, units that
# rounding may be off.
FACTORS = {
    "clip.cl": ("R(2.0) * MODEST", "R(2.5) * fma("),
    "contract.cl": ("SLACK R(0.5)", "inverse - R(4.0)"),
    "enclosure_affine.cl": ("R(2.5) * e",),
    "enclosure_interval.cl": ("R(2.5) * e",),
    "frustum_fine.cl": ("R(1.07) * (error", "- 1) * R(1.1)", "R(0.51)"),
    "frustum_form.cl": (
        "R(2.0) * CUT_ERROR), cell->size, cell->error);",
        "R(2.0) * CUT_ERROR), cell->size, cell->error), *error",
    ),
    "path.cl": ("INWARD R(1.75)", "ALONG_ERROR R(1.05)", "ALONG_ERROR R(1.55)", "R(2.0) * fma((F)(REPORT_ERROR"),
    "refine.cl": ("R(0x1p-52)", "R(2.0) * RADIUS", "ra(way, (F)0, fma((F)ULP, fabs(way), (F)(R(1.01)", "fabs(way), (F)(R(1.01) * POSITION_PAD / RADIUS));\n  return ia"),
    "results.cl": ("R(4.0) * R(0x1p-52)",),
    "scene.cl": ("DEPTH_ERROR R(0.75)", "DEPTH_ERROR R(4.0)"),
    "sharpen.cl": ("GROWN R(0x1p-20)",),
}
# Times ULP, but no pads: where a search ends or a wish begins, whatever is proven.
THRESHOLDS = {
    "closed_form.cl": ("noise *= ULP", "ends = there"),
    "csg_analytic.cl": ("NEARBY",),  # roots that count as one
    "frustum_form.cl": ("define REACH", "at_floor("),  # how long brackets are wanted, and can be
}
# Other numbers of files that pad, how often: they say where to look next, and nothing is believed for them. Halves and reciprocals count nowhere, nor do
# the coefficients of closed_form.cl.
STEERING = {
    "bisection.cl": {"R(8.0)": 1, "R(0.75)": 1, "R(2.0)": 1},
    "candidate.cl": {"R(0.25)": 1, "R(1.5)": 1, "R(1.25)": 1},
    "clip.cl": {"R(2.0)": 1},  # anything above 1
    "contract.cl": {"R(0.2)": 1, "R(8.0)": 2, "R(0.75)": 1, "R(0.0625)": 1},
    "frustum_fine.cl": {"R(0.001)": 1, "R(0.45)": 1},
    "frustum_form.cl": {"R(0.0625)": 1, "R(0.515625)": 1, "R(0.0)": 2, "R(0.015625)": 1, "R(0.984375)": 1, "R(0.45)": 1, "R(8.0)": 1, "R(16.0)": 1},  # fmt: skip
    "frustum_knots.cl": {"R(0.125)": 2, "R(0.25)": 1},
    "frustum_rays.cl": {"R(2.0)": 1},  # from -reach to reach
    "path.cl": {"R(0.125)": 1},
    "refine.cl": {"R(0.0625)": 1, "R(0.45)": 1},
    "mitchell.cl": {"R(0.125)": 1, "R(4.0)": 1, "R(0.75)": 1, "R(0.25)": 1},
}


def contract_pads(kernels: Path) -> list[Pad]:
    """Every pad outside the operators."""
    found = []
    for file in sorted(kernels.glob("*.cl")):
        if not is_operator(file.name):
            found += _pads(file.name, _code(file.read_text()))
    return found


def _pads(name: str, code: str) -> list[Pad]:
    spans = {m.span() for m in re.finditer(r"\(F\)POSITION_PAD\b", code)}
    for unit in re.finditer(r"\bULP\b", code):
        product = re.search(r" \* $", code[: unit.start()])
        span = _before(code, product.start()) if product else unit.span()
        if code[slice(*span)] not in ("ALONG_ERROR", "DEPTH_ERROR", "REPORT_ERROR"):  # constants above
            spans.add(span)
    for factor in FACTORS.get(name, ()):
        at, literal = code.index(factor), re.search(r"R\([^)]*\)", factor)
        spans.add((at + literal.start(), at + literal.end()))
    found = []
    for start, end in sorted(spans):
        line = code[code.rfind("\n", 0, start) + 1 : code.index("\n", end)]
        if not any(text in line for text in THRESHOLDS.get(name, ())):
            function = [m[1] for m in HEAD.finditer(code, 0, start)][-1]
            found.append(Pad(name, start, end, code[start:end], function))
    return found


def other_numbers(kernels: Path) -> dict[str, Counter[str]]:
    """The numbers of files that pad, or are in STEERING, that are no pads."""
    pads, found = contract_pads(kernels), {}
    for name in sorted({pad.file for pad in pads} | set(STEERING)):
        code = _code((kernels / name).read_text())
        mine = {pad.start for pad in pads if pad.file == name}
        numbers = [m for m in re.finditer(r"\bR\(-?[0-9.e-]+\)", code) if m.start() not in mine]
        found[name] = Counter(m[0] for m in numbers if m[0] not in ("R(0.5)", "R(1.0)"))
    return {name: numbers for name, numbers in found.items() if numbers and name != "closed_form.cl"}


class Judge:
    """The contracts, compiled once."""

    def __init__(self, kernels: Path, folder: Path) -> None:
        self.pads = contract_pads(kernels)
        self._number(kernels, folder / "kernels")
        jobs = [
            (source, variant)
            for source in sorted(SOURCES.glob("*.cpp"))
            if source.stem != "main"
            for variant in range(3)
        ]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(lambda job: self._compile(folder, *job), [*jobs, (SOURCES / "main.cpp", 0)]))
        program = folder / "contracts"
        _run([compiler(), *map(str, objects), "-o", str(program)])
        self._process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def close(self) -> None:
        self._process.communicate()

    def _number(self, kernels: Path, copy: Path) -> None:
        """Copies the kernels, each pad as PAD(its number, the constant); quotients of single numbers err as those of packets do."""
        copy.mkdir(parents=True)
        for file in kernels.glob("*.cl"):
            code = _code(file.read_text())
            for k, pad in reversed(list(enumerate(self.pads))):
                if pad.file == file.name:
                    code = f"{code[: pad.start]}PAD({k}, {pad.text}){code[pad.end :]}"
            (copy / file.name).write_text(code.replace("R(1.0) / length", "quotient(R(1.0), length)"))

    def _compile(self, folder: Path, source: Path, variant: int) -> Path:
        target = folder / f"{source.stem}{variant}.o"
        _run(
            [
                compiler(),
                *FLAGS,
                f"-DVARIANT={variant}",
                f"-I{folder / 'kernels'}",
                "-c",
                str(source),
                "-o",
                str(target),
            ]
        )
        return target

    def broken(self, contract: str, pad: Pad | None = None, share: float = 1.0, samples: int = 20000) -> dict[str, int]:
        """For each variant that has the contract, after how many samples it is broken; -1 where it holds."""
        number = -1 if pad is None else self.pads.index(pad)
        self._process.stdin.write(f"{contract} {number} {share} {samples}\n")
        self._process.stdin.flush()
        answer = [int(v) for v in self._process.stdout.readline().split()]
        return {VARIANTS[v]: n for v, n in sorted(zip(answer[::2], answer[1::2], strict=True))}

    def breaks(self, pad: Pad, share: float, contracts: Iterable[str] = ()) -> tuple[str, str] | None:
        """The first contract, and the variant, that is broken where the pad is so much of itself."""
        for contract in contracts or contracts_of(pad):
            for variant, broken in self.broken(contract, pad, share).items():
                if broken >= 0:
                    return contract, variant
        return None


def compiler() -> str | None:
    return next(
        (
            found
            for name in (os.environ.get("CXX", ""), "c++", "g++", "clang++")
            if name and (found := shutil.which(name))
        ),
        None,
    )


def _run(command: Iterable[str]) -> None:
    done = subprocess.run(list(command), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}\n{done.stderr[:4000]}")


# What looks at the pads of a function, where that is not the contract of its name.
CONTRACTS = {
    ("beams.cl", "SPREAD"): ("beam_bounds",),
    ("beams.cl", "trace_tile"): ("beam_bounds",),
    ("clip.cl", "pace_of_error"): ("clip_axis", "clip_half_space"),
    ("contract.cl", "SLACK"): ("contract",),
    ("contract.cl", "find_root"): ("head", "halt"),
    ("enclosure_interval.cl", "direction"): ("interval_direction",),
    ("frustum_cells.cl", "find_root"): ("cell_part", "cell_inside", "cell_report"),
    ("frustum_fine.cl", "FINE_SLOPE_ERROR"): ("refine",),
    ("frustum_fine.cl", "changes_sign"): ("refine",),
    ("frustum_form.cl", "CUT_ERROR"): ("cut_at",),
    ("frustum_form.cl", "VALUE_ERROR"): ("value_at",),
    ("frustum_knots.cl", "search_cell"): ("knots",),
    ("frustum_rays.cl", "find_root"): ("form_part", "form_inside", "form_report"),
    ("path.cl", "ALONG_ERROR"): ("position", "interval"),
    ("path.cl", "INWARD"): ("inner_units",),
    ("path.cl", "PATH_AXIS"): ("position", "interval"),
    ("path.cl", "PATH_SPREAD"): ("beam",),
    ("path.cl", "make_path"): ("path_end", "beam"),
    ("path.cl", "report"): ("report", "results"),
    ("ray_camera.cl", "AXIS"): ("ray_camera", "position", "enclose_bare"),
    ("ray_list.cl", "AXIS_ERROR"): ("ray_list", "interval"),
    ("refine.cl", "place_about"): ("slopes_by_forms", "slopes_by_intervals"),
    ("refine.cl", "way_about"): ("slopes_by_forms", "slopes_by_intervals"),
    ("results.cl", "DEPTH_ROUNDING"): ("results_fine",),
    ("results.cl", "write_results"): ("results", "results_fine"),
    ("scene.cl", "DEPTH_ERROR"): ("results",),
    ("sharpen.cl", "GROWN"): ("sharpen",),
    ("sharpen.cl", "sharpen_packet"): ("sharpen",),
}


def contracts_of(pad: Pad) -> tuple[str, ...]:
    return CONTRACTS.get((pad.file, pad.function), (pad.function,))


def all_contracts() -> list[str]:
    return sorted(
        m[1]
        for source in SOURCES.glob("*.cpp")
        for m in re.finditer(r"^CONTRACT\((\w+)\)", source.read_text(), re.MULTILINE)
    )
