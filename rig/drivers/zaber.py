"""Zaber's stages: a chain of them on one line."""

from collections.abc import Mapping

from rig.devices import zaber
from rig.devices.zaber import ZaberSettings
from rig.drivers.driver import AxesDriver, Driver, on_one_line
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from rig.twins.zaber import Stage, ZaberTwin


def _twin(axes: Mapping[str, ZaberSettings], world: World, _time_factor: float) -> Twin:
    stages = {
        axis.line_address: (name, Stage(axis.microstep_deg, velocity_scale=axis.velocity_scale))
        for name, axis in axes.items()
    }
    twin = ZaberTwin(stages, world)
    for axis in axes.values():  # a file that asks for no checksums is that of a stage which sends none
        twin.axes[axis.line_address].settings |= {
            "comm.checksum": int(axis.require_checksum),
            "limit.home.preset": round(axis.home_preset_deg / axis.microstep_deg),
        }
    return twin


DRIVER = Driver("zaber", axes=AxesDriver(ZaberSettings, on_one_line(zaber.connect), _twin))
