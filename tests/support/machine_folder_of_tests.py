"""A machine to itself for each process of tests: who holds what, where guards listen, and what calrig keeps of a user.

Stored runs name the rig file that they began with; two sessions, or two workers, that resume one at the same moment
would refuse each other in the folder that all of a machine share.
"""

import os
import shutil
from pathlib import Path

from open_folder import make_open_folder

from rig.machine_folder import OVERRIDE


def enter_machine_folder() -> Path:
    """Have this process and its children share locks with nobody else; return the folder, to be removed at the end.

    Homes, defects and second journals of tests go there too, and not among those of whoever tests.
    """
    folder = make_open_folder()  # some tests become another account
    os.environ[OVERRIDE] = str(folder / "calrig")
    os.environ["XDG_STATE_HOME"] = str(folder / "state")
    return folder


def leave_machine_folder(folder: Path) -> None:
    """Remove what is left of it."""
    shutil.rmtree(folder, ignore_errors=True)
