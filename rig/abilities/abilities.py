"""What a device can do, as protocols with few methods, named by ability.

The engine, the jog and the checks know these and no driver. A driver holds a link, never a raw port, and waits
only through the :class:`Wait` that it is given: that is how a stop reaches it within a tenth of a second.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from rig.clock import Clock

WriteFile = Callable[[Path, bytes], object]
"""Give a file this content, whole and synced, or leave it as it was; handed in by its opener. Raises: OSError."""


class Wait(Protocol):
    """Lets rig time pass in slices; raises :class:`rig.errors.WaitEnded` when a stop was asked for."""

    def __call__(self, duration_s: float) -> None: ...


@dataclass(frozen=True, slots=True)
class AxisState:
    """One look at an axis: its own read-back, never the commanded value."""

    position_deg: float
    """Attitude angle (sign and zero of the description applied), degrees."""
    is_moving: bool
    is_homed: bool
    is_seated: bool
    """Curvic teeth engaged and locked; true where the machine has no such coupling."""
    fault: str
    """The device's own fault words; empty when there is none."""
    awaits_operator: bool = False
    """A person was asked to move it and has not answered: no time limit applies."""
    unknown: str = ""
    """Why nobody knows where it stands, such as a servo without a pulse; ``position_deg`` says nothing then."""
    is_led: bool = False
    """``position_deg`` is where the machine holds it, as the pulse of a servo: an order changes it, and no hand."""


class Axis(Protocol):
    """An axis that goes to absolute positions."""

    name: str
    limits_deg: tuple[float, float]
    increment_deg: float
    """Smallest step of the machine; every target is a multiple of it. 0 where continuous."""
    speed_dps: float
    approach_deg: float
    """One-sided approach: arrive from this much away (signed, 0 for none)."""
    arrival_tolerance_deg: float

    def identify(self) -> str:
        """Ask the device who it is. Raises: DeviceSilent, DeviceNonsense, LinkLost."""

    def home(self) -> None:
        """Start the reference move and see it taken up; poll :meth:`state` until homed and at rest.

        Raises where it may have been lost on the line: an axis that never began is not homed by resting.
        """

    def check_target(self, target_deg: float) -> None:
        """Raise RequestRefused unless ``target_deg`` is finite, inside limits and on the increment."""

    def start_move(self, target_deg: float) -> None:
        """Start an absolute move after :meth:`check_target` and a homed check; returns at the acknowledgement."""

    def state(self) -> AxisState:
        """Ask the device for position and state."""

    def stop(self) -> None:
        """Stop the axis now; harmless when it is at rest."""


@dataclass(frozen=True, slots=True)
class TurnLook:
    """Where a turning axis was at one moment, by its own read-back."""

    angle_deg: float
    """Cumulative attitude angle: it goes on beyond a revolution. Degrees."""
    taken_s: float
    """Rig seconds (monotonic), the middle of question and answer."""
    uncertainty_s: float
    """Half the time from question to answer: the moment lies within ± this."""


class RateAxis(Protocol):
    """An axis that turns at a constant rate."""

    name: str
    top_rate_dps: float
    """Largest rate either way."""

    def check_rate(self, rate_dps: float) -> None:
        """Raise RequestRefused unless ``rate_dps`` is finite, not 0 and within ± ``top_rate_dps``."""

    def start_rate(self, rate_dps: float) -> None:
        """Start turning after :meth:`check_rate` and a homed check; returns at the acknowledgement."""

    def turn_look(self, clock: Clock) -> TurnLook:
        """Ask for the cumulative angle, timed by the rig's clock.

        The measured rate is the angle between two looks over their time.
        """

    def state(self) -> AxisState:
        """Ask the device for position and state."""

    def stop(self) -> None:
        """Stop the axis now; harmless when it is at rest."""


@runtime_checkable
class Remembering(Protocol):
    """An axis whose machine keeps its home from one connection to the next without a word for it, but can prove it."""

    name: str

    def state(self) -> AxisState:
        """Return the state, as :meth:`Axis.state` does."""

    def home_mark(self) -> Mapping[str, float]:
        """Return what the machine will be compared with; asked of an axis that rests homed."""

    def resume_home(self, mark: Mapping[str, float], away_s: float) -> str:
        """Take over the home that a connection saw ``away_s`` rig seconds ago; empty, or why the machine disproves it.

        Nothing moves.
        """


