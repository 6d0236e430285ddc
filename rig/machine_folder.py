"""One folder for the whole machine, the same for every account: who has a rig, and where its stop guard listens.

Next to nothing is imported here: a command that stops axes looks here before it does anything else.
"""

import os
from errno import ENOENT

FOLDERS = ("/run/lock", "/tmp")  # noqa: S108  every account must come to the same place, whatever its TMPDIR
"""The first that everybody may write to and nobody may delete another's files from."""
WINDOWS_FOLDER = "PROGRAMDATA"
"""Environment variable of the folder that all accounts of a Windows machine share."""
OVERRIDE = "CALRIG_MACHINE_FOLDER"
"""Environment variable for another place: for tests, and for machines on which neither is shared."""
SHARED = 0o1777


def machine_folder(part: str) -> str:
    """Return the folder ``part`` of it, made where it is missing. Raises: OSError."""
    shared = [parent for parent in FOLDERS if _is_shared(parent)]
    shared += [os.environ[WINDOWS_FOLDER]] if os.name == "nt" and WINDOWS_FOLDER in os.environ else []
    folder = os.environ.get(OVERRIDE) or next((f"{parent}/calrig" for parent in shared), None)
    if folder is None:
        raise OSError(ENOENT, f"no folder that all accounts share; set {OVERRIDE}", " and ".join(FOLDERS))
    for path in (folder, f"{folder}/{part}"):
        try:
            os.mkdir(path, 0o700)
        except FileExistsError:
            continue
        os.chmod(path, SHARED)  # past the umask: others put theirs beside, and cannot delete what is not theirs
    return f"{folder}/{part}"


def _is_shared(folder: str) -> bool:
    try:
        return os.stat(folder).st_mode & SHARED == SHARED
    except OSError:
        return False
