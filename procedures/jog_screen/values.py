"""What the jog screen asks for and what it shows, as frozen values: the screen and the thread that owns the devices
share nothing else.
"""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from rig.abilities.abilities import AxisState
from rig.abilities.rates import MeasuredRate
from rig.local_time import local_hour

Tone = Literal["done", "refused", "failed", "stopped", "note"]


@dataclass(frozen=True, slots=True)
class Asker:
    """Who asks for a motion, and keeps it alive."""

    client: str
    """The terminal, or one page of a browser: leases are its own."""
    name: str = ""
    """Whom the log names; empty for the login that began the session."""
    address: str = ""
    """The address of the browser."""

    @property
    def is_page(self) -> bool:
        return self != AT_TERMINAL

    def to_log(self) -> dict[str, str]:
        """Return what the log says of who asked, beside the login."""
        return {"by": self.name, "via": "console", "place": self.address} if self.is_page else {}


AT_TERMINAL = Asker("terminal")


@dataclass(frozen=True, slots=True)
class GoTo:
    """Go to an attitude, or by a step from where the axis stands."""

    axis: str
    degrees: float
    is_step: bool = False

    def __str__(self) -> str:
        return f"{self.axis} {'by' if self.is_step else 'to'} {self.degrees:+g}°"


@dataclass(frozen=True, slots=True)
class Home:
    axis: str

    def __str__(self) -> str:
        return f"{self.axis} home"


@dataclass(frozen=True, slots=True)
class Turn:
    """Turn at a rate for as long as its lease is renewed."""

    axis: str
    rate_dps: float
    is_held: bool
    """By a key that must go on repeating; otherwise by a terminal that must go on answering."""

    def __str__(self) -> str:
        return f"{self.axis} at {self.rate_dps:+g} °/s"


@dataclass(frozen=True, slots=True)
class Pulse:
    axis: str
    pulse_us: float

    def __str__(self) -> str:
        return f"{self.axis} to a pulse of {self.pulse_us:g} µs"


@dataclass(frozen=True, slots=True)
class HoldTemperature:
    chamber: str
    setpoint_degc: float

    def __str__(self) -> str:
        return f"{self.chamber} to {self.setpoint_degc:g} °C"


@dataclass(frozen=True, slots=True)
class Snapshot:
    def __str__(self) -> str:
        return "snapshot"


@dataclass(frozen=True, slots=True)
class ClearStatistics:
    def __str__(self) -> str:
        return "statistics from here"


Request = GoTo | Home | Turn | Pulse | HoldTemperature | Snapshot | ClearStatistics
MOTIONS = (GoTo, Home, Turn, Pulse)


@dataclass(frozen=True, slots=True)
class AxisView:
    """One axis as the bench last saw it."""

    name: str
    limits_deg: tuple[float, float]
    steps_deg: tuple[float, ...]
    top_rate_dps: float
    """0 where the axis only positions."""
    state: AxisState | None = None
    """None before the first look."""
    pulse_us: float | None = None
    """Of a servo's calibration, at its position."""
    wound_turns: float | None = None
    """How far its cables are wound; None where none wind up, NaN where nobody knows."""
    target_deg: float | None = None
    set_rate_dps: float | None = None
    measured: MeasuredRate | None = None
    silence: str = ""
    """Why it cannot be looked at."""


@dataclass(frozen=True, slots=True)
class ChannelView:
    """The readings of one channel since the statistics began."""

    name: str
    count: int = 0
    unit: str = "v"
    """Of its readings, as it is written in a key."""
    mean: float = float("nan")
    standard_deviation: float = float("nan")
    overloads: int = 0
    recent: tuple[float, ...] = ()
    silence: str = ""


@dataclass(frozen=True, slots=True)
class ChamberView:
    name: str
    limits_degc: tuple[float, float]
    temperature_degc: float | None = None
    setpoint_degc: float | None = None
    silence: str = ""


@dataclass(frozen=True, slots=True)
class AttitudeView:
    """What a coefficient set makes of the means."""

    sensor: str
    angles: tuple[tuple[str, float, float], ...] = ()
    """Name, degrees, standard deviation in degrees; NaN where the outputs do not tell."""
    flag: str = ""


@dataclass(frozen=True, slots=True)
class ShownMessage:
    """One line of what happened."""

    clock: str
    """Local."""
    tone: Tone
    text: str


def message_at(moment_utc: datetime, tone: Tone, text: str) -> ShownMessage:
    """Return a line of what happened at that moment."""
    return ShownMessage(local_hour(moment_utc), tone, text)


@dataclass(frozen=True, slots=True)
class BenchView:
    axes: tuple[AxisView, ...]
    channels: tuple[ChannelView, ...]
    chambers: tuple[ChamberView, ...]
    attitude: AttitudeView | None = None
    doing: str = ""
    """The motion under way; empty when nothing moves by command."""
    is_stopping: bool = False
    waits_for: str = ""
    """The device that keeps everything else waiting, and what to do; empty where nothing here is old."""
    messages: tuple[ShownMessage, ...] = ()
