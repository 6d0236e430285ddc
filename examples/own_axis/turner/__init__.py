"""An axis of your own that goes to angles and turns at rates, by frames of bytes (docs/own-driver.md).

Codec, device and twin stand apart: bytes in, values out; meaning without a port; the machine from its other side.
"""

from rig.drivers.driver import AxesDriver, Driver, on_one_line
from turner.device import TurnerSettings, connect
from turner.twin import twin

DRIVER = Driver("turner", axes=AxesDriver(TurnerSettings, on_one_line(connect), twin))
