"""Physik Instrumente's controllers with GCS 2.0: one or more rotary stages on a line."""

from collections.abc import Mapping

from rig.devices import pi_gcs
from rig.devices.pi_gcs import PiGcsSettings
from rig.drivers.driver import AxesDriver, Driver, on_one_line
from rig.twins.physics.world import World
from rig.twins.pi_gcs import PiGcsTwin
from rig.twins.twin import Twin


def _twin(axes: Mapping[str, PiGcsSettings], world: World, _time_factor: float) -> Twin:
    return PiGcsTwin({axis.axis: (axis.named, name) for name, axis in axes.items()}, world)


DRIVER = Driver("pi-gcs", axes=AxesDriver(PiGcsSettings, on_one_line(pi_gcs.connect), _twin))
