"""One folder for the whole machine, the same for every account: who has a rig, and where its stop guard listens.

Next to nothing is imported here: a command that stops axes looks here before it does anything else.
"""

import os
from errno import ENOENT

PLACES = ("/run/lock", "/tmp")  # noqa: S108  every account must come to the same place, whatever its TMPDIR
"""The first that everybody may write to and nobody may delete another's files from."""
WINDOWS_PLACE = "PROGRAMDATA"
"""Environment variable of the folder that all accounts of a Windows machine share."""
OVERRIDE = "CALRIG_MACHINE_FOLDER"
"""Environment variable for another place: for tests, and for machines on which neither is shared."""
SHARED = 0o1777


def machine_folder(part: str) -> str:
    """Return the folder ``part`` of it, made where it is missing. Raises: OSError."""
    shared = [place for place in PLACES if _is_shared(place)]
    shared += [os.environ[WINDOWS_PLACE]] if os.name == "nt" and WINDOWS_PLACE in os.environ else []
    folder = os.environ.get(OVERRIDE) or next((f"{place}/calrig" for place in shared), None)
    if folder is None:
        raise OSError(ENOENT, f"no folder that all accounts share; set {OVERRIDE}", " and ".join(PLACES))
    for path in (folder, f"{folder}/{part}"):
        try:
            os.mkdir(path, 0o700)
        except FileExistsError:
            continue
        os.chmod(path, SHARED)  # past the umask: others put theirs beside, and cannot delete what is not theirs
    return f"{folder}/{part}"


def _is_shared(place: str) -> bool:
    try:
        return os.stat(place).st_mode & SHARED == SHARED
    except OSError:
        return False
