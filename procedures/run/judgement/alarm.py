"""What watching finds, and what it leads to."""

from dataclasses import dataclass
from typing import Literal

from rig.errors import DeviceNonsense, DeviceSilent, LinkClosed, LinkLost

Response = Literal["hold", "ask", "trip", "restart"]
"""``hold``: wait until it has cleared itself. ``ask``: wait for a person's ``continue``. ``trip``: end the process, a
person has to look. ``restart``: trust in positions or lines is lost, so begin anew: home, check set, its judgement."""

CHAMBER = "chamber"
"""The cause where a chamber refused."""
LINK = "link"
RECONNECT = frozenset({LINK, "suspend"})
"""Causes after which every line is opened anew before anything else."""
LOST = (LinkLost, LinkClosed, DeviceSilent, DeviceNonsense)
"""Errors after which a line is not trusted before it was opened anew."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """One finding."""

    cause: str
    """A word: ``interlock``, ``disk``, ``link quality``, ``motion``, ``device``, ``home``, ``suspend``, ``link``."""
    reason: str
    response: Response
    void_from_s: float | None = None
    """Dwells of this process that ended later (rig seconds) are taken back; None for none."""
    band: str = ""
    """The interlock that found it, by its name in the rig file; empty of anything else."""


def lost_link(error: Exception) -> Alarm:
    return Alarm(LINK, f"link lost: {error}", "restart")


class TrustLost(Exception):
    """Leaves an epoch: nothing goes on before the cause is gone and the axes are homed anew."""

    def __init__(self, cause: str, reason: str) -> None:
        super().__init__(reason)
        self.cause = cause
        self.reason = reason
