"""A readout of your own: a meter with three inputs that speaks SCPI, a distribution beside calrig (docs/own-driver.md).

The words of SCPI are calrig's (:mod:`rig.wire.scpi`), so that there is no codec here: device and twin alone.
"""

from nano_meter.device import NanoSettings, connect
from nano_meter.twin import twin
from rig.drivers.driver import Driver, ReadoutDriver

DRIVER = Driver("nano-meter", readout=ReadoutDriver(NanoSettings, connect, twin))
