"""A motion controller's twin with pitch and roll of the example rig behind it, and its driver on a line to it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from table_bench import example_rig, virtual_clock

from rig.abilities.abilities import Axis
from rig.clock import VirtualClock
from rig.description.device_settings import AxisSettings
from rig.devices import esp301, indexing_table, maestro, manual, oriental_az, pi_gcs, rate_table, zaber
from rig.devices.maestro_settings import MaestroSettings
from rig.devices.oriental_az_settings import OrientalAzSettings
from rig.drivers.driver import DRIVERS as INSTALLED
from rig.link.byte_stream import ByteStream
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.twins.oriental_az import OrientalAzTwin
from rig.twins.physics.world import World

Axes = Mapping[str, Any]
TIME_FACTOR = 200.0
"""The largest at which these twins are served: a Modbus twin forgets half a frame after a second of the line."""


@dataclass(frozen=True)
class Driver:
    """How the axes of one driver are made for a bench."""

    settings: type[AxisSettings]
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


DRIVERS: dict[str, Driver] = {
    "indexing-table": Driver(indexing_table.IndexingTableSettings, indexing_table.connect, {"increment_deg": 1.0}),
    "esp301": Driver(esp301.Esp301Settings, esp301.connect, {}),
    "maestro": Driver(
        MaestroSettings,
        maestro.connect,
        {"points": [[500.0, -180.0], [2500.0, 180.0]], "pulse_limits_us": [500.0, 2500.0]},
    ),
    "manual": Driver(manual.ManualSettings, manual.connect, {}),
    "oriental-az": Driver(OrientalAzSettings, oriental_az.connect, {"step_deg": 0.01, "top_rate_dps": 180.0}),
    "pi-gcs": Driver(pi_gcs.PiGcsSettings, pi_gcs.connect, {}),
    "rate-table": Driver(rate_table.RateTableSettings, rate_table.connect, {"top_rate_dps": 300.0}),
    "zaber": Driver(zaber.ZaberSettings, zaber.connect, {"microstep_deg": 0.000234375, "top_rate_dps": 450.0}),
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


def twin_of(driver: str, axes: Axes, world: World) -> Any:
    """As it is delivered: no axis has a home."""
    made = INSTALLED[driver].axes
    assert made is not None
    assert made.twin is not None
    twin: Any = made.twin(axes, world, TIME_FACTOR)
    for unit in twin.units.values() if isinstance(twin, OrientalAzTwin) else ():
        unit.servo.power_cycle(0.0)
    return twin


def motion_bench(driver: str, **changes: object) -> MotionBench:
    """In memory and in virtual time."""
    axes = settings_of(driver, **changes)
    clock, world, faults = virtual_clock(), world_of(axes), FaultScript()
    twin = twin_of(driver, axes, world)
    stream = MemoryStream(twin, clock, driver, faults)
    return MotionBench(clock, world, twin, faults, DRIVERS[driver].connect(axes, stream), stream)
