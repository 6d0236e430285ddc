"""With what a calibration was measured: its standards, what was read without one, and local gravity, a row each.

Source: ISO/IEC 17025:2017, 7.8.4.1 c), 6.4.13.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet

_LEVEL: Final = "level of the base"
_WHAT_FOR: Final = MappingProxyType(
    {
        "axes": "attitude",
        "attitude_reference": "attitude",
        "readouts": "outputs",
        "streams": "outputs",
        "environment": "temperature",
        "field": "field",
        "chain": "load resistor",
        "level": _LEVEL,
    }
)
"""A table of the rig file to what the certificate behind it is for."""
_LEVEL_IN_USE: Final = ("instrument", "uncertainty_arcsec", "before", "after")
"""Keys of ``[level]`` of which any says that the attitudes are counted from a level that was read."""


@dataclass(frozen=True)
class Equipment:
    """One row; None where nothing is declared."""

    name: str
    used_for: str
    """Empty where a set of before does not state it."""
    serial: str | None
    certificate: str | None
    due: str | None
    is_standard: bool = True
    """Whether an uncertainty is declared of it."""
    uncertainty: Document | None = None
    identity: str = ""
    """As it told it when it was asked."""
    determines: bool = True
    """Whether a quantity rests on it; a scanner passes one on, and what it adds is declared or a gap."""


def equipment_of(coefficients: CoefficientSet) -> list[Equipment]:
    """Return the standards that a set names, then meters, scanners, thermometers, level and local gravity."""
    standards = [table(standard) for standard in listed(coefficients.provenance["standards"])]
    level = table(coefficients.provenance["level"] or {})
    elsewhere = _measured_by_others(coefficients)
    rows = [_of_standard(standard, str(level.get("instrument") or ""), elsewhere) for standard in standards]
    pointed = {str(text) for standard in standards for text in listed(standard.get("used_for", []))}
    rows += [*_readouts(coefficients, pointed, elsewhere), *_thermometers_without(coefficients, pointed)]
    rows += _replaced(coefficients)
    counts = coefficients.senses_gravity and any(level.get(key) for key in _LEVEL_IN_USE)
    if counts and "level" not in pointed:
        rows.append(Equipment(str(level.get("instrument") or "level"), _LEVEL, None, None, None))
    gravity = coefficients.gravity
    if coefficients.senses_gravity:
        is_known = gravity.standard_uncertainty_mps2 > 0.0
        rows.append(Equipment("local gravity", "unit of acceleration", None, gravity.source or None, None, is_known))
    return rows


def _of_standard(standard: Document, instrument: str, elsewhere: Mapping[str, int]) -> Equipment:
    """Return the row of a standard; ``instrument``: what read the level, which its standard is the certificate of."""
    serial, certificate, due = (standard[key] and str(standard[key]) for key in ("serial", "certificate", "due"))
    declared = None if standard["uncertainty"] is None else table(standard["uncertainty"])
    used_for: dict[str, list[str]] = {}
    for text in map(str, listed(standard.get("used_for", []))):
        kind, _, name = text.partition(".")
        is_thermometer = kind == "chain" and "uncertainty_degc" in (declared or {})
        what = "temperature" if is_thermometer else _WHAT_FOR[kind]
        named = instrument if kind == "level" else name
        used_for.setdefault(what, []).append(f"{named}{_but_for(elsewhere.get(text, 0))}")
    words = [f"{what} ({', '.join(filter(None, names))})".removesuffix(" ()") for what, names in used_for.items()]
    return Equipment(
        str(standard["name"]), ", ".join(words), serial or None, certificate or None, due or None, uncertainty=declared
    )


def _readouts(coefficients: CoefficientSet, pointed: set[str], elsewhere: Mapping[str, int]) -> Iterator[Equipment]:
    """Yield the meters that no standard is behind, and every scanner; of a set of before nothing is known of them."""
    for name, stated in table(coefficients.provenance.get("readouts") or {}).items():
        readout, identity = table(stated), str(table(stated).get("identity") or "")
        axes = ", ".join(map(str, listed(readout["axes"])))
        has_standard = f"readouts.{name}" in pointed
        if not has_standard:
            used_for = f"outputs ({axes}{_but_for(elsewhere.get(f'readouts.{name}', 0))})"
            yield Equipment(name, used_for, None, None, None, is_standard=False, identity=identity)
        if readout["scanned"]:
            ratio = readout.get("crosstalk_ratio")
            crosstalk = "crosstalk not declared" if ratio is None else f"crosstalk {number(ratio):g}, declared"
            yield Equipment(
                f"scanner of {name}",
                f"outputs ({axes}); {crosstalk}",
                None,
                None,
                None,
                is_standard=ratio is not None,
                identity=identity if has_standard else "",
                determines=False,
            )


def _replacements(coefficients: CoefficientSet) -> Iterator[Document]:
    return map(table, listed(coefficients.provenance.get("replaced_devices") or []))


def _measured_by_others(coefficients: CoefficientSet) -> dict[str, int]:
    """Return, by table of the rig file, how many dwells something else measured than what is declared there."""
    found: dict[str, int] = {}
    for stated in _replacements(coefficients):
        device = str(stated["device"])
        found[device] = found.get(device, 0) + int(number(stated["dwells"]))
    return found


def _but_for(dwells: int) -> str:
    return f", but for {_counted(dwells)} that another device measured" if dwells else ""


def _counted(dwells: int) -> str:
    return f"{dwells} dwell{'' if dwells == 1 else 's'}"


def _replaced(coefficients: CoefficientSet) -> Iterator[Equipment]:
    """Yield what measured in the place of another device: no certificate is declared of it, whatever was of that."""
    for stated in _replacements(coefficients):
        kind, _, name = str(stated["device"]).partition(".")
        what = ", ".join(map(str, listed(stated.get("used_for") or [_WHAT_FOR[kind]])))
        used_for = f"{what} ({_counted(int(number(stated['dwells'])))})"
        who = str(stated["identity"])
        yield Equipment(f"in the place of {name}", used_for, None, None, None, is_standard=False, identity=who)


def _thermometers_without(coefficients: CoefficientSet, pointed: set[str]) -> Iterator[Equipment]:
    """Yield what told a temperature with no standard behind it; of a set of before nothing is known of it."""
    standards = [table(standard) for standard in listed(coefficients.provenance["standards"])]
    if any("used_for" not in standard for standard in standards):
        return
    for name in table(coefficients.document["environment"]):
        if f"environment.{name}" not in pointed:
            yield Equipment(name, "temperature", None, None, None, is_standard=False)
