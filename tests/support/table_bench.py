"""A dual-axis table on a line in memory: the way from the driver through the wire to the turning body and back."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from example_files import EXAMPLE_RIG

from rig.clock import VirtualClock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.devices.indexing_table import IndexingTableAxis, IndexingTableSettings, connect
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.physics.world import World
from rig.wire.indexing_table import TableCodec
from rig.wire.table_dialect import load_dialect


@dataclass
class TableBench:
    clock: VirtualClock
    world: World
    twin: IndexingTableTwin
    faults: FaultScript
    axes: dict[str, IndexingTableAxis]

    @property
    def pitch(self) -> IndexingTableAxis:
        return self.axes["pitch"]

    def home_all(self) -> None:
        for axis in self.axes.values():
            axis.home()
            self.clock.sleep(200.0)


def virtual_clock() -> VirtualClock:
    return VirtualClock(datetime(2024, 3, 1, tzinfo=UTC))


def table_bench(**pitch: object) -> TableBench:
    """The example rig's table; ``pitch`` changes settings of its pitch axis."""
    description = example_rig()
    axes = {name: axis for name, axis in description.axes.items() if isinstance(axis, IndexingTableSettings)}
    axes["pitch"] = axes["pitch"].model_copy(update=pitch)
    description = description.model_copy(update={"axes": axes})
    clock, world, faults = virtual_clock(), World(description), FaultScript()
    finest = min(axis.increment_deg for axis in axes.values())
    twin = IndexingTableTwin(TableCodec(load_dialect(None, finest)), {1: "pitch", 2: "roll"}, world)
    return TableBench(clock, world, twin, faults, connect(axes, MemoryStream(twin, clock, "table", faults)))


def example_rig() -> RigDescription:
    return read_rig(EXAMPLE_RIG)


def rig_file(folder: Path, *changes: tuple[str, str]) -> Path:
    """A copy of the example with every ``(old, new)`` replaced once."""
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, f"the example does not contain {old!r}"
        text = text.replace(old, new, 1)
    path = folder / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return path
