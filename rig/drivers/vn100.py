"""VectorNav's VN-100: an inertial unit that sends binary frames."""

from rig.abilities.abilities import Stream
from rig.clock import Clock
from rig.devices import vn100
from rig.devices.vn100 import Vn100Settings
from rig.drivers.driver import Driver, StreamDriver
from rig.lines.open_lines import Lines
from rig.twins.physics.strapped_down import StrappedDown
from rig.twins.twin import Twin
from rig.twins.vn100 import Vn100Twin


def _open(name: str, settings: Vn100Settings, lines: Lines, clock: Clock) -> Stream:
    return vn100.connect(name, settings, lines.stream(f"streams.{name}", settings.port, settings.baud_rate), clock)


def _twin(name: str, _settings: Vn100Settings, source: StrappedDown) -> Twin:
    """Return the twin of a unit; its driver sets it up, so that the settings do not matter here."""
    return Vn100Twin(name, source)


DRIVER = Driver("vn100", stream=StreamDriver(Vn100Settings, _open, _twin))
