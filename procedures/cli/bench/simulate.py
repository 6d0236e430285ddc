"""``calrig simulate``: a rig's twins on real ports, for other programs and for rehearsals across processes."""

import json
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from ams.whole_file import write_whole
from procedures.cli.bench.stopping import stoppable_wait
from procedures.cli.options import Flag, require_folder_of
from procedures.cli.output import note
from procedures.errors import RequestError
from rig.assembly.faulty_lines import drivers_of
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock
from rig.description.fault_plan import read_faults
from rig.description.read import read_rig
from rig.errors import WaitEnded


def simulate(
    rig: Path,
    /,
    *,
    time_factor: float | None = None,
    write: Path | None = None,
    pty: Flag = False,
    faults: Path | None = None,
) -> None:
    """Serve the twins of a rig on real ports until stopped (Ctrl-C or SIGTERM).

    First prints one JSON line with the addresses: by table of the rig file, and "twin" for the control address.

    Parameters
    ----------
    rig
        The rig file; every device of it is served as its twin, wherever the file says it is.
    time_factor
        How many times faster than real time the twins live; 1 by default.
    write
        Write the rig file with these addresses filled in, ready for `calrig run --rig`.
    pty
        Pseudo-terminals for the devices instead of TCP ports.
    faults
        A file of what goes wrong on the lines, with power and with motion; each fault is told on standard error as it
        happens. With --pty the addresses are then stable names, which stay when a port comes back as another node.
    """
    if time_factor is not None and not 0.0 < time_factor <= 1e6:
        raise RequestError(
            f"simulate: --time-factor: got {time_factor:g}, allowed above 0 up to 1e6; nothing was served"
        )
    require_folder_of(write, "--write")
    if write is not None and write.resolve() == rig.resolve():
        raise RequestError(f"simulate: --write {write}: is the rig file itself; give another name; nothing was served")
    description = read_rig(rig)
    plan = None if faults is None else read_faults(faults, drivers_of(description))
    clock = SystemClock() if time_factor is None else ScaledClock(time_factor)
    with ExitStack() as kept:
        links = Path(kept.enter_context(TemporaryDirectory(prefix="calrig-ports-"))) if plan and pty else None
        served = kept.enter_context(serve_rig(description, clock, pty=pty, links=links, faults=plan, tell=note))
        if write is not None:
            write_rig(rig, served.addresses, "real" if time_factor is None else float(time_factor), write, write_whole)
        print(json.dumps(served.addresses), flush=True)  # noqa: T201
        try:
            with stoppable_wait(SystemClock()) as wait:
                while served.is_serving:
                    wait(0.1)
        except WaitEnded:
            return
