"""What watching finds, and what it leads to."""

from dataclasses import dataclass
from typing import Literal

Response = Literal["hold", "ask", "trip", "restart"]
"""``hold``: wait until it has cleared itself. ``ask``: wait for a person's ``continue``. ``trip``: end the process, a
person has to look. ``restart``: trust in positions or lines is lost, so begin anew: home, check set, its judgement."""

LINK = "link"
RECONNECT = frozenset({LINK, "suspend"})
"""Causes after which every line is opened anew before anything else."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """One finding."""

    cause: str
    """A word: ``interlock``, ``disk``, ``link quality``, ``motion``, ``device``, ``home``, ``suspend``, ``link``."""
    reason: str
    response: Response
    void_from_s: float | None = None
    """Dwells of this process that ended later (rig seconds) are taken back; None for none."""


class TrustLost(Exception):
    """Leaves an epoch: nothing goes on before the cause is gone and the axes are homed anew."""

    def __init__(self, cause: str, reason: str) -> None:
        super().__init__(reason)
        self.cause = cause
        self.reason = reason
