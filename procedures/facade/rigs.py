"""``calrig.run`` and ``calrig.simulate``: a run in a process of its own, and the twins of a rig on real ports."""

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile

from procedures.data.run_data import RunData, read_run
from procedures.errors import RequestError, RunFailed
from procedures.facade.planning import PlannedRun, Tables, plan
from rig.assembly.simulate import serve_rig
from rig.clock import ScaledClock, SystemClock
from rig.description.read import read_rig

_COMMAND = (sys.executable, "-m", "procedures.cli.main", "run")


def run(
    procedure: str | Path | Tables | PlannedRun,
    rig: str | Path | None = None,
    *,
    out: str | Path = "runs",
    operator: str | None = None,
    rehearse: bool = False,
    archive: str | None = None,
) -> RunData:
    """Run a procedure to its end as ``calrig run`` does, and read it; what the run says stands on standard error.

    ``procedure``: a file, its tables as mappings, or what :func:`calrig.plan` returned, which knows its rig.

    The run has a process of its own: a notebook that dies ends nothing, ``calrig status`` and ``calrig stop`` steer it,
    and an interrupt of the notebook stops it after the dwell in progress.

    Raises: RequestError where nothing was begun; RunFailed where it did not finish, which ``calrig resume`` continues.
    """
    if isinstance(procedure, PlannedRun):
        if rig is not None:
            raise RequestError("run: a plan knows its rig; nothing was begun; leave the rig out, or plan with another")
        with procedure.procedure_file() as file:
            return run(file, procedure.rig, out=out, operator=operator, rehearse=rehearse, archive=archive)
    if rig is None:
        raise RequestError("run: a procedure needs a rig file; nothing was begun; give its path")
    if not isinstance(procedure, str | Path):
        return run(plan(procedure, rig), out=out, operator=operator, rehearse=rehearse, archive=archive)
    options = {"--operator": operator, "--archive": archive}
    given = [word for name, value in options.items() if value is not None for word in (name, value)]
    command = [*_COMMAND, str(procedure), "--rig", str(rig), "--out", str(out), "--json", *given]
    said: list[str] = []
    with (
        TemporaryFile("w+", encoding="utf-8") as document,
        subprocess.Popen(  # noqa: S603  this very Python, and paths that are the caller's own
            [*command, *(["--rehearse"] if rehearse else [])],
            stdout=document,
            stderr=subprocess.PIPE,
            encoding="utf-8",
        ) as process,
    ):
        assert process.stderr is not None
        for line in process.stderr:
            said.append(line.rstrip())
            print(said[-1], file=sys.stderr)  # noqa: T201  a script hears what a terminal would
        process.wait()
        document.seek(0)
        written = document.read()
    last = said[-1].removeprefix("calrig: ") if said else f"exit status {process.returncode}"
    if not written:
        raise RequestError(last)
    found = json.loads(written)
    if found["state"] != "finished":
        raise RunFailed(f"{found['run']}: the run is {found['state']}: {last}; calrig resume continues it")
    return read_run(found["run"])


@contextmanager
def simulate(rig: str | Path, *, time_factor: float | None = None) -> Iterator[Mapping[str, str]]:
    """Serve the twins of a rig on TCP ports; yields the addresses, by table of the rig file and ``twin``.

    ``time_factor``: how many times faster than real time the twins live. Raises: rig.errors.DescriptionError.
    """
    if time_factor is not None and not 0.0 < time_factor <= 1e6:
        raise RequestError(f"simulate: time_factor: got {time_factor:g}, allowed above 0 up to 1e6; nothing was served")
    clock = SystemClock() if time_factor is None else ScaledClock(time_factor)
    with serve_rig(read_rig(Path(rig)), clock) as served:
        yield served.addresses
