"""What somebody who applies a set must know beyond its numbers: polarity, installation, chain, temperature, re-zeroing.

All of it follows from the coefficients and from what the rig declares; it stands in the document as the section
``use``, so that no reader of an export has to derive it.
"""

import re
from collections.abc import Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.sets.canonical import Document, Json, plain, table
from ams.sets.equations import AxisNumbers

POLARITY_TEXT = (
    "sign along the nominal axis: +1 where the output rises as that axis is turned upwards (gyros: as the package "
    "turns right-handed about it), -1 where it falls"
)
INSTALLATION_TEXT = (
    "the coefficients are in the axes of the calibration fixture; the rows of fixture_to_package are the package's "
    "body axes x, y, z in fixture axes: f_package = fixture_to_package f_fixture, k_package = fixture_to_package "
    "k_fixture; null: the mount was not declared as signed axes, apply the set only to the package mounted as it was "
    "calibrated"
)
REZERO_TEXT = (
    "offset_v may be set anew wind-off at a known attitude: offset_v = output - k.f; no other term may be adjusted "
    "without a calibration"
)
CORRECTIONS_TEXT = (
    "the coefficients hold for reading * nominal_v / (volts of the supply's channel) and for reading / (1 + "
    "tc_per_degc (T - degc)), T the load resistor's temperature: correct readings so before the set is applied"
)
TEMPERATURE_TEXT = "T in degC = offset_degc + slope_degc_per_v * volts of the channel"
LEVEL_REZERO_TEXT = (
    "{offset} may be set anew at a known level: {offset} = output - k.level; no other term may be adjusted without a "
    "calibration"
)


def use_section(
    axes: Mapping[str, AxisNumbers],
    mount: Mapping[str, object] | None,
    chain: Mapping[str, object] | None,
    temperature_conversion: Mapping[str, object] | None,
) -> Document:
    """Return the document's section ``use``."""
    conversion = plain(temperature_conversion, "temperature_conversion")
    return {
        "polarity": {name: polarity(numbers) for name, numbers in axes.items()},
        "polarity_text": POLARITY_TEXT,
        "installation": {
            "fixture_to_package": fixture_to_package(mount or {}),
            "datum": plain((mount or {}).get("datum"), "mount.datum"),
            "text": INSTALLATION_TEXT,
        },
        "chain_serials": {str(name): _serial(declared) for name, declared in (chain or {}).items()},
        **_corrections(chain or {}),
        "temperature_conversion": None if conversion is None else {**table(conversion), "text": TEMPERATURE_TEXT},
        "wind_off_rezero": _rezero(axes),
    }


def _rezero(axes: Mapping[str, AxisNumbers]) -> Document:
    form = next(iter(axes.values())).form
    text = LEVEL_REZERO_TEXT.format(offset=form.offset) if form.senses_level else REZERO_TEXT
    return {"terms": [form.offset], "text": text}


def use_of(document: Document) -> Document | None:
    """Return the section ``use``, None in a set that was written before there was one."""
    section = document.get("use")
    return None if section is None else table(section)


def polarity(numbers: AxisNumbers) -> int:
    """Return +1 or -1: the sign of the sensitivity; where the model names none, of k along the nominal axis.

    CR's accelerometers sense gravity, which points the other way than the specific force that a turn upwards makes.
    """
    sensitivity = numbers.parameters.get(numbers.form.sensitivity)
    along = float(numbers.direction["xyz".index(numbers.nominal_axis)])
    sense = -1 if numbers.form.is_gravity else 1
    return -sense if (along if sensitivity is None else sensitivity) < 0.0 else sense


def fixture_to_package(mount: Mapping[str, object]) -> list[Json] | None:
    """Return the rows of the signed permutation that the mount declares, None where it declares none."""
    named = [str(mount.get(axis, "")) for axis in "xyz"]
    if not all(re.fullmatch(r"[+-][xyz]", name) for name in named):
        return None
    return [[float(f"{name[0]}1") if axis == name[1] else 0.0 for axis in "xyz"] for name in named]


def declared_mount(document: Document) -> FloatArray | None:
    """Return the (3, 3) ``fixture_to_package`` of a set; None where nothing of it is declared."""
    section = use_of(document)
    rows = None if section is None else table(section["installation"])["fixture_to_package"]
    return None if rows is None else np.array(rows, dtype=np.float64)


def mount_in_words(document: Document) -> str | None:
    """Return that directions and angles of a set are the fixture's, and how the package sat on it; None: alike."""
    turned = declared_mount(document)
    if turned is None or np.array_equal(turned, np.eye(3)):
        return None
    along = ["+−"[int(row.sum() < 0.0)] + "xyz"[int(np.argmax(np.abs(row)))] for row in turned]
    return (
        "directions and angles are in the axes of the calibration's fixture, on which the package sat with its own "
        f"x, y, z along {', '.join(along)} of the fixture"
    )


def _corrections(chain: Mapping[str, object]) -> Document:
    """Return ``chain_corrections``, where there are any: what readings were divided by before the set was made."""
    found = {str(name): _correction(declared) for name, declared in chain.items() if isinstance(declared, Mapping)}
    made: dict[str, Json] = {name: correction for name, correction in found.items() if correction}
    return {"chain_corrections": made, "chain_corrections_text": CORRECTIONS_TEXT} if made else {}


def _correction(declared: Mapping[str, object]) -> Document:
    """Return the correction of one channel: for its supply, its load resistor, or both."""
    correction: Document = {}
    nominal_v = declared.get("supply_nominal_v") or _middle(declared.get("supply_band_v"))
    if declared.get("ratiometric") and nominal_v is not None:
        channel = plain(declared.get("supply_channel"), "chain.supply_channel")
        correction["supply"] = {"channel": channel, "nominal_v": plain(nominal_v, "chain.supply_nominal_v")}
    if declared.get("load_resistor_ohm") is not None and declared.get("load_resistor_at") is not None:
        keys = ("load_resistor_ohm", "load_resistor_tc_per_degc", "load_resistor_degc")
        named = {key.removeprefix("load_resistor_"): plain(declared.get(key, 0.0), f"chain.{key}") for key in keys}
        correction["load_resistor"] = named
    return correction


def _middle(band: object) -> float | None:
    return sum(map(float, band)) / 2.0 if isinstance(band, list | tuple) else None


def _serial(declared: object) -> str | None:
    """Return the serial in what is declared of a channel's chain."""
    serial = declared.get("serial") if isinstance(declared, Mapping) else None
    return str(serial) if serial else None
