"""The twins of the axes, driver by driver: which machine stands at the end of a line of axes."""

from collections.abc import Callable, Mapping

from rig.description.device_settings import AxisSettings
from rig.devices.esp301 import Esp301Settings
from rig.devices.indexing_table import IndexingTableSettings
from rig.devices.maestro import MaestroSettings
from rig.devices.manual import ManualSettings
from rig.devices.oriental_az import OrientalAzSettings
from rig.devices.zaber import ZaberSettings
from rig.drivers.open import Kind, settings_as
from rig.twins.esp301 import Esp301Twin
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.maestro import ChannelSettings, MaestroTwin
from rig.twins.manual import OperatorTwin
from rig.twins.oriental_az import AzMotor, OrientalAzTwin
from rig.twins.twin import Twin
from rig.twins.world import World
from rig.twins.zaber import Stage, ZaberTwin
from rig.wire import maestro as maestro_wire
from rig.wire.indexing_table import TableCodec
from rig.wire.pulses import PulseCalibration
from rig.wire.table_dialect import load_dialect

AxesTwin = Callable[[Mapping[str, AxisSettings], World, float], Twin]
"""From the axes of one line, the world and the rig seconds in a second of the line."""


def _of(kind: type[Kind], build: Callable[[Mapping[str, Kind], World, float], Twin]) -> AxesTwin:
    def twin(axes: Mapping[str, AxisSettings], world: World, time_factor: float) -> Twin:
        return build({name: settings_as(kind, axis) for name, axis in axes.items()}, world, time_factor)

    return twin


def _numbers(axes: Mapping[str, AxisSettings]) -> dict[int, str]:
    return {axis.axis: name for name, axis in axes.items()}


def _indexing_table(axes: Mapping[str, IndexingTableSettings], world: World, _factor: float) -> Twin:
    finest = min(axes.values(), key=lambda settings: settings.increment_deg)
    codec = TableCodec(load_dialect(finest.dialect, finest.increment_deg))
    return IndexingTableTwin(codec, _numbers(axes), world)


def _esp301(axes: Mapping[str, Esp301Settings], world: World, _factor: float) -> Twin:
    return Esp301Twin(_numbers(axes), world)


def _maestro(axes: Mapping[str, MaestroSettings], world: World, _factor: float) -> Twin:
    first = next(iter(axes.values()))
    low, high = (round(limit_us * maestro_wire.QUARTERS_PER_US) for limit_us in first.pulse_limits_us)
    return MaestroTwin(
        {axis.axis: (name, PulseCalibration(axis.points)) for name, axis in axes.items()},
        world,
        model=first.model,
        device=maestro_wire.DEFAULT_DEVICE if first.device_number is None else first.device_number,
        has_crc=first.crc,
        period_ms=first.period_ms,
        settings=ChannelSettings(low=low, high=high),
        detects_baud=first.detect_baud,
        timeout_s=first.watchdog_s,
    )


def _manual(axes: Mapping[str, ManualSettings], world: World, _factor: float) -> Twin:
    return OperatorTwin(axes.keys(), world)


def _oriental_az(axes: Mapping[str, OrientalAzSettings], world: World, factor: float) -> Twin:
    return OrientalAzTwin(
        {axis.axis: (name, AzMotor(axis.step_deg)) for name, axis in axes.items()}, world, gap_s=factor
    )


def _zaber(axes: Mapping[str, ZaberSettings], world: World, _factor: float) -> Twin:
    stages = {
        axis.axis: (name, Stage(axis.microstep_deg, velocity_scale=axis.velocity_scale)) for name, axis in axes.items()
    }
    return ZaberTwin(stages, world)


AXIS_TWINS: Mapping[str, AxesTwin] = {
    "esp301": _of(Esp301Settings, _esp301),
    "indexing-table": _of(IndexingTableSettings, _indexing_table),
    "maestro": _of(MaestroSettings, _maestro),
    "manual": _of(ManualSettings, _manual),
    "oriental-az": _of(OrientalAzSettings, _oriental_az),
    "zaber": _of(ZaberSettings, _zaber),
}
