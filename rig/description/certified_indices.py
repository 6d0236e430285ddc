"""What the certificate of a table says of its index errors, and what the axis declares of them: one number, not two.

The budget counts what the axis declares; the report lists what its standard states. An axis that leaves it to its
standard has the standard's number; one that is to be better than its certificate is refused. It may be worse: an old
certificate, a table that was hit since.
"""

from collections.abc import Iterable, Iterator
from typing import Final

from rig.description.rig_file import RigDescription
from rig.toml_file import TomlFile

_ARCSEC_PER_DEG: Final = 3600.0
_ROUNDING: Final = 0.01
"""Of a number that is written with two digits or more."""


def better_than_certified(file: TomlFile, rig: RigDescription) -> Iterator[str]:
    """Yield a complaint about every axis that declares smaller index errors than its standard states."""
    for name, certified_arcsec in _certified_arcsec(rig):
        axis = rig.axes[name]
        if 0.0 < axis.uncertainty_arcsec < certified_arcsec:
            yield file.complaint(
                ("axes", name, "uncertainty_arcsec"),
                f"got {axis.uncertainty_arcsec:g}, and its standard states {certified_arcsec:g} "
                f"(standards.{axis.standard}.uncertainty_arcsec): the angles would be counted as better than their "
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
    axes = ((name, rig.axes[name], certified_arcsec) for name, certified_arcsec in _certified_arcsec(rig))
    return {
        name: {"uncertainty_arcsec": certified_arcsec}
        for name, axis, certified_arcsec in axes
        if axis.uncertainty_arcsec == 0.0 and axis.index_table is None
    }


def _certified_arcsec(rig: RigDescription) -> Iterable[tuple[str, float]]:
    for name, axis in rig.axes.items():
        standard = rig.standards.get(axis.standard or "")
        if standard is not None and standard.uncertainty_arcsec:
            yield name, standard.uncertainty_arcsec
