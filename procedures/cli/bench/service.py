"""``calrig service``: the systemd units that resume a run after a crash or a reboot, and that run a queue."""

import platform
import shutil
import sys
from importlib.resources import files
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from platformdirs import user_config_path, user_state_path

from ams.whole_file import write_whole
from procedures.cli.options import RUNS, RunsFolder
from procedures.cli.output import say
from procedures.errors import ExitStatus, RequestError

NAME = "calrig@.service"
QUEUE_NAME = "calrig-queue.service"


def service(
    *,
    out: RunsFolder = RUNS,
    queue: Annotated[
        Path | None, Parameter(help="A rig file: the unit of the runner of its queue instead of that of runs.")
    ] = None,
    show: Annotated[bool, Parameter(negative=(), help="Print the unit; write nothing.")] = False,
) -> int:
    """Write the user's systemd unit: ``calrig@NAME`` resumes the run NAME of the folder of runs.

    With --queue it is that of the runner of a queue, which starts what is due. The folders that a unit may write to
    are made, since it does not start without them. A unit of before is replaced.
    """
    program, runs, state = _program(), out.absolute(), user_state_path("calrig")
    rig = None if queue is None else queue.absolute()
    if rig is not None and not rig.is_file():
        raise RequestError(f"service: --queue {queue}: no rig file is there; nothing was written; check the path")
    for path in (program, str(runs), str(state), str(rig or "")):
        if set(path) & set(" %\"'\\"):
            raise RequestError(
                f"service: {path}: has a space, a percent sign or a quote, which a unit would read as something else; "
                "nothing was written; give calrig and its runs plain paths"
            )
    name = NAME if rig is None else QUEUE_NAME
    text = unit_text(program, runs, state, rig)
    if show:
        say(text.rstrip())
        return ExitStatus.DONE
    if platform.system() != "Linux":
        raise RequestError(
            "service: systemd is of Linux; nothing was written; --show prints the unit, whose command another system's "
            "services may take"
        )
    folder = user_config_path("systemd") / "user"
    for made in (folder, runs, state):
        made.mkdir(parents=True, exist_ok=True)
    write_whole(folder / name, text.encode("utf-8"))
    say(f"written: {folder / name}")
    unit = "calrig@NAME" if rig is None else name
    say(f"now: systemctl --user daemon-reload && systemctl --user enable --now {unit}")
    if rig is None:
        say(f"NAME is the folder of a run in {runs}; calrig status --all lists them")
    say("and once, so that it goes on after logout: loginctl enable-linger")
    return ExitStatus.DONE


def unit_text(program: str, runs: Path, state: Path, rig: Path | None = None) -> str:
    """Return the unit with its paths; ``rig``: of the queue's rig file, for the unit of its runner."""
    template = files("procedures.cli.bench").joinpath(NAME if rig is None else QUEUE_NAME)
    text = template.read_text(encoding="utf-8")
    for mark, path in {"@CALRIG@": program, "@RUNS@": str(runs), "@STATE@": str(state), "@RIG@": str(rig)}.items():
        text = text.replace(mark, path)
    return text


def _program() -> str:
    """Return the command as it was called, or the one beside this Python. Raises: RequestError."""
    beside = Path(sys.executable).with_name("calrig")
    found = str(beside) if beside.exists() else shutil.which("calrig")
    if found is None:
        raise RequestError("service: no command calrig was found; nothing was written; install calrig with its command")
    return found
