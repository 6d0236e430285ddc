"""What only some systems have: signals and modules of the standard library, by name."""

import signal
from importlib import import_module
from typing import Any


def present(*names: str) -> tuple[signal.Signals, ...]:
    """Return those of the signals that this system has; what it does not have cannot come."""
    return tuple(signal.Signals(getattr(signal, name)) for name in names if hasattr(signal, name))


ENDS = present("SIGINT", "SIGQUIT", "SIGTERM", "SIGHUP", "SIGBREAK")
"""By which a person, a terminal or the system asks a program to end."""


def module_here(name: str) -> Any:
    """Return a module, or None where this system has no such module."""
    try:
        return import_module(name)
    except ImportError:
        return None
