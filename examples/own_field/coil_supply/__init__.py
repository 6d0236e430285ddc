"""A field of your own: a coil on a supply that sets a current by lines of text (docs/own-driver.md)."""

from coil_supply.device import CoilSettings, connect
from coil_supply.twin import twin
from rig.drivers.driver import Driver, FieldDriver

DRIVER = Driver("coil-supply", field=FieldDriver(CoilSettings, connect, twin))
