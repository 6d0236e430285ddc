"""One folder for the whole machine, the same for every account: who has a rig, and where its stop guard listens.

Nothing but the standard library is imported here: a command that stops axes looks here before it does anything else.
"""

import os
import stat
from pathlib import Path

PLACES = (Path("/run/lock"), Path("/tmp"))  # noqa: S108  every account must come to the same place, whatever its TMPDIR
"""The first that everybody may write to and nobody may delete another's files from."""
OVERRIDE = "CALRIG_MACHINE_FOLDER"
"""Environment variable for another place: for tests, and for machines on which neither is shared."""
_SHARED = stat.S_ISVTX | stat.S_IRWXU | stat.S_IRWXG | stat.S_IRWXO


def machine_folder(part: str) -> Path:
    """Return the folder ``part`` of it, made where it is missing. Raises: OSError."""
    chosen = os.environ.get(OVERRIDE)
    places = [Path(chosen)] if chosen else [place / "calrig" for place in PLACES if _is_shared(place)]
    if not places:
        raise OSError(f"no folder that all accounts share: {' and '.join(map(str, PLACES))}; set {OVERRIDE}")
    folder = places[0]
    for path in (folder, folder / part):
        try:
            path.mkdir(mode=0o700)
        except FileExistsError:
            continue
        path.chmod(_SHARED)  # past the umask: others put theirs beside, and cannot delete what is not theirs
    return folder / part


def _is_shared(place: Path) -> bool:
    try:
        mode = place.stat().st_mode
    except OSError:
        return False
    return mode & _SHARED == _SHARED
