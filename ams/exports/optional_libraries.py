"""Libraries of the extra ``export``: loaded when a format needs one, missed in a sentence."""

from importlib import import_module
from typing import Any

from ams.errors import SetError


def library(name: str, where: str) -> Any:
    """Import an optional library. Raises: SetError where it is not installed."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise SetError(
            f"{where}: needs {name.split('.')[0]}, which is not installed; nothing was read or written; "
            "install it by: pip install 'calrig[export]'"
        ) from error
