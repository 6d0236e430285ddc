"""A data-acquisition unit on a line in memory: from the driver to the volts and back."""

from dataclasses import dataclass

from gpib_rig import Bench, virtual_clock

from rig.clock import VirtualClock
from rig.devices.scpi_daq import ScpiDaqReadout
from rig.devices.scpi_daq_settings import ScpiDaqSettings
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.messages import StreamMessages
from rig.twins.scpi_daq import ScpiDaqTwin
from rig.twins.scpi_port import ScpiPort

WIRING = {101: "daq.x", 102: "daq.y", 203: "daq.z"}
LEVEL_V = {"daq.x": 1.0, "daq.y": -2.0, "daq.z": 3.0}


@dataclass
class DaqRig:
    bench: Bench
    clock: VirtualClock
    unit: ScpiDaqTwin
    port: ScpiPort
    faults: FaultScript
    stream: MemoryStream

    def wait(self, duration_s: float) -> None:
        self.clock.sleep(duration_s)

    def readout(self, **settings: object) -> ScpiDaqReadout:
        return ScpiDaqReadout("daq", daq_settings(**settings), StreamMessages(self.stream), self.clock)

    def prepared(self, **settings: object) -> ScpiDaqReadout:
        readout = self.readout(**settings)
        readout.prepare()
        return readout


def daq_rig(model: str = "34970A", wiring: dict[int, str] | None = None) -> DaqRig:
    bench, clock = Bench(level_v=dict(LEVEL_V)), virtual_clock()
    unit = ScpiDaqTwin(bench, wiring or WIRING, model=model)
    port, faults = ScpiPort(unit), FaultScript()
    return DaqRig(bench, clock, unit, port, faults, MemoryStream(port, clock, "memory", faults))


def daq_settings(**changes: object) -> ScpiDaqSettings:
    numbers = (("x", 101), ("y", 102), ("z", 203))
    channels = {name: {"channel": number, "range_v": 10.0} for name, number in numbers}
    fields: dict[str, object] = {
        "driver": "scpi-daq",
        "model": "34970A",
        "resource": "twin",
        "nplc": 1.0,
        "channels": channels,
    }
    return ScpiDaqSettings.model_validate(fields | changes)
