"""Exports that a procedure asks for and that no set of its sensors can have: told before anything is measured."""

from collections.abc import Iterator, Mapping

from ams.exports.format import ForeseenSet
from ams.exports.formats import FORMATS
from ams.models.registry import takes_levels
from ams.sets.sensed_quantity import FIELDS
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.solution.lines import UNITS
from rig.description.rig_file import Sensor


def unwritable_exports(procedure: ProcedureDescription, sensors: Mapping[str, Sensor]) -> Iterator[PlanError]:
    """Tell of every format of ``[export]`` and every sensor of which it would be refused when the run ends."""
    for name in procedure.export.formats:
        lacks = FORMATS[name].lacks
        for serial, sensor in sensors.items():
            why = None if lacks is None else lacks(_foreseen(procedure, serial, sensor))
            if why is not None:
                yield procedure.error(
                    ("export", "formats"),
                    f"{name!r} has no form of the set that {serial} will have: {why}; nothing moved; leave it out "
                    f"here, and export what has such a form afterwards (calrig export SET --to {name})",
                )


def _foreseen(procedure: ProcedureDescription, serial: str, sensor: Sensor) -> ForeseenSet:
    """Return what the set will be: straight lines up and down, of rates and of fields, which design no attitudes."""
    solve = procedure.solve
    is_of_lines = takes_levels(solve.model) and procedure.design.kind == "up-down"
    form = None if is_of_lines else FIELDS.get(solve.model_of(serial, rolls=sensor.rolls))
    unit = UNITS[sensor.measures] if form is None else form.unit
    return ForeseenSet(tuple(map(str, sensor.channels)), unit, form)
