"""Peak memory of a 4096 x 4096 frame with everything asked for, in a child process, and how soon Ctrl-C stops one.

python benchmarks/memory.py
"""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import time

from common import table

FRAME = """
import resource, implicitrt as irt
f = irt.render(irt.surfaces["barth_sextic"], size=(4096, 4096))
assert f.rgb.shape == (4096, 4096, 3) and f.normal.shape == (4096, 4096, 3)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
LONG = """
import implicitrt as irt
irt.render("x", size=(8, 8))
print("ready", flush=True)
irt.render("sin(30*x)*sin(30*y)*sin(30*z) + 0.9999", size=(8192, 8192), method="ia")
"""


def main() -> None:
    """Prints the table."""
    done = subprocess.run([sys.executable, "-c", FRAME], capture_output=True, text=True, check=True)
    peak = int(done.stdout) / 1024**2
    child = subprocess.Popen([sys.executable, "-c", LONG], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None
    child.stdout.readline()
    time.sleep(2)
    assert child.poll() is None, "the long frame ended too soon"
    started = time.perf_counter()
    child.send_signal(signal.SIGINT)
    _, error = child.communicate()
    stopped = time.perf_counter() - started
    assert "KeyboardInterrupt" in error, error[-500:]
    print(
        table(
            ("what", "measured"),
            [("peak resident, 4096 x 4096", f"{peak:.2f} GiB"), ("Ctrl-C to exit", f"{stopped:.2f} s")],
        )
    )
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024**2 < 1.5


if __name__ == "__main__":
    main()
