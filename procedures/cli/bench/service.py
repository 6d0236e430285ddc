"""``calrig service``: the systemd unit that resumes a run after a crash or a reboot, with the paths of this machine."""

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


def service(
    *,
    out: RunsFolder = RUNS,
    show: Annotated[bool, Parameter(negative=(), help="Print the unit; write nothing.")] = False,
) -> int:
    """Write the user's systemd unit: ``calrig@NAME`` resumes the run NAME of the folder of runs.

    The folders that it may write to are made, since it does not start without them. A unit of before is replaced.
    """
    program, runs, state = _program(), out.absolute(), user_state_path("calrig")
    for path in (program, str(runs), str(state)):
        if set(path) & set(" %\"'\\"):
            raise RequestError(
                f"service: {path}: has a space, a percent sign or a quote, which a unit would read as something else; "
                "nothing was written; give calrig and its runs plain paths"
            )
    text = unit_text(program, runs, state)
    if show:
        say(text.rstrip())
        return ExitStatus.DONE
    if not sys.platform.startswith("linux"):
        raise RequestError(
            "service: systemd is of Linux; nothing was written; --show prints the unit, whose command another system's "
            "services may take"
        )
    folder = user_config_path("systemd") / "user"
    for made in (folder, runs, state):
        made.mkdir(parents=True, exist_ok=True)
    write_whole(folder / NAME, text.encode("utf-8"))
    say(f"written: {folder / NAME}")
    say("now: systemctl --user daemon-reload && systemctl --user enable --now calrig@NAME")
    say("and once, so that it goes on after logout: loginctl enable-linger")
    return ExitStatus.DONE


def unit_text(program: str, runs: Path, state: Path) -> str:
    """Return the unit with its paths."""
    text = files("procedures.cli.bench").joinpath(NAME).read_text(encoding="utf-8")
    for mark, path in {"@CALRIG@": program, "@RUNS@": str(runs), "@STATE@": str(state)}.items():
        text = text.replace(mark, path)
    return text


def _program() -> str:
    """Return the command as it was called, or the one beside this Python. Raises: RequestError."""
    beside = Path(sys.executable).with_name("calrig")
    found = str(beside) if beside.exists() else shutil.which("calrig")
    if found is None:
        raise RequestError("service: no command calrig was found; nothing was written; install calrig with its command")
    return found
