"""What stands above the jog screen: the rig, whose time it is, who owns it, where its actions are written."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Heading:
    rig: str
    time: str
    """The machines' time, or the twins'."""
    owner: str
    """Who holds the rig."""
    log: str
