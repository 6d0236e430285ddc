"""Newport's ESP301: up to three axes on a line."""

from collections.abc import Mapping

from rig.devices import esp301
from rig.devices.esp301 import Esp301Settings
from rig.drivers.driver import AxesDriver, Driver, numbers, on_one_line
from rig.twins.esp301 import Esp301Twin
from rig.twins.physics.world import World
from rig.twins.twin import Twin


def _twin(axes: Mapping[str, Esp301Settings], world: World, _time_factor: float) -> Twin:
    twin = Esp301Twin(numbers(axes), world)
    for axis in axes.values():
        twin.axes[axis.axis].preset_deg = axis.home_preset_deg
    return twin


DRIVER = Driver("esp301", axes=AxesDriver(Esp301Settings, on_one_line(esp301.connect), _twin))
