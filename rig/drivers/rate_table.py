"""Rate tables that speak a dialect of lines: one or more axes on a line."""

from collections.abc import Mapping

from rig.devices import rate_table
from rig.devices.rate_table import RateTableSettings
from rig.drivers.driver import AxesDriver, Driver, numbers, on_one_line
from rig.twins.physics.world import World
from rig.twins.rate_table import RateTableTwin
from rig.twins.twin import Twin
from rig.wire.indexing_table import TableCodec


def _twin(axes: Mapping[str, RateTableSettings], world: World, _time_factor: float) -> Twin:
    return RateTableTwin(TableCodec(next(iter(axes.values())).spoken()), numbers(axes), world)


DRIVER = Driver("rate-table", axes=AxesDriver(RateTableSettings, on_one_line(rate_table.connect), _twin))
