"""Ask the stop guard of a rig for a stop, from a command that has imported nothing yet: the standard library only."""

import json
import os
import socket
from pathlib import Path

from rig.machine_folder import machine_folder

FOLDER = "guards"
ANSWER_S = 5.0


def guards() -> list[dict[str, str]]:
    """Return what every guard on this machine says of itself: socket, pid, purpose, rig_file, run."""
    try:
        names = sorted(os.listdir(machine_folder(FOLDER)))
    except OSError:
        return []
    found = []
    for name in names:
        if name.endswith(".json"):
            try:
                document = json.loads((machine_folder(FOLDER) / name).read_text(encoding="utf-8"))
            except (OSError, ValueError):
                continue
            if isinstance(document, dict) and "socket" in document:
                found.append(document)
    return found


def stop(guard: dict[str, str], axes: list[str] | None, by: str) -> dict[str, str] | None:
    """Have axes, or all of them, stopped now; what became of each, or None where that guard is gone."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
        line.settimeout(ANSWER_S)
        try:
            line.connect("\0" + guard["socket"])
            line.sendall(json.dumps({"axes": axes, "by": by}).encode())
            answer = b""
            while not answer.endswith(b"\n"):
                data = line.recv(65536)
                if not data:
                    return None
                answer += data
        except OSError:
            return None
    told: dict[str, str] = json.loads(answer)["told"]
    return told


def of_rig(rig_file: str) -> list[dict[str, str]]:
    """Return the guards of a rig file."""
    path = os.path.realpath(rig_file)
    return [guard for guard in guards() if guard.get("rig_file") == path]


def of_run(run: str | None, runs: Path) -> list[dict[str, str]]:
    """Return the guards of a run: its folder, its journal, its name under ``runs``; None is any run under ``runs``."""
    if run is None:
        return [guard for guard in guards() if guard.get("run") and Path(guard["run"]).parent == runs.resolve()]
    places = {Path(run).resolve(), Path(run).resolve().parent, (runs / run).resolve()}
    return [guard for guard in guards() if guard.get("run") and Path(guard["run"]) in places]
