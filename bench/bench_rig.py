"""A rig that costs nothing: devices that answer at once, in virtual time. What a run takes is the engine's own."""

import math
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from rig.abilities.abilities import Axis, AxisState, Burst, Environment, Field, NoChance, Readout, Stream, Wait
from rig.assembly.identity import Identifiable
from rig.clock import VirtualClock
from rig.link.counts import ExchangeCounts
from rig.motion.motion_memory import MotionMemory

NOISE_V = 1e-5
SENSITIVITY_V_PER_G = 2.5


class BenchAxis:
    """Arrives the moment it is sent."""

    limits_deg = (-360.0, 360.0)
    increment_deg = 0.0
    speed_dps = 1e6
    approach_deg = 0.0
    arrival_tolerance_deg = 0.001

    def __init__(self, name: str) -> None:
        self.name = name
        self._position_deg = 0.0

    def identify(self) -> str:
        return f"desk axis {self.name}"

    def home(self) -> None:
        self._position_deg = 0.0

    def check_target(self, target_deg: float) -> None:
        assert self.limits_deg[0] <= target_deg <= self.limits_deg[1]

    def start_move(self, target_deg: float) -> None:
        self._position_deg = target_deg

    def state(self) -> AxisState:
        return AxisState(self._position_deg, is_moving=False, is_homed=True, is_seated=True, fault="")

    def stop(self) -> None:
        return None


class BenchReadout:
    """One g on each package axis, and white noise from one block of numbers drawn beforehand."""

    def __init__(self, name: str, channels: tuple[str, ...], clock: VirtualClock, axes: Mapping[str, Axis]) -> None:
        self.name, self.channels = name, channels
        self._axes = axes
        self._clock = clock
        self._noise: NDArray[np.float64] = np.random.default_rng(1).normal(0.0, NOISE_V, 100_003)
        self._next = 0

    def identify(self) -> str:
        return f"desk readout {self.name}"

    def prepare(self) -> None:
        return None

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        started_s = self._clock.monotonic_s()
        wait(samples * self.reading_s(nplc))
        self._next = (self._next + samples) % (self._noise.size - samples)
        values = self._output_v(channel) + self._noise[self._next : self._next + samples]
        return Burst(channel, values, np.zeros(samples, dtype=np.bool_), started_s, self.reading_s(nplc))

    def _output_v(self, channel: str) -> float:
        """The example's nominal sensor at the attitude of the axes: the run checks its mount."""
        pitch, roll = (math.radians(self._axes[name].state().position_deg) for name in ("pitch", "roll"))
        force = (math.sin(pitch), -math.cos(pitch) * math.sin(roll), -math.cos(pitch) * math.cos(roll))
        return SENSITIVITY_V_PER_G * force["xyz".index(channel[-1])]

    def reading_s(self, nplc: float | None = None) -> float:
        return 0.04 * (10.0 if nplc is None else nplc)

    def checks(self) -> Mapping[str, float]:
        return {}


class BenchEnvironment:
    """Twenty degrees."""

    def __init__(self, name: str) -> None:
        self.name = name

    def identify(self) -> str:
        return f"desk environment {self.name}"

    def temperature_degc(self) -> float:
        return 20.0

    def setpoint_degc(self) -> float:
        return 20.0

    def hold(self, setpoint_degc: float) -> None:
        assert setpoint_degc == 20.0


class BenchRig:
    """An open rig of these devices."""

    def __init__(self) -> None:
        self.clock = VirtualClock(datetime(2026, 1, 1, tzinfo=UTC))
        self.axes: Mapping[str, Axis] = {name: BenchAxis(name) for name in ("pitch", "roll")}
        self.readouts: Mapping[str, Readout] = {"dmm": BenchReadout("dmm", ("x", "y", "z"), self.clock, self.axes)}
        self.environments: Mapping[str, Environment] = {"air": BenchEnvironment("air")}
        self.streams: Mapping[str, Stream] = {}
        self.fields: Mapping[str, Field] = {}
        self.chance = NoChance()
        self.motion = MotionMemory()

    def identities(self) -> Mapping[str, str]:
        return {name: device.identify() for name, device in self.by_table().items()}

    def by_table(self) -> Mapping[str, Identifiable]:
        tables: tuple[Mapping[str, Axis | Readout | Environment], ...] = (self.axes, self.readouts, self.environments)
        return {device.name: device for table in tables for device in table.values()}

    def link_counts(self) -> Mapping[str, ExchangeCounts]:
        return {}

    def sign_of_life(self) -> None: ...
    def reconnect(self) -> None:
        return None

    def open_lost(self, _until_s: float) -> str:
        return ""

    def stranger_axes(self, _names: Iterable[str]) -> Mapping[str, str]:
        return {}
