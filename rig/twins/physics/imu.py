"""What a strapped-down sensor package feels: the source of the streaming twins."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Motion:
    """One instant, in package axes: x forward, y right, z down."""

    force_g: tuple[float, float, float] = (0.0, 0.0, -1.0)
    """Specific force, in local g: level it is −1 along z."""
    rate_dps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    field_ut: tuple[float, float, float] = (20.0, 0.0, 40.0)
    attitude_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Yaw, pitch, roll."""
    temperature_degc: float = 20.0


class MotionSource(Protocol):
    """The physical world as a package meets it."""

    def motion(self, stream: str, now_s: float) -> Motion:
        """Return what ``stream`` feels at ``now_s``, with its noise; asking again draws again."""
