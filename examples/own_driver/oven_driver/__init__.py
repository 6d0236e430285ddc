"""A driver of your own: an oven that speaks lines of ASCII, as a distribution beside calrig (docs/own-driver.md).

Codec, device and twin stay apart as calrig's own do; what brings them together is registered in ``pyproject.toml``.
"""

from oven_driver.device import OvenSettings, connect
from oven_driver.twin import twin
from rig.drivers.driver import Driver, EnvironmentDriver

DRIVER = Driver("oven", environment=EnvironmentDriver(OvenSettings, connect, twin))