@runtime_checkable
class Watchdog(Protocol):
    """An axis whose machine stops by itself when its host falls silent: nobody may be left to stop it."""

    name: str
    watchdog_s: float | None
    """So long a silence is allowed, rig seconds; None where the rig file declares none, then nothing here is called."""

    def arm_watchdog(self, wait: Wait) -> str:
        """Arm the watchdog and prove it; return what was seen, for the record.

        The time-out is set where it can be, then silence is kept at rest until the machine must have noticed. Positions
        may be lost by it: home afterwards.

        Raises: DeviceFault where the machine did not notice, or noticed too early.
        """

    def feed_watchdog(self) -> None:
        """Speak to the machine, and see that it is still armed where that can be read.

        Raises: DeviceFault where it is not; DeviceSilent, DeviceNonsense, LinkLost.
        """

    def disarm_watchdog(self) -> None:
        """Leave the machine at rest: where it can be told so, it need not notice."""


@dataclass(frozen=True, slots=True)
class ServoAim:
    """How a servo is sent to where it is, by who has its line alone: its controller is asked for its pulse."""

    channel: int
    device: int | None
    has_crc: bool
    limits: tuple[int, int]
    """Of the channel's pulse, quarter-microseconds: nothing beyond is sent."""
    patience_s: float
    """The longest that an answer takes: so long the line must be silent before it is asked."""


@dataclass(frozen=True, slots=True)
class StopStep:
    """Bytes that help to stop an axis, whoever sends them, without an answer being needed."""

    send: bytes
    pause_s: float = 0.0
    """Silence behind them."""
    aim: ServoAim | None = None
    """What ends the motion where ``send`` only slows it."""

    def document(self) -> dict[str, object]:
        """Return it as the stop guard reads it."""
        document: dict[str, object] = {"send": self.send.hex(), "pause_s": self.pause_s}
        if self.aim is not None:
            document["aim"] = asdict(self.aim)
        return document


@runtime_checkable
class Stoppable(Protocol):
    """An axis whose stop can be sent by somebody else: the stop guard (:mod:`rig.guard`)."""

    name: str

    def stop_steps(self) -> Sequence[StopStep]:
        """Return what stops it, in order; harmless when it is at rest and when it is sent again."""


@runtime_checkable
class AimedStop(Protocol):
    """An axis that is stopped by being sent to where it is: an answer that is off its way must not send it there."""

    name: str

    def stop_way(self, target_deg: float) -> tuple[int, int] | None:
        """Return from where to where an order to ``target_deg`` moves it now, in the units of its :class:`ServoAim`.

        None where it is not known where it is.
        """


@dataclass(frozen=True, slots=True)
class Burst:
    """Readings of one channel in the order taken."""

    channel: str
    samples: NDArray[np.float64]
    """Shape (n,), in ``unit``. An overloaded reading is NaN here and true in ``overload``."""
    overload: NDArray[np.bool_]
    """Shape (n,)."""
    started_s: float
    """Rig seconds (monotonic) when the first reading was triggered."""
    interval_s: float
    """Rig seconds between readings."""
    unit: str = "v"
    """As it is written in a key; volts of every meter, a stream names its own."""


class Readout(Protocol):
    """An instrument that reads named channels on demand."""

    name: str
    channels: tuple[str, ...]

    def identify(self) -> str:
        """Return the identity of every box behind the readout, one line."""

    def prepare(self) -> None:
        """Clear, reset and configure for the run; read back what can be read back."""

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        """Read ``samples`` readings of ``channel`` (``nplc`` None: the description's).

        The channel that is closed is read back before the first reading. Cleared and left quiet when ``wait`` raises.
        """

    def reading_s(self, nplc: float | None = None) -> float:
        """Return the expected seconds for one reading."""

    def checks(self) -> Mapping[str, float]:
        """Return slow own readings for the record, such as ``{"meter_temperature_degc": 36.1}``."""


