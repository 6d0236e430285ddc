"""Indexing tables that speak a dialect of lines: one or more axes on a line."""

from collections.abc import Mapping

from rig.devices import indexing_table
from rig.devices.indexing_table import IndexingTableSettings
from rig.drivers.driver import AxesDriver, Driver, numbers, on_one_line
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from rig.wire.indexing_table import TableCodec
from rig.wire.table_dialect import load_dialect


def _twin(axes: Mapping[str, IndexingTableSettings], world: World, _time_factor: float) -> Twin:
    finest = min(axes.values(), key=lambda settings: settings.increment_deg)
    codec = TableCodec(load_dialect(finest.dialect, finest.increment_deg))
    return IndexingTableTwin(codec, numbers(axes), world)


DRIVER = Driver("indexing-table", axes=AxesDriver(IndexingTableSettings, on_one_line(indexing_table.connect), _twin))
