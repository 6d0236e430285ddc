"""The stop guard of a rig: only where axes are on real ports, and only where others will find it; and its lines."""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from platformdirs import user_state_path

from rig.abilities.abilities import Axis, Stoppable
from rig.clock import SystemClock
from rig.description.device_settings import TWIN_PORT
from rig.description.rig_file import RigDescription
from rig.errors import RigBusy
from rig.guard.ask import FOLDER as GUARDS
from rig.guard.stop_guard import IS_POSSIBLE, GuardedLine, StopGuard
from rig.lines.lock import canonical
from rig.lines.open_lines import Lines
from rig.link.terminal_stream import TERMINAL
from rig.machine_folder import machine_folder
from rig.machine_room import require_room


def guarded_lines(description: RigDescription, axes: Mapping[str, Axis], lines: Lines) -> tuple[GuardedLine, ...]:
    """Return the lines of axes that somebody else can stop; a port is one line, whatever its names."""
    found: dict[str, GuardedLine] = {}
    for name, axis in axes.items() if IS_POSSIBLE else ():
        port = description.axes[name].port
        descriptor = None if port == TWIN_PORT else lines.descriptor(port)
        if descriptor is None or not isinstance(axis, Stoppable):
            continue
        line = found.get(canonical(port)) or GuardedLine(f"axes.{name}", port, descriptor, "rfc2217://" in port)
        found[canonical(port)] = replace(line, orders={**line.orders, name: tuple(axis.stop_steps())})
    return tuple(found.values())


def stop_guard(
    description: RigDescription, rig_file: Path | None, purpose: str, *, for_stop: bool = False
) -> StopGuard | None:
    """Return the guard of a rig with axes on real ports; its process begins with the first motion.

    Raises: RigBusy, unless ``for_stop``, where nobody would find it.
    """
    if not IS_POSSIBLE or not any(axis.port not in (TWIN_PORT, TERMINAL) for axis in description.axes.values()):
        return None
    rig = {"purpose": purpose, "rig_file": "" if rig_file is None else os.path.realpath(rig_file)}
    record = user_state_path("calrig") / "stop-guards" / f"{os.getpid()}.json"
    folder = None if for_stop else _folder_of_guards()
    return StopGuard(record, rig, folder, SystemClock())


def _folder_of_guards() -> Path:
    """Return where `calrig abort` and `jog --stop` look for a guard. Raises: RigBusy where it takes no file."""
    try:
        folder = Path(machine_folder(GUARDS))
    except OSError as error:
        raise RigBusy(
            f"{error.filename or error}: no folder for stop guards that all accounts share: {error.strerror}; nothing"
            " was opened"
        ) from error
    require_room(folder)
    return folder
