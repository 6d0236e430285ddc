"""The commands by which a person has dwells of a run measured again, as findings print them."""

from typing import Final

_IN_WHOSE_NAME: Final = "--operator NAME --reason TEXT"
"""Without these ``redo`` and ``void`` are refused."""


def redo_command(replication: int | str, run: str = "") -> str:
    """Return the command that measures a replication again, whole; without a run it is for the one of the folder."""
    return f"calrig redo {run}{' ' if run else ''}--replication {replication} {_IN_WHOSE_NAME}"


def void_command(step: int | str, run: str = "") -> str:
    """Return the command that takes back a step and all after it, whole."""
    return f"calrig void {run}{' ' if run else ''}--from {step} {_IN_WHOSE_NAME}"
