"""Read a rig file into frozen values."""

import json
from collections.abc import Mapping, Sequence
from functools import cache, lru_cache, reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import Field, ValidationError, create_model

from rig.description.certified_angles import as_certified, level_as_certified
from rig.description.cross_checks import complaints_about_references
from rig.description.device_settings import AxisSettings, ReadoutSettings
from rig.description.drivers import TABLES, classes_for
from rig.description.earlier_versions import as_stored_now
from rig.description.index_table import IndexTable, beyond_declared, read_index_table
from rig.description.rig_file import Name, RigDescription
from rig.description.twin_truth import AxisTruth as AxisTruth
from rig.description.twin_truth import AxisTwin as AxisTwin
from rig.description.twin_truth import TwinBase as TwinBase
from rig.description.twin_truth import TwinEnvironment as TwinEnvironment
from rig.description.twin_truth import TwinSection as TwinSection
from rig.description.twin_truth import TwinStream as TwinStream
from rig.errors import DescriptionError
from rig.toml_file import TomlFile, read_toml

Described = TypeVar("Described", AxisSettings, ReadoutSettings)


def read_rig(path: Path) -> RigDescription:
    """Read and check a rig file. Raises: DescriptionError naming file, line and key of every mistake."""
    return rig_of(read_toml(path))


def rig_of(file: TomlFile) -> RigDescription:
    """Check what was read of a rig file. Raises: DescriptionError as :func:`read_rig`."""
    file.require_seen()
    file.require_kind("rig", "rig", "procedure", "procedure")
    description = file.validate(rig_form(file.values))
    tables, complaints = _index_tables(file, description)
    complaints += complaints_about_references(file, description)
    if complaints:
        raise type(file.error((), ""))("\n".join(complaints))
    axes, certified = _with_files(description.axes, file.path.parent), as_certified(description)
    return description.model_copy(
        update={
            "axes": {
                name: axis.model_copy(update={**tables.get(name, {}), **certified.get(name, {})})
                for name, axis in axes.items()
            },
            "readouts": _with_files(description.readouts, file.path.parent),
            "level": level_as_certified(description),
        }
    )


def rig_form(values: Mapping[str, Any] | None = None) -> type[RigDescription]:
    """Return the form of a file: in place of the devices' bases the tables of the drivers that the values name.

    Without values the tables of every driver.
    """
    named = {
        table: classes_for(ability, None if values is None else values.get(table, {}))
        for table, ability in TABLES.items()
    }
    return _form_of(tuple((table, tuple(classes)) for table, classes in named.items() if classes))


@cache
def _form_of(tables: tuple[tuple[str, tuple[type, ...]], ...]) -> type[RigDescription]:
    """Return the form with these classes; pydantic takes several milliseconds to make one."""
    fields: dict[str, Any] = {}
    for table, classes in tables:
        default = Field(min_length=1) if table == "axes" else {}
        fields[table] = (dict[Name, _tagged_union(classes)], default)  # type: ignore[misc]
    return create_model("RigFile", __base__=RigDescription, **fields)


def _tagged_union(classes: Sequence[type]) -> Any:
    return Annotated[reduce(or_, classes), Field(discriminator="driver")] if len(classes) > 1 else classes[0]


def _with_files(devices: dict[str, Described], folder: Path) -> dict[str, Described]:
    """Return the devices with what the files say that they name, relative to the rig file's folder."""
    return {name: device.with_files(folder) for name, device in devices.items()}


def _index_tables(file: TomlFile, rig: RigDescription) -> tuple[dict[str, dict[str, IndexTable]], list[str]]:
    """Return axis to the rows of its file of index errors, and what is wrong with such files."""
    found: dict[str, dict[str, IndexTable]] = {}
    complaints = []
    for name, axis in rig.axes.items():
        key = ("axes", name, "index_table")
        if isinstance(axis.index_table, IndexTable):
            complaints.append(file.complaint(key, "got a table, allowed the path of a CSV file; write it in quotes"))
        elif axis.index_table is not None:
            try:
                rows = read_index_table(file.path.parent / axis.index_table, axis.limits_deg)
            except DescriptionError as error:
                complaints.append(file.complaint(key, str(error)))
                continue
            found[name] = {"index_table": rows}
            standard = rig.standards.get(axis.standard or "")
            kind, k = ("limit", 1.0) if standard is None else (standard.kind, standard.k)
            if (contradiction := beyond_declared(rows, axis.uncertainty_arcsec, kind, k)) is not None:
                complaints.append(file.complaint(key, contradiction))
    return found, complaints


@lru_cache(maxsize=16)
def rig_from_json(text: str) -> RigDescription:
    """Return a description that ``model_dump_json`` wrote, as a journal keeps it. Raises: DescriptionError.

    The runs of a laboratory were made on few rigs: their descriptions, which nothing changes, are kept.
    """
    try:
        stored = as_stored_now(text)
        return rig_form(_values_in(stored)).model_validate_json(stored)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise DescriptionError(
            f"stored rig description: {where}: {first['msg']}; use the calrig that wrote it"
        ) from None


def _values_in(text: str) -> dict[str, Any]:
    """Return the tables of a stored description; none where it is no JSON object, which its validation tells."""
    try:
        document = json.loads(text)
    except ValueError:
        return {}
    return document if isinstance(document, dict) else {}
