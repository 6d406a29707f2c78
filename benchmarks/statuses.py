"""What statuses are worth: every named surface and 200 seeded formulas, every method that guarantees inclusion, eps 1e-2 to 1e-6, against
irt.reference. Closed forms are judged where they apply, though they guarantee less.

    python benchmarks/statuses.py [--formulas 200] [--size 48] [--first 0] [--seconds 200] [--state out/statuses.jsonl] [--only surface]

What is done is written down in `state`, one line each, and not done again: with --seconds it stops after about so long, and the next call
goes on. Once all is there it prints how many simple roots were HIT, how much stayed open, which default budgets were spent, and every status
that lied; then it exits with 1.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import table

import implicitrt as irt
from implicitrt import Status

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "python"))
from formulas import check, formula

WIDTHS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
FRUSTUM = tuple(n for n in irt.methods() if n.startswith("frustum"))  # take frames of polynomials only
TRACING = (
    *(n for n, m in irt.methods().items() if m.guarantee == "inclusion" and n not in ("mitchell", *FRUSTUM)),
    irt.Mitchell("ia"),
    irt.Mitchell("raa"),
)
CLOSED = ("analytic", "csg-analytic")  # their depths have no bracket
METHODS = (*TRACING, *FRUSTUM, *CLOSED)
BUDGET = 1 << 18  # limits::kPiecesInDouble, the larger one of the defaults


def lies(truth: Any, status: np.ndarray, t: np.ndarray, uncertainty: np.ndarray) -> dict[str, int]:
    """How many statuses contradict the reference, by how."""
    proven, open_ = status == Status.HIT, status == Status.UNRESOLVED
    with np.errstate(invalid="ignore"):
        low, high = t - uncertainty, t + uncertainty
        apart = (truth.bracket[..., 1] < low) | (truth.bracket[..., 0] > high)
        early = (truth.kind == Status.UNRESOLVED) & (high < truth.bracket[..., 0])
    return {
        "wrong MISS": int((truth.hit & (status == Status.MISS)).sum()),
        "wrong HIT": int(((truth.kind == Status.MISS) & proven).sum()),
        "bracket without its root": int((proven & truth.hit & apart).sum()),
        "HIT before any zero": int((proven & early).sum()),
        "UNRESOLVED behind a root": int((open_ & truth.hit & (truth.bracket[..., 1] < t)).sum()),
    }


def spent(s: Any, size: int, method: Any, eps: float) -> int:
    """How many more pixels a larger budget of pieces decides than the default."""
    open_ = [int((irt.render(s, size=(size, size), method=method, eps=eps, outputs=(), max_pieces=n).status == Status.UNRESOLVED).sum())
             for n in (BUDGET, 8 * BUDGET)]  # fmt: skip
    return max(0, open_[0] - open_[1])


def surface(name: str, size: int) -> dict[str, Any]:
    """What each method makes of one named surface."""
    s = irt.surfaces[name]
    truth = irt.reference(s, size=(size, size))
    misses = np.pad(truth.kind == Status.MISS, 1, mode="edge")
    near = np.stack([misses[i : i + size, j : j + size] for i in range(3) for j in range(3)])
    simple = (truth.kind == Status.HIT) & (near.all(0) | ~near.any(0))
    out: dict[str, Any] = {"simple": int(simple.sum()), "undecided": int((truth.kind == Status.UNRESOLVED).sum()), "methods": {}, "lies": [], "spent": []}
    for method in METHODS:
        rows = []
        for eps in WIDTHS if method not in CLOSED else WIDTHS[2:3]:
            try:
                frame = irt.render(s, size=(size, size), method=method, eps=eps, outputs=())
            except irt.MethodError:
                break
            off = frame.uncertainty if method not in CLOSED else np.full(frame.depth.shape, eps)
            for what, count in lies(truth, frame.status, frame.depth, off).items():
                if count:
                    out["lies"].append(f"{name}, {method}, eps {eps:g}: {count} times {what}")
            proven = frame.status == Status.HIT
            rows.append([eps, int((simple & proven).sum()), int((frame.status == Status.UNRESOLVED).sum())])
        if rows:
            out["methods"][str(method)] = rows
        most = max(rows, key=lambda r: r[2], default=[0, 0, 0])
        if method in TRACING and most[2] and (more := spent(s, size, method, most[0])):
            out["spent"].append(f"{name}, {method}, eps {most[0]:g}: {more} pixels")
    return out


def seeded(seed: int) -> dict[str, Any]:
    """What each method makes of rays through one random formula."""
    try:
        counts = check(formula(seed), 400, seed, TRACING, WIDTHS)
    except AssertionError as lie:
        return {"lies": [str(lie)], "counts": []}
    return {"lies": [], "counts": [[str(method), eps, c] for (method, eps), c in counts.items()]}


def report(surfaces: dict[str, Any], formulas: dict[str, Any], size: int) -> int:
    """Prints the tables; how many statuses lied."""
    rows = []
    for name, s in surfaces.items():
        row: list[object] = [name, s["simple"], s["undecided"]]
        for method in METHODS:
            found = s["methods"].get(str(method))
            hits = {eps: n for eps, n, _ in found} if found else {}
            row += [f"{hits[1e-4] / max(s['simple'], 1):.4f} {max(u for *_, u in found) / size**2:.4f}" if found else ""]
        rows.append(row)
    print("Share of simple roots off silhouettes that are HIT at eps 1e-4, and the most UNRESOLVED at any eps:\n")
    print(table(["surface", "simple roots", "undecided", *map(str, METHODS)], rows), flush=True)
    sums: dict[tuple[str, float], dict[str, int]] = {}
    with_hits = 0
    for f in formulas.values():
        with_hits += any(c["simple"] for *_, c in f["counts"])
        for method, eps, c in f["counts"]:
            total = sums.setdefault((method, eps), {})
            for what, n in c.items():
                total[what] = total.get(what, 0) + n
    print(f"\n{len(formulas)} formulas, {with_hits} of them with hits\n")
    head = ["method", "eps", "rays", "simple roots", "of them HIT", "UNRESOLVED", "undecided by the reference"]
    print(table(head, [[m, f"{e:g}", c["rays"], c["simple"], f"{c['hits'] / c['simple']:.4f}", c["unresolved"], c["undecided"]] for (m, e), c in sums.items()]))
    for one in surfaces.values():
        for what in one["spent"]:
            print("the default budget was spent:", what)
    lied = [lie for part in (surfaces, formulas) for one in part.values() for lie in one["lies"]]
    print("\nno status lied" if not lied else "\n" + "\n".join(lied))
    return len(lied)


def main() -> None:
    """Does what is not done yet, and reports."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--formulas", type=int, default=200)
    parser.add_argument("--size", type=int, default=48)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=np.inf)
    parser.add_argument("--state", type=Path, default=Path("out/statuses.jsonl"))
    parser.add_argument("--only", choices=("surface", "seed"))
    options = parser.parse_args()
    started = time.perf_counter()
    options.state.parent.mkdir(parents=True, exist_ok=True)
    lines = options.state.read_text().splitlines() if options.state.exists() else []
    done: dict[str, Any] = dict(json.loads(line) for line in lines)
    seeds = range(options.first, options.first + options.formulas)
    todo = [("surface", n, lambda n=n: surface(n, options.size)) for n in irt.surfaces] + [("seed", n, lambda n=n: seeded(n)) for n in seeds]
    for kind, name, work in todo:
        key = f"{kind} {name}"
        if key in done or (options.only and kind != options.only):
            continue
        if time.perf_counter() - started > options.seconds:
            print(f"{len(done)} of {len(todo)} done")
            return
        done[key] = work()
        for lie in done[key]["lies"]:
            print(lie, flush=True)
        with options.state.open("a") as file:
            file.write(json.dumps([key, done[key]]) + "\n")
    picked = [{n: done[f"{kind} {n}"] for k, n, _ in todo if k == kind and f"{kind} {n}" in done} for kind in ("surface", "seed")]
    sys.exit(report(picked[0], picked[1], options.size) > 0)


if __name__ == "__main__":
    main()
