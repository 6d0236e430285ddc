"""A motion controller's twin with pitch and roll of the example rig behind it, and its driver on a line to it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from table_bench import example_rig, virtual_clock

from rig.clock import VirtualClock
from rig.devices import esp301, indexing_table, maestro, manual, oriental_az, zaber
from rig.devices.abilities import Axis
from rig.link.byte_stream import ByteStream
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.settings import AxisSettings
from rig.twins.esp301 import Esp301Twin
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.maestro import ChannelSettings, MaestroTwin
from rig.twins.manual import OperatorTwin
from rig.twins.oriental_az import AzMotor, OrientalAzTwin
from rig.twins.twin import Twin
from rig.twins.world import World
from rig.twins.zaber import Stage, ZaberTwin
from rig.wire.indexing_table import TableCodec
from rig.wire.maestro import DEFAULT_DEVICE
from rig.wire.pulses import PulseCalibration
from rig.wire.table_dialect import load_dialect

Axes = Mapping[str, Any]
FRAME_GAP_S = 200.0
"""Silence after which a Modbus twin forgets half a frame: a second of the machine where time runs 200 times as fast."""


@dataclass(frozen=True)
class Driver:
    """How the axes of one driver are made for a bench."""

    settings: type[AxisSettings]
    twin: Callable[[Axes, World], Twin]
    connect: Callable[[Axes, ByteStream], Mapping[str, Axis]]
    extra: Mapping[str, object]
    """Settings the driver needs beside the common ones."""


@dataclass
class MotionBench:
    clock: VirtualClock
    world: World
    twin: Any
    faults: FaultScript
    axes: Mapping[str, Any]
    stream: MemoryStream

    @property
    def pitch(self) -> Any:
        return self.axes["pitch"]

    @property
    def true_deg(self) -> float:
        return self.world.axes["pitch"].table_deg(self.clock.monotonic_s())

    def home_all(self) -> None:
        """Home every axis and let it arrive."""
        for axis in self.axes.values():
            axis.home()
            self.clock.sleep(200.0)
            assert axis.state().is_homed


def _numbers(axes: Axes) -> dict[int, str]:
    return {axis.axis: name for name, axis in axes.items()}


def _table_twin(axes: Axes, world: World) -> Twin:
    return IndexingTableTwin(TableCodec(load_dialect(None, 1.0)), _numbers(axes), world)


def _zaber_twin(axes: Axes, world: World) -> Twin:
    return ZaberTwin({axis.axis: (name, Stage(axis.microstep_deg)) for name, axis in axes.items()}, world)


def _esp301_twin(axes: Axes, world: World) -> Twin:
    return Esp301Twin(_numbers(axes), world)


def _maestro_twin(axes: Axes, world: World) -> Twin:
    first = next(iter(axes.values()))
    return MaestroTwin(
        {axis.axis: (name, PulseCalibration(axis.points)) for name, axis in axes.items()},
        world,
        model=first.model,
        device=DEFAULT_DEVICE if first.device_number is None else first.device_number,
        has_crc=first.crc,
        settings=ChannelSettings(low=2000, high=10000),
    )


def _oriental_az_twin(axes: Axes, world: World) -> Twin:
    motors = {axis.axis: (name, AzMotor(axis.step_deg, is_homed=False)) for name, axis in axes.items()}
    return OrientalAzTwin(motors, world, gap_s=FRAME_GAP_S)


DRIVERS: dict[str, Driver] = {
    "indexing-table": Driver(
        indexing_table.IndexingTableSettings, _table_twin, indexing_table.connect, {"increment_deg": 1.0}
    ),
    "esp301": Driver(esp301.Esp301Settings, _esp301_twin, esp301.connect, {}),
    "maestro": Driver(
        maestro.MaestroSettings,
        _maestro_twin,
        maestro.connect,
        {"points": [[500.0, -180.0], [2500.0, 180.0]], "pulse_limits_us": [500.0, 2500.0]},
    ),
    "manual": Driver(manual.ManualSettings, lambda axes, world: OperatorTwin(list(axes), world), manual.connect, {}),
    "oriental-az": Driver(
        oriental_az.OrientalAzSettings,
        _oriental_az_twin,
        oriental_az.connect,
        {"step_deg": 0.01, "top_rate_dps": 180.0},
    ),
    "zaber": Driver(
        zaber.ZaberSettings, _zaber_twin, zaber.connect, {"microstep_deg": 0.000234375, "top_rate_dps": 450.0}
    ),
}


def settings_of(driver: str, **changes: object) -> dict[str, Any]:
    """Pitch and roll of the example, ±180 deg at 5 deg/s, for one controller; ``changes`` apply to both."""
    made = DRIVERS[driver]
    common = {"driver": driver, "port": "twin", "limits_deg": (-180.0, 180.0), "speed_dps": 5.0}
    return {
        name: made.settings.model_validate({**common, "axis": number, **made.extra, **changes})
        for number, name in enumerate(("pitch", "roll"), start=1)
    }


def world_of(axes: Axes) -> World:
    return World(example_rig().model_copy(update={"axes": dict(axes)}))


def motion_bench(driver: str, **changes: object) -> MotionBench:
    """In memory and in virtual time."""
    axes = settings_of(driver, **changes)
    clock, world, faults = virtual_clock(), world_of(axes), FaultScript()
    twin = DRIVERS[driver].twin(axes, world)
    stream = MemoryStream(twin, clock, driver, faults)
    return MotionBench(clock, world, twin, faults, DRIVERS[driver].connect(axes, stream), stream)
