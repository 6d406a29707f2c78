"""The child process of a probe: loads one driver, runs the probe kernel, reports on standard output."""

from __future__ import annotations

import json
import os
import sys

from implicitrt import _core


def main(path: str, width: int) -> None:
    """Reports what the driver at `path` is, and which numbers were wrong ("" for none)."""
    device = _core.load_device(path, "probe", width)
    report = {
        "name": device.name, "version": device.version, "gpu": device.gpu, "fp64": device.fp64,
        "wrong": _core.probe_device(device),
    }  # fmt: skip
    sys.stdout.write("\n" + json.dumps(report) + "\n")
    sys.stdout.flush()
    os._exit(0)  # drivers may crash while they are unloaded; the numbers are in


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
