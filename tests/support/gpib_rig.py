"""A meter and a scanner on a bus in memory: the whole way from the driver to the volts and back."""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime

from rig.clock import VirtualClock
from rig.devices.hp3458a import Hp3458aReadout, Hp3458aSettings
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.prologix import PrologixBus
from rig.twins.hp3458a import Hp3458aTwin
from rig.twins.hp3488a import Hp3488aTwin
from rig.twins.prologix import PrologixTwin
from rig.twins.scanned_input import ScannedInput

WIRING = {101: "dmm.x", 102: "dmm.y", 103: "dmm.z"}
LEVEL_V = {"dmm.x": 1.0, "dmm.y": -2.0, "dmm.z": 3.0}


@dataclass
class Bench:
    """A voltage source that counts: the n-th reading (from 1) of a channel is its level plus n microvolts."""

    level_v: dict[str, float] = field(default_factory=lambda: dict(LEVEL_V))
    readings: list[tuple[str, float]] = field(default_factory=list)

    def read_voltage_v(self, channel: str, now_s: float) -> float:
        self.readings.append((channel, now_s))
        return self.level_v[channel] + 1e-6 * len(self.readings)


@dataclass
class GpibRig:
    bench: Bench
    clock: VirtualClock
    scanner: Hp3488aTwin
    meter: Hp3458aTwin
    adapter: PrologixTwin
    faults: FaultScript
    stream: MemoryStream

    def wait(self, duration_s: float) -> None:
        self.clock.sleep(duration_s)

    def readout(self, **settings: object) -> Hp3458aReadout:
        return Hp3458aReadout("dmm", meter_settings(**settings), PrologixBus(self.stream), self.clock)

    def prepared(self, **settings: object) -> Hp3458aReadout:
        readout = self.readout(**settings)
        readout.prepare()
        return readout


def virtual_clock() -> VirtualClock:
    return VirtualClock(datetime(2024, 3, 1, tzinfo=UTC))


def gpib_rig(
    source: Callable[[float], float] | None = None,
    wiring: dict[int, str] | None = None,
    cards: dict[int, str] | None = None,
    output_ohm: dict[str, float] | None = None,
) -> GpibRig:
    """All twins joined; ``source`` replaces the scanned inputs by one function of rig time."""
    bench, clock, scanner = Bench(), virtual_clock(), Hp3488aTwin(cards)
    meter = Hp3458aTwin(source or ScannedInput(bench, scanner, wiring or WIRING, output_ohm or {}))
    adapter = PrologixTwin({22: meter, 9: scanner})
    faults = FaultScript()
    return GpibRig(bench, clock, scanner, meter, adapter, faults, MemoryStream(adapter, clock, "memory", faults))


def meter_settings(**changes: object) -> Hp3458aSettings:
    channels = {name: {"scanner": number, "range_v": 10.0} for number, name in ((1, "x"), (2, "y"), (3, "z"))}
    fields: dict[str, object] = {"driver": "hp3458a", "resource": "twin", "channels": channels}
    return Hp3458aSettings.model_validate(fields | changes)
