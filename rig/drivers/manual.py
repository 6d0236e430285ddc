"""A person: axes that are set, and fields that are switched, by hand."""

from collections.abc import Mapping

from rig.abilities.abilities import Field
from rig.devices import manual, manual_field
from rig.devices.manual import ManualSettings
from rig.devices.manual_field import ManualFieldSettings
from rig.drivers.driver import AxesDriver, Driver, FieldDriver, on_one_line
from rig.lines.open_lines import Lines
from rig.twins.manual import OperatorTwin
from rig.twins.manual_field import FieldOperatorTwin
from rig.twins.physics.world import World
from rig.twins.twin import Twin


def _twin(axes: Mapping[str, ManualSettings], world: World, _time_factor: float) -> Twin:
    return OperatorTwin(axes.keys(), world)


def _open_field(name: str, settings: ManualFieldSettings, lines: Lines) -> Field:
    return manual_field.connect(name, settings, lines.stream(f"field.{name}", settings.port))


def _field_twin(name: str, settings: ManualFieldSettings, world: World) -> Twin:
    return FieldOperatorTwin(name, settings.direction, world)


DRIVER = Driver(
    "manual",
    axes=AxesDriver(ManualSettings, on_one_line(manual.connect), _twin),
    field=FieldDriver(ManualFieldSettings, _open_field, _field_twin),
)
