"""A stream of your own: a board that sends a packet of bytes for every sample by itself (docs/own-driver.md)."""

from pulse_imu.device import PulseSettings, connect
from pulse_imu.twin import twin
from rig.drivers.driver import Driver, StreamDriver

DRIVER = Driver("pulse-imu", stream=StreamDriver(PulseSettings, connect, twin))
