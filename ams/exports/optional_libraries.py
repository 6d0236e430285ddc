"""Libraries of the extras: loaded when something needs one, missed in a sentence."""

from collections.abc import Iterable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from ams.errors import SetError

EXTRA_OF = {
    "apprise": "alerts",
    "distributed": "cluster",
    "h5py": "export",
    "lxml": "certificate",
    "matplotlib": "report",
    "psycopg": "postgres",
    "pyarrow": "export",
    "pyvisa": "visa",
    "starlette": "console",
    "typst": "report",
    "uvicorn": "console",
    "websockets": "console",
    "xarray": "export",
}
"""Library to the extra of the installation that brings it."""


def library(name: str, where: str) -> Any:
    """Import an optional library. Raises: SetError where it is not installed."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise SetError(f"{where}: {missing_sentence(name, 'nothing was read or written')}") from error


def missing_sentence(name: str, so: str = "") -> str:
    """Say which library is not installed, what is so because of it, and what brings it."""
    top = name.partition(".")[0]
    brought_by = f"calrig[{EXTRA_OF[top]}]" if top in EXTRA_OF else top
    parts = (f"needs {top}, which is not installed", so, f"install it by: pip install '{brought_by}'")
    return "; ".join(filter(None, parts))


def not_installed(libraries: Iterable[str]) -> list[str]:
    """Return those of the libraries that are not installed."""
    return [name for name in libraries if not _is_installed(name)]


def _is_installed(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except (ImportError, ValueError):
        return False
