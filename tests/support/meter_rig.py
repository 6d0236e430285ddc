"""A single multimeter on a line in memory, or on a bus behind an adapter: from the driver to the volts and back."""

from dataclasses import dataclass, field

from gpib_rig import virtual_clock

from rig.clock import VirtualClock
from rig.devices.scpi_meter import PRESETS, ScpiMeter, ScpiMeterSettings
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.messages import GpibMessages, StreamMessages
from rig.link.prologix import PrologixBus
from rig.twins.prologix import PrologixTwin
from rig.twins.scpi_meter import ScpiMeterTwin
from rig.twins.scpi_port import ScpiPort

MODELS = tuple(PRESETS)


@dataclass
class MeterRig:
    model: str
    clock: VirtualClock
    unit: ScpiMeterTwin
    port: ScpiPort
    faults: FaultScript
    stream: MemoryStream
    level_v: list[float] = field(default_factory=lambda: [1.0])

    def said(self, message: bytes) -> bytes:
        """What the unit answers to bytes, long after it."""
        self.port.receive(message + b"\n", 0.0)
        return self.port.transmit(1000.0)

    def wait(self, duration_s: float) -> None:
        self.clock.sleep(duration_s)

    def meter(self, **changes: object) -> ScpiMeter:
        return ScpiMeter("dmm", meter_settings(self.model, **changes), StreamMessages(self.stream), self.clock)

    def prepared(self, **changes: object) -> ScpiMeter:
        meter = self.meter(**changes)
        meter.prepare()
        return meter


def meter_rig(model: str = "34401A") -> MeterRig:
    level_v = [1.0]
    clock = virtual_clock()
    unit = ScpiMeterTwin(lambda _now_s: level_v[0], model=model)
    port, faults = ScpiPort(unit, unit.format_error), FaultScript()
    return MeterRig(model, clock, unit, port, faults, MemoryStream(port, clock, "memory", faults), level_v)


def on_a_bus(rig: MeterRig, **changes: object) -> ScpiMeter:
    """The same meter at address 22 behind an adapter."""
    bus = PrologixBus(MemoryStream(PrologixTwin({22: rig.port}), rig.clock, "adapter"))
    return ScpiMeter("dmm", meter_settings(rig.model, **changes), GpibMessages(bus, 22), rig.clock)


def meter_settings(model: str, **changes: object) -> ScpiMeterSettings:
    range_v = 20.0 if model == "keithley-2002" else 10.0
    fields: dict[str, object] = {
        "driver": "scpi-meter",
        "model": model,
        "resource": "twin",
        "nplc": 1.0,
        "channels": {"x": {"range_v": range_v}},
    }
    return ScpiMeterSettings.model_validate(fields | changes)