@dataclass(frozen=True, slots=True)
class StreamGap:
    """A place in a stream where samples are missing, or may be."""

    at: int
    """Index, in its block, of the first sample behind the gap; the block's length where none has come yet."""
    missing: int | None
    """How many samples are lost; None where that cannot be told, 0 for a sample that came twice."""
    why: str


@dataclass(frozen=True, slots=True)
class StreamBlock:
    """What a stream sent since it was polled last, in the order sent."""

    stream: str
    first: int
    """Running number, since the start, of the first sample; lost ones are not counted."""
    values: Mapping[str, NDArray[np.float64]]
    """By full channel name, each of shape (n,), in the unit that the stream names."""
    device_s: NDArray[np.float64]
    """Shape (n,): the device's own time, seconds, its wraps undone; NaN where it sends none."""
    polled_s: float
    """Rig seconds at which the block was taken: no sample of it is younger."""
    gaps: tuple[StreamGap, ...]
    refused: int
    """Lines that were no sample."""

    @property
    def samples(self) -> int:
        return int(self.device_s.size)


class Stream(Protocol):
    """A device that sends samples of named channels by itself, from :meth:`start` to :meth:`stop`."""

    name: str
    channels: tuple[str, ...]
    units: Mapping[str, str]
    """By full channel name, written as in a key: ``g``, ``dps``, ``ut``, ``mps2``, ``v``."""
    rate_hz: float

    def identify(self) -> str:
        """Return who the device says it is. Raises: DeviceSilent, DeviceNonsense, LinkLost."""

    def start(self) -> None:
        """Let it send; what was under way before is dropped, a first line that is not whole as well."""

    def poll(self) -> StreamBlock:
        """Return everything that came since the last poll; never waits.

        Raises: DeviceNonsense (nothing that comes is a sample), DeviceFault (the device says so), LinkLost.
        """

    def stop(self) -> None:
        """Let it be quiet, where it can be told to."""


class Environment(Protocol):
    """A chamber or a probe that tells, and may hold, a temperature."""

    name: str

    def identify(self) -> str: ...

    def temperature_degc(self) -> float: ...

    def setpoint_degc(self) -> float: ...

    def hold(self, setpoint_degc: float) -> None:
        """Write the setpoint and read it back."""


@dataclass(frozen=True, slots=True)
class FieldState:
    """One look at an applied field."""

    applied_ut: float | None
    """Along the field's direction; None where it is not known: under way, or never set."""
    fault: str = ""
    awaits_operator: bool = False


class Field(Protocol):
    """A coil or a magnet that applies a known magnetic field."""

    name: str
    limits_ut: tuple[float, float]

    def identify(self) -> str: ...

    def check_field(self, field_ut: float) -> None:
        """Raise RequestRefused unless ``field_ut`` is finite and inside the limits."""

    def start_field(self, field_ut: float) -> None:
        """Start after :meth:`check_field`; poll :meth:`state` until it is applied."""

    def state(self) -> FieldState: ...

    def stop(self) -> None:
        """Withdraw what was asked for; the field is then not known."""


class SweepAxis(Protocol):
    """An axis between limits that can cross its range at a rate asked for."""

    name: str
    top_rate_dps: float
    limits_deg: tuple[float, float]

    def check_rate(self, rate_dps: float) -> None:
        """Raise RequestRefused unless ``rate_dps`` is a rate that the machine can be set to."""

    def start_sweep(self, target_deg: float, rate_dps: float) -> None:
        """Start an absolute move at ``rate_dps`` (without sign) after the checks of a move and of the rate."""

    def turn_look(self, clock: Clock) -> TurnLook:
        """Ask for the angle, timed by the rig's clock."""


class TwinChance(Protocol):
    """Tells the twins which step is being measured, so that their chance is drawn from counters and not from time.

    Real devices get a :class:`NoChance`.
    """

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None:
        """Announce a place in the run.

        ``phase`` is one of ``settle``, ``read``, ``check`` or another name: each has numbers of its own.

        ``replications`` are those completed so far: the twins' drift follows it.
        """


class NoChance:
    """For rigs without twins: nothing to tell."""

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None: ...
