"""A rig of real twins with one thing wrong at a chosen moment."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from rig.abilities.abilities import Axis, AxisState, Burst, Environment, Field, Readout, Stream, TwinChance, Wait
from rig.assembly.identity import Identifiable
from rig.assembly.open_rig import Rig
from rig.clock import Clock
from rig.errors import RigError
from rig.link.counts import ExchangeCounts
from rig.motion.motion_memory import MotionMemory


class FaultyReadout:
    """Passes everything on; ``spoil`` sees every burst of a dwell (not of settling) with its running number."""

    def __init__(self, readout: Readout, spoil: Callable[[int, Burst], Burst]) -> None:
        self._readout, self._spoil = readout, spoil
        self.name, self.channels = readout.name, readout.channels
        self.read_so_far = 0

    def put(self, readout: Readout) -> None:
        self._readout = readout

    def identify(self) -> str:
        return self._readout.identify()

    def prepare(self) -> None:
        self._readout.prepare()

    def reading_s(self, nplc: float | None = None) -> float:
        return self._readout.reading_s(nplc)

    def checks(self) -> Mapping[str, float]:
        return self._readout.checks()

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        burst = self._readout.read(channel, samples, wait, nplc)
        if nplc is not None:
            return burst
        self.read_so_far += 1
        return self._spoil(self.read_so_far, burst)


class FaultyAxis:
    """Passes everything on; ``look`` sees every state."""

    def __init__(self, axis: Axis, look: Callable[[AxisState], AxisState]) -> None:
        self._axis, self._look = axis, look
        self.name, self.limits_deg, self.increment_deg = axis.name, axis.limits_deg, axis.increment_deg
        self.speed_dps, self.approach_deg = axis.speed_dps, axis.approach_deg
        self.arrival_tolerance_deg = axis.arrival_tolerance_deg
        self.stops = 0

    def put(self, axis: Axis) -> None:
        self._axis = axis

    def identify(self) -> str:
        return self._axis.identify()

    def home(self) -> None:
        self._axis.home()

    def check_target(self, target_deg: float) -> None:
        self._axis.check_target(target_deg)

    def start_move(self, target_deg: float) -> None:
        self._axis.start_move(target_deg)

    def state(self) -> AxisState:
        return self._look(self._axis.state())

    def stop(self) -> None:
        self.stops += 1
        self._axis.stop()


class RecordedChance:
    """Passes announcements on and remembers them."""

    def __init__(self, chance: TwinChance) -> None:
        self._chance = chance
        self.heard: list[tuple[int, str, int, float]] = []

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None:
        self.heard.append((step, phase, attempt, replications))
        self._chance.announce(step, phase, attempt, replications)


class FaultyRig:
    """The rig with its meter, its pitch axis or its identities spoilt."""

    def __init__(
        self,
        rig: Rig,
        spoil: Callable[[int, Burst], Burst] = lambda _, burst: burst,
        look: Callable[[AxisState], AxisState] = lambda state: state,
        identity: str | None = None,
    ) -> None:
        self._rig, self._identity = rig, identity
        self.meter = FaultyReadout(rig.readouts["dmm"], spoil)
        self.heard_chance = RecordedChance(rig.chance)
        self.pitch = FaultyAxis(rig.axes["pitch"], look)

    @property
    def axes(self) -> Mapping[str, Axis]:
        return {**self._rig.axes, "pitch": self.pitch}

    @property
    def readouts(self) -> Mapping[str, Readout]:
        return {"dmm": self.meter}

    @property
    def environments(self) -> Mapping[str, Environment]:
        return self._rig.environments

    @property
    def streams(self) -> Mapping[str, Stream]:
        return self._rig.streams

    @property
    def fields(self) -> Mapping[str, Field]:
        return self._rig.fields

    @property
    def chance(self) -> TwinChance:
        return self.heard_chance

    @property
    def clock(self) -> Clock:
        return self._rig.clock

    @property
    def motion(self) -> MotionMemory:
        return self._rig.motion

    def link_counts(self) -> Mapping[str, ExchangeCounts]:
        return self._rig.link_counts()

    def sign_of_life(self) -> None:
        self._rig.sign_of_life()

    def by_table(self) -> Mapping[str, Identifiable]:
        return self._rig.by_table()

    def reconnect(self) -> None:
        self._rig.reconnect()
        self.meter.put(self._rig.readouts["dmm"])
        self.pitch.put(self._rig.axes["pitch"])

    def open_lost(self, _until_s: float) -> str:
        """Everything is opened or nothing."""
        try:
            self.reconnect()
        except RigError as error:
            return str(error)
        return ""

    def stranger_axes(self, names: Iterable[str]) -> Mapping[str, str]:
        return self._rig.stranger_axes(names)

    def identities(self) -> Mapping[str, str]:
        found = self._rig.identities()
        return found if self._identity is None else {**found, "readouts.dmm": self._identity}


def noisier(burst: Burst, factor: float) -> Burst:
    mean_v = burst.samples.mean()
    return replace(burst, samples=mean_v + factor * (burst.samples - mean_v))
