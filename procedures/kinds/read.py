"""Reading ``procedure.toml``: the tables that all kinds share, and the own table of each registered kind."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from pydantic import create_model

from procedures.description.procedure_file import Procedure, ProcedureDescription, Solve
from procedures.kinds.registry import KINDS
from rig.errors import DescriptionError
from rig.toml_file import TomlFile, read_toml


def procedure_form() -> type[ProcedureDescription]:
    """Return the form of the whole file with the tables of every registered kind."""
    names: Any = Literal[tuple(KINDS)]
    head = create_model("Procedure", __base__=Procedure, kind=(names, ...))
    tables: dict[str, Any] = {kind.table[0]: (kind.table[1] | None, None) for kind in KINDS.values() if kind.table}
    return create_model("ProcedureDescription", __base__=ProcedureDescription, procedure=(head, ...), **tables)


def read_procedure(path: Path) -> ProcedureDescription:
    """Read and check a procedure file. Raises: rig.errors.DescriptionError naming every mistake."""
    return procedure_of(read_toml(path))


def procedure_of(file: TomlFile) -> ProcedureDescription:
    """Check what was read of a procedure file. Raises: rig.errors.DescriptionError naming every mistake."""
    file.require_seen()
    file.require_kind("procedure", "procedure", "rig", "rig")
    description = file.validate(procedure_form())
    complaints = [file.complaint(key, text) for key, text in disagreements(description)]
    if complaints:
        raise DescriptionError("\n".join(complaints))
    description._file = file
    return description


def disagreements(description: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
    """Tell the tables that do not go together: key and what is wrong."""
    kind = KINDS[description.procedure.kind]
    for owner in KINDS.values():
        if owner.table is None:
            continue
        if (getattr(description, owner.table[0]) is not None) != (owner is kind):
            what = "is missing" if owner is kind else f"belongs to procedure.kind = {owner.name!r}"
            yield (owner.table[0],), f"{what}; this is a procedure of kind {kind.name!r}"
    if kind.table is not None:
        yield from _ignored(description)
    if description.solve.model not in kind.models:
        allowed = " or ".join(f'"{model}"' for model in kind.models)
        yield ("solve", "model"), f"got {description.solve.model!r}, allowed for kind {kind.name!r}: {allowed}"
    if kind.solves_lines(description.solve.model, description.design.kind):
        yield from _unknown_to_lines(description.solve)
    yield from kind.disagreements(description)


def _unknown_to_lines(solve: Solve) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield what no straight line of known levels is solved with."""
    if solve.temperature != "none":
        yield (
            ("solve", "temperature"),
            f"got {solve.temperature!r}, allowed 'none': a straight line of known levels has no term of temperature; "
            "hold the temperature and make a run of each, or solve by a model of the sensor",
        )
    if solve.extended != "no" and "extended" in solve.model_fields_set:
        yield (
            ("solve", "extended"),
            f"got {solve.extended!r}, allowed 'no': a straight line of known levels has no terms of second and third "
            "order; where the sensor bends, its lack of fit says so",
        )


def _ignored(description: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the tables of attitudes at rest beside a kind that has a table of its own."""
    name = description.procedure.kind
    if "design" in description.model_fields_set:
        yield ("design",), f"has no meaning for a procedure of kind {name!r}, which has its own attitudes; remove it"
    for table, what in (("environment", "plateaus"), ("check", "reference attitudes")):
        if getattr(description, table) is not None:
            yield (table,), f"{name!r} has no {what}; remove it"
