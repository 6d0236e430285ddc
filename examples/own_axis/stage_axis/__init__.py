"""An axis of your own: rotary stages that speak a binary protocol, as a distribution beside calrig (docs/drivers.md).

Codec, device and twin. The twin has the protocol once more, written from the manual and not from the codec.
"""

from rig.drivers.driver import AxesDriver, Driver, on_one_line
from stage_axis.device import StageSettings, connect
from stage_axis.twin import twin

DRIVER = Driver("turn-2", axes=AxesDriver(StageSettings, on_one_line(connect), twin))
