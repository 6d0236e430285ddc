"""The stop guard of a rig: only where axes are on real ports, and only where others will find it."""

import os
from pathlib import Path

from platformdirs import user_state_path

from rig.clock import SystemClock
from rig.description.device_settings import TWIN_PORT
from rig.description.rig_file import RigDescription
from rig.errors import RigBusy
from rig.guard.ask import FOLDER as GUARDS
from rig.guard.stop_guard import IS_POSSIBLE, StopGuard
from rig.link.terminal_stream import TERMINAL
from rig.machine_folder import machine_folder
from rig.machine_room import require_room


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
