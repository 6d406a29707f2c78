"""The named surfaces of the literature: formula, bounds, camera, source, and what is hard."""

from __future__ import annotations

import difflib
import functools
import importlib.resources
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from implicitrt.bounds import Bounds
from implicitrt.camera import Camera
from implicitrt.errors import ArgumentError
from implicitrt.expression import Expr, parse

__all__ = ["NamedSurface", "surfaces"]


@dataclass(frozen=True)
class NamedSurface:
    """A surface of the literature.

    Attributes:
        name: its key in `surfaces`.
        formula: as text; `constants` are folded into `expr`.
        params: the sliders that a user may move, with their defaults.
        bounds, camera: a view that shows it whole.
        degree: total degree, None where it is not polynomial.
        source: the paper that draws it; `reconstructed` where that gives only a name.
        notes: what is hard about it.
    """

    name: str
    formula: str
    constants: Mapping[str, str]
    params: Mapping[str, float]
    bounds: Bounds
    camera: Camera
    degree: int | None
    source: str
    reconstructed: bool
    notes: str

    @functools.cached_property
    def expr(self) -> Expr:
        """The formula as an expression; its only parameters are `params`."""
        expr = parse(self.formula)
        # Constants may use one another.
        for _ in self.constants:
            expr = expr.subs({k: parse(v) for k, v in self.constants.items()})
        return expr

    def _repr_latex_(self) -> str:
        return self.expr._repr_latex_()


class _Surfaces(Mapping[str, NamedSurface]):
    """Named surfaces by name, read on first use."""

    @functools.cached_property
    def _entries(self) -> dict[str, NamedSurface]:
        text = importlib.resources.files("implicitrt").joinpath("surfaces.json").read_text("utf-8")
        return {entry["name"]: _surface(entry) for entry in json.loads(text)}

    def __getitem__(self, name: str) -> NamedSurface:
        try:
            return self._entries[name]
        except (KeyError, TypeError):
            close = difflib.get_close_matches(str(name), self._entries, 3)
            hint = f" (did you mean {' or '.join(close)}?)" if close else ""
            raise _UnknownSurface(f"no surface is named '{name}'{hint}; `implicitrt list` shows all of them") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __repr__(self) -> str:
        return f"<{len(self)} named surfaces: {', '.join(list(self)[:4])}, ...>"


class _UnknownSurface(ArgumentError, KeyError):
    """A KeyError, as mappings raise, and one of ours."""

    def __str__(self) -> str:
        return str(self.args[0])


def _surface(entry: dict[str, Any]) -> NamedSurface:
    return NamedSurface(
        name=entry["name"],
        formula=entry["formula"],
        constants=MappingProxyType(entry.get("constants", {})),
        params=MappingProxyType(entry.get("params", {})),
        bounds=Bounds.of(tuple(tuple(side) for side in entry["bounds"])),
        camera=Camera(entry["eye"], entry["target"], entry["up"], entry["fov"]),
        degree=entry["degree"],
        source=entry["source"],
        reconstructed=entry["reconstructed"],
        notes=entry["notes"],
    )


surfaces = _Surfaces()
