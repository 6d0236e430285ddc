"""Exports that a procedure asks for and that no set of its sensors can have: told before anything is measured."""

from collections.abc import Iterator, Mapping

from ams.exports.format import ForeseenSet
from ams.exports.formats import FORMATS
from ams.sets.sensed_quantity import FIELDS
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.kinds.kind import Kind
from rig.description.rig_file import Sensor


def unwritable_exports(
    kind: Kind, procedure: ProcedureDescription, sensors: Mapping[str, Sensor]
) -> Iterator[PlanError]:
    """Tell of every format of ``[export]`` and every sensor of which it would be refused when the run ends."""
    for name in procedure.export.formats:
        lacks = FORMATS[name].lacks
        for serial, sensor in sensors.items():
            why = None if lacks is None else lacks(_foreseen(kind, procedure, serial, sensor))
            if why is not None:
                yield procedure.error(
                    ("export", "formats"),
                    f"{name!r} has no form of the set that {serial} will have: {why}; nothing moved; leave it out "
                    f"here, and export what has such a form afterwards (calrig export SET --to {name})",
                )


def _foreseen(kind: Kind, procedure: ProcedureDescription, serial: str, sensor: Sensor) -> ForeseenSet:
    """Return what the set will be."""
    solve = procedure.solve
    is_of_lines = kind.solves_lines(solve.model, procedure.design.kind)
    form = None if is_of_lines else FIELDS.get(solve.model_of(serial, rolls=sensor.rolls))
    unit = sensor.sensed_unit if form is None else form.unit
    return ForeseenSet(tuple(map(str, sensor.channels)), unit, form)
