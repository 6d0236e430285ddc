"""What a chamber tells of its alarms: asked between dwells, named in a hold or a trip, and told when it changes.

A chamber in alarm may hold its air in its band for hours, or switch its outputs off and let it drift; many alarms of a
ramp mean nothing at all (a deviation while it is on its way). So an alarm is told, and ends no run by itself.
"""

from typing import Protocol, runtime_checkable

from rig.errors import RigError


@runtime_checkable
class TellsAlarms(Protocol):
    """An environment whose controller tells the alarms that stand."""

    def alarms(self) -> tuple[str, ...]:
        """Return the alarms that stand, a few words each with the device's own number. Raises: RigError."""


def alarm_clause(environment: object) -> str:
    """Return the alarms that stand as a clause behind a sentence; empty: none, or it cannot be asked."""
    if not isinstance(environment, TellsAlarms):
        return ""
    try:
        alarms = environment.alarms()
    except RigError:  # what is told already is worse, or comes again at the next question
        return ""
    return f"; the chamber tells {' and '.join(alarms)}" if alarms else ""
