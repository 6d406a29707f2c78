"""Ray traces any surface f(x, y, z) = 0 straight from its formula, and says what it has proven."""

from __future__ import annotations

from implicitrt.errors import (
    ArgumentError,
    BuildError,
    DeviceError,
    Error,
    ExpressionError,
    LimitError,
    MethodError,
)

__version__ = "0.1.0"

__all__ = [
    "ArgumentError",
    "BuildError",
    "DeviceError",
    "Error",
    "ExpressionError",
    "LimitError",
    "MethodError",
]
