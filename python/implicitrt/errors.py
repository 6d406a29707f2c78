"""Every error of the package. Each says what was found, what is allowed and what to do."""

from __future__ import annotations

__all__ = [
    "ArgumentError",
    "BuildError",
    "DeviceError",
    "Error",
    "ExpressionError",
    "LimitError",
    "MethodError",
]


class Error(Exception):
    """Base of every error that implicitrt raises on purpose."""


class ExpressionError(Error, ValueError):
    """A formula cannot be read or used; names the position and what is allowed."""


class ArgumentError(Error, ValueError):
    """A camera, bounds, size, eps, shape or parameter is missing, unknown or not usable."""


class LimitError(Error):
    """A cap is exceeded; names the cap and the value."""


class MethodError(Error):
    """This method cannot draw this formula; says why, and which can."""


class DeviceError(Error):
    """No OpenCL driver works, or one failed; names what was tried and what to install."""


class BuildError(Error):
    """The driver's compiler refused a kernel; carries the numbered source and the log."""
