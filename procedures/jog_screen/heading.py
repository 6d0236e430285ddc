"""What stands above the jog screen: the rig, whose time it is, who owns it, where its actions are written."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Heading:
    rig: str
    time: str
    """The machines' time, or the twins'."""
    owner: str
    """Who holds the rig."""
    log: str
    sensors: Mapping[str, frozenset[str]] = field(default_factory=dict)
    """Sensor to its channels: the readings of one can be looked at alone."""
