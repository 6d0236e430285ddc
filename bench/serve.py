"""The other side of a line in a process of its own, so that only the driver's work is measured.

``python -m bench.serve rig FILE``: the twins of a rig on pseudo-terminals in real time; prints their addresses as JSON.
``python -m bench.serve text HZ``: a pseudo-terminal that sends ``n,a,b,c,d`` so many times a second; prints its path.
Both end with their standard input.
"""

import json
import os
import select
import sys
import tty
from pathlib import Path

from rig.assembly.simulate import serve_rig
from rig.clock import SystemClock
from rig.description.read import read_rig

assert sys.platform != "win32", "there are no pseudo-terminals"
WRAPS = 65536
_PIECE_S = 0.002


def serve_twins(path: Path) -> None:
    with serve_rig(read_rig(path), SystemClock(), pty=True) as served:
        print(json.dumps(served.addresses), flush=True)
        sys.stdin.read()


def serve_text(rate_hz: float) -> None:
    """From the first byte it is sent on; late pieces are made good, as a board's own clock would."""
    master, slave = os.openpty()
    tty.setraw(slave)
    print(os.ttyname(slave), flush=True)
    clock, sent = SystemClock(), 0
    os.read(master, 1)
    began_s = clock.monotonic_s()
    while not select.select([sys.stdin], [], [], 0)[0]:
        due = int((clock.monotonic_s() - began_s) * rate_hz)
        lines = b"".join(b"%d,%d,-1330,14,625\r\n" % (n % WRAPS, n % 2000 - 1000) for n in range(sent, due))
        while lines:
            lines = lines[os.write(master, lines) :]
        sent = due
        clock.sleep(_PIECE_S)


if __name__ == "__main__":
    kind, argument = sys.argv[1:]
    serve_twins(Path(argument)) if kind == "rig" else serve_text(float(argument))
