"""Ask the stop guard of a rig for a stop, from a command that has imported nothing yet.

Next to nothing is imported here either, not even what reads JSON or paths: under load each of those costs as long as
the whole question. So a guard's file is lines of text, and so are question and answer.
"""

import _signal  # type: ignore[import-not-found]  # of the interpreter itself; signal takes longer to import
import _socket
import os

from rig.machine_folder import machine_folder

FOLDER, SUFFIX = "guards", ".guard"
FORMAT = "calrig stop guard 1"
"""Of the record that a guard leaves of what it did."""
KEYS = ("socket", "pid", "purpose", "rig_file", "run")
"""What a guard's file says, one a line."""
ANSWER_S = 5.0


def guards() -> list[dict[str, str]]:
    """Return what every guard on this machine says of itself."""
    try:
        folder = machine_folder(FOLDER)
        names = sorted(os.listdir(folder))
    except OSError:
        return []
    found = []
    for name in names:
        if name.endswith(SUFFIX):
            try:
                with open(f"{folder}/{name}", encoding="utf-8") as file:
                    lines = file.read(65536).split("\n")
            except (OSError, ValueError):
                continue
            if len(lines) > len(KEYS):
                found.append(dict(zip(KEYS, lines, strict=False)))
    return found


def stop(guard: dict[str, str], axes: list[str] | None, by: str) -> dict[str, str] | None:
    """Have axes, or all of them, stopped now; what became of each, or None where that guard is gone.

    A guard that somebody froze is woken: it holds the lines, and nobody else could send a stop.
    """
    family = getattr(_socket, "AF_UNIX", None)
    if family is None:
        return None  # a system without a guard
    _wake(guard)
    line = _socket.socket(family, _socket.SOCK_STREAM)
    answer = b""
    try:
        line.settimeout(ANSWER_S)
        line.connect("\0" + guard["socket"])
        line.send("\n".join((" ".join(by.split()), "\t".join(axes or ()), "")).encode())
        while data := line.recv(65536):
            answer += data
    except OSError:
        return None
    finally:
        line.close()
    outcomes = dict(line.split("\t", 1) for line in answer.decode().splitlines() if "\t" in line)
    return outcomes or None


def _wake(guard: dict[str, str]) -> None:
    """Its own number ends the name of its socket. Whoever runs already does not notice."""
    try:
        os.kill(int(guard["socket"].rpartition("-")[2]), _signal.SIGCONT)
    except (OSError, ValueError):
        return


def of_rig(rig_file: str) -> list[dict[str, str]]:
    """Return the guards of a rig file."""
    path = os.path.realpath(rig_file)
    return [guard for guard in guards() if guard["rig_file"] == path]


def of_run(run: str | None, runs: str) -> list[dict[str, str]]:
    """Return the guards of a run: its folder, its journal, its name under ``runs``; None is any run under ``runs``."""
    running = [guard for guard in guards() if guard["run"]]
    if run is None:
        return [guard for guard in running if os.path.dirname(guard["run"]) == os.path.realpath(runs)]
    path = os.path.realpath(run)
    folders = {path, os.path.dirname(path), os.path.realpath(f"{runs}/{run}")}
    return [guard for guard in running if guard["run"] in folders]
