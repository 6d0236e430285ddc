"""Devices, standards, and what the rig file declares: laboratory, job, level, chain, acceptance, as rows of text."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydantic import BaseModel

from procedures.journal.audit.known_devices import identities_in_words
from procedures.report.conditions import condition_sections
from procedures.report.section import Section, SectionSource, fragment_beside
from rig.description.rig_file import RigDescription, Standard

UNITS = {"arcsec": "″", "v": "V", "degc": "°C", "ohm": "Ω"}


@dataclass(frozen=True)
class Device:
    """A device as it introduced itself."""

    name: str
    driver: str
    identity: str
    standard: str


@dataclass(frozen=True)
class StandardRow:
    """A certificate the calibration rests on."""

    name: str
    serial: str
    certificate: str
    due: str
    uncertainty: str


@dataclass(frozen=True)
class Equipment:
    """What the section brings."""

    devices: tuple[Device, ...]
    standards: tuple[StandardRow, ...]
    declared: Mapping[str, Mapping[str, str]]
    """Heading to rows of text: what the rig file declares, and under which conditions the run was measured."""


def device_rows(rig: RigDescription, identities: Mapping[str, str]) -> tuple[Device, ...]:
    """Return every device of the rig file with what it answered when asked who it is."""
    groups: Mapping[str, Mapping[str, BaseModel]] = {
        "axes": rig.axes,
        "readouts": rig.readouts,
        "environment": rig.environment,
        "streams": rig.streams,
        "field": rig.field,
    }
    devices = tuple(
        Device(
            name=f"{group}.{name}",
            driver=str(getattr(settings, "driver", "")),
            identity=identities.get(f"{group}.{name}", identities.get(name, "")),
            standard=str(getattr(settings, "standard", None) or ""),
        )
        for group, named in groups.items()
        for name, settings in named.items()
    )
    if (reference := rig.attitude_reference) is not None:
        channels = ", ".join(f"{axis} by {channel}" for axis, channel in reference.channels.items())
        devices += (Device("attitude_reference", "", channels, reference.standard or ""),)
    level = rig.level
    if level.instrument or level.standard:
        devices += (Device("level", "", level.instrument, level.standard or ""),)
    return devices


def standard_rows(rig: RigDescription) -> tuple[StandardRow, ...]:
    """Return every certificate that the rig file names."""
    return tuple(
        StandardRow(name, standard.serial, standard.certificate, standard.due.isoformat(), _uncertainty(standard))
        for name, standard in rig.standards.items()
    )


def declared_sections(rig: RigDescription) -> Mapping[str, Mapping[str, str]]:
    """Return the sections that were filled in, keys as in the file (they carry the unit)."""
    tables: dict[str, BaseModel | None] = {
        "laboratory": rig.laboratory,
        "job": rig.job,
        "level of the base": rig.level,
        "acceptance": rig.acceptance,
        **{f"chain of {channel}": chain for channel, chain in rig.chain.items()},
    }
    filled = {
        name: dict(_flattened("", table.model_dump(mode="json", exclude_defaults=True)))
        for name, table in tables.items()
        if table is not None
    }
    return {name: section for name, section in filled.items() if section}


def _uncertainty(standard: Standard) -> str:
    stated = standard.model_dump(include={f"uncertainty_{unit}" for unit in UNITS}, exclude_none=True)
    kind = {"limit": "limit", "standard": "standard", "expanded": f"expanded, k = {standard.k:g}"}[standard.kind]
    texts = (f"±{value:g} {UNITS[key.removeprefix('uncertainty_')]}" for key, value in stated.items())
    return "; ".join(f"{text} ({kind})" for text in texts) or "none stated"


def _flattened(prefix: str, value: object) -> list[tuple[str, str]]:
    """Return key and value, nested keys joined by a dot."""
    if isinstance(value, dict):
        return [
            leaf for key, item in value.items() for leaf in _flattened(f"{prefix}.{key}" if prefix else str(key), item)
        ]
    return [(prefix, ", ".join(map(str, value)) if isinstance(value, list) else str(value))]


def equipment(source: SectionSource) -> Equipment:
    """Return what a run was measured with, as rig file and journal say it."""
    record = source.record
    return Equipment(
        device_rows(record.rig, identities_in_words(record.tenures)),
        standard_rows(record.rig),
        {**declared_sections(record.rig), **condition_sections(record.events)},
    )


SECTION = Section("equipment", 600, fragment_beside(__file__), lambda _view: {"equipment": "Equipment"}, data=equipment)
