"""What a certificate says of a table's index errors or of a level, and what is declared of them: one number, not two.

The budget counts what the axis, the level or the reference declares; the report lists what its standard states. What
leaves it to its standard has the standard's number; what is to be better than its certificate is refused. It may be
worse: an old certificate, a table that was hit since.
"""

from collections.abc import Iterator
from typing import Final

from rig.description.rig_file import Level, RigDescription
from rig.toml_file import TomlFile

_ARCSEC_PER_DEG: Final = 3600.0
_ROUNDING: Final = 0.01
"""Of a number that is written with two digits or more."""


def better_than_certified(file: TomlFile, rig: RigDescription) -> Iterator[str]:
    """Yield a complaint about every axis, level or reference that declares less than its standard states."""
    declared = (
        *((("axes", name), axis.uncertainty_arcsec, axis.standard) for name, axis in rig.axes.items()),
        (("level",), rig.level.uncertainty_arcsec, rig.level.standard),
    )
    for key, declared_arcsec, standard_name in declared:
        certified_arcsec = _certified_arcsec(rig, standard_name)
        if 0.0 < declared_arcsec < certified_arcsec:
            yield file.complaint(
                (*key, "uncertainty_arcsec"),
                f"got {declared_arcsec:g}, and its standard states {certified_arcsec:g} "
                f"(standards.{standard_name}.uncertainty_arcsec): the angles would be counted as better than their "
                "certificate; nothing was done; give the certificate's number in both, or leave it out here",
            )
    reference = rig.attitude_reference
    standard = None if reference is None else rig.standards.get(reference.standard or "")
    if reference is None or standard is None or not standard.uncertainty_arcsec:
        return
    certified_deg = standard.uncertainty_arcsec / standard.divisor / _ARCSEC_PER_DEG
    if reference.uncertainty_deg < certified_deg * (1.0 - _ROUNDING):
        yield file.complaint(
            ("attitude_reference", "uncertainty_deg"),
            f"got {reference.uncertainty_deg:g} (a standard uncertainty), and its standard states "
            f"{certified_deg:.3g} (standards.{reference.standard}: {standard.kind}, "
            f"uncertainty_arcsec {standard.uncertainty_arcsec:g}): the angles would be counted as better than their "
            "certificate; nothing was done; give what the certificate states",
        )


def as_certified(rig: RigDescription) -> dict[str, dict[str, float]]:
    """Return axis to the uncertainty of its index errors where its standard alone states it.

    An axis with a list of errors has its own for what lies between them.
    """
    axes = ((name, axis, _certified_arcsec(rig, axis.standard)) for name, axis in rig.axes.items())
    return {
        name: {"uncertainty_arcsec": certified_arcsec}
        for name, axis, certified_arcsec in axes
        if certified_arcsec and axis.uncertainty_arcsec == 0.0 and axis.index_table is None
    }


def level_as_certified(rig: RigDescription) -> Level:
    """Return the level with the uncertainty of its instrument, its standard's where that alone states it."""
    certified_arcsec = _certified_arcsec(rig, rig.level.standard)
    if rig.level.uncertainty_arcsec or not certified_arcsec:
        return rig.level
    return rig.level.model_copy(update={"uncertainty_arcsec": certified_arcsec})


def _certified_arcsec(rig: RigDescription, name: str | None) -> float:
    """Return what a standard states of angles, arc seconds of its kind; 0 where there is none or it states nothing."""
    standard = rig.standards.get(name or "")
    return 0.0 if standard is None else standard.uncertainty_arcsec or 0.0
