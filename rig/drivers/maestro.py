"""Pololu's Maestro: servos on one controller."""

from collections.abc import Mapping

from rig.devices import maestro
from rig.devices.maestro_settings import MaestroSettings
from rig.drivers.driver import AxesDriver, Driver, on_one_line
from rig.twins.maestro import ChannelSettings, MaestroTwin
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from rig.wire import maestro as wire
from rig.wire.pulses import PulseCalibration


def _twin(axes: Mapping[str, MaestroSettings], world: World, _time_factor: float) -> Twin:
    first = next(iter(axes.values()))
    low, high = (round(limit_us * wire.QUARTERS_PER_US) for limit_us in first.pulse_limits_us)
    return MaestroTwin(
        {axis.axis: (name, PulseCalibration(axis.points)) for name, axis in axes.items()},
        world,
        model=first.model,
        device=wire.DEFAULT_DEVICE if first.device_number is None else first.device_number,
        has_crc=first.crc,
        period_ms=first.period_ms,
        settings=ChannelSettings(low=low, high=high),
        detects_baud=first.detect_baud,
        timeout_s=first.watchdog_s,
    )


DRIVER = Driver("maestro", axes=AxesDriver(MaestroSettings, on_one_line(maestro.connect), _twin))
