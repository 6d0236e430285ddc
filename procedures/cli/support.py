"""``calrig --version --json``: what somebody who is asked for help wants to know of an installation."""

import platform
import sys
from importlib.metadata import PackageNotFoundError, requires, version

from ams.exports.optional_libraries import EXTRA_OF
from procedures.cli.output import print_json
from procedures.cli.program_log import log_path


def tell_support() -> None:
    """Print the versions of calrig, Python, the system and every library (null: not there), and where the log is."""
    required = [line.partition(";")[0] for line in requires("calrig") or () if "extra ==" not in line]
    names = sorted({_name(line) for line in required})
    print_json(
        {
            "calrig": version("calrig"),
            "python": platform.python_version(),
            "executable": sys.executable,
            "system": platform.platform(),
            "log": None if (log := log_path()) is None else str(log),
            "libraries": {name: _version(name) for name in names},
            "extras": {name: _version(name) for name in sorted(EXTRA_OF)},
        }
    )


def _name(requirement: str) -> str:
    """Return the name that a requirement begins with."""
    return requirement.replace("[", " ").replace("<", " ").replace(">", " ").replace("=", " ").split()[0]


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
