"""Signals by name: Windows has few of them, and what a system does not have cannot come."""

import signal


def present(*names: str) -> tuple[signal.Signals, ...]:
    """Return those of the signals that this system has."""
    return tuple(signal.Signals(getattr(signal, name)) for name in names if hasattr(signal, name))
