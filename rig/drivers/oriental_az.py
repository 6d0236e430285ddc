"""Oriental Motor's AZ: motors on one Modbus line."""

from collections.abc import Mapping

from rig.devices import oriental_az
from rig.devices.oriental_az_settings import OrientalAzSettings
from rig.drivers.driver import AxesDriver, Driver, on_one_line
from rig.twins.oriental_az import AzMotor, OrientalAzTwin
from rig.twins.physics.world import World
from rig.twins.twin import Twin


def _twin(axes: Mapping[str, OrientalAzSettings], world: World, time_factor: float) -> Twin:
    motors = {axis.axis: (name, AzMotor(axis.step_deg)) for name, axis in axes.items()}
    return OrientalAzTwin(motors, world, gap_s=time_factor)


DRIVER = Driver(
    "oriental-az", axes=AxesDriver(OrientalAzSettings, on_one_line(oriental_az.connect), _twin), speaks_modbus=True
)
