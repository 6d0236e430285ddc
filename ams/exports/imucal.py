"""A set as a calibration of the Python package imucal: scale, rotation and offset of three accelerometers or gyros.

imucal's ``FerrarisCalibrationInfo`` takes acceleration as R_a⁻¹ K_a⁻¹ (measured − b_a), in m/s², and rates as
R_g⁻¹ K_g⁻¹ (measured − b_g − K_ga acceleration), in °/s. Of v = b + k·f the rows k make K R: K has their lengths, R
their directions. A file of imucal holds both kinds of sensor: the kind that a set does not have is let through as it
is. Terms of second and third order and of temperature have no place there; what they amount to at most is stated.
imucal refuses keys that it does not know, so the set itself stands in its ``comment``.
Source: imucal 2.6, calibration_info.py and ferraris_calibration_info.py.
"""

import json
from collections.abc import Iterable, Set
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SetError
from ams.exports.checksum_inside import CHECKSUM_SLOT, check_inside, with_checksum_inside
from ams.exports.checksum_line import INTACT
from ams.exports.embedded import document_from, document_lines, harmless
from ams.exports.format import ForeseenSet, Format
from ams.exports.linear_form import largest_term_v, temperature_error_v
from ams.exports.plain_values import check_same
from ams.exports.statement import statement
from ams.sets.canonical import Document
from ams.sets.coefficients import CoefficientSet
from ams.sets.vectors import resolves
from ams.units import UNITS

LOSES = (
    "neglects terms of second and third order and of temperature (bounds stated per axis), all uncertainty, validity "
    "and equations (in the comment); gyros are taken to feel no acceleration"
)
ORDER: Final = "xyz"
_BEGIN: Final = b'{\n    "acc_unit": '
_KINDS: Final = {"g": ("a", "acc", "m/s^2"), "dps": ("g", "gyr", "deg/s")}
"""By the unit of a set: imucal's letter, its word and its unit."""
_NEEDED: Final = (
    "needed are three accelerometers or three gyros x, y, z that lie in no plane, each an offset and three "
    "sensitivities"
)


def to_imucal(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a JSON file for ``imucal.CalibrationInfo.from_json_file``.

    Raises: SetError for a set that is not of three accelerometers or three gyros.
    """
    _check(coefficients, "imucal", is_solved=resolves(coefficients.axes))
    lines = [f"Loses: {LOSES}.", *_bounds(coefficients), *(harmless(line) for line in statement(coefficients))]
    comment = "\n".join([*lines, *document_lines(coefficients), CHECKSUM_SLOT.decode()])
    keys = {**_numbers(coefficients), "comment": comment}
    ordered = {name: keys[name] for name in ("acc_unit", "gyr_unit", "from_acc_unit", "from_gyr_unit", "comment")}
    whole = json.dumps({**ordered, **keys}, indent=4, allow_nan=False) + "\n"
    return with_checksum_inside(whole.encode("ascii"))


def from_imucal(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file: the whole one, out of its comment.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its numbers are not those of the
    document in it.
    """
    check_inside(content, _BEGIN, "imucal calibration", where)
    try:
        read: Document = json.loads(content)
        comment = str(read.pop("comment"))
    except (ValueError, KeyError) as error:
        raise SetError(f"{where}: is no calibration of imucal: {error}; {INTACT}") from error
    coefficients = document_from(comment.encode("ascii", "replace"), "", where)
    _check(coefficients, f"{where}: imucal", is_solved=True)
    check_same(read, _numbers(coefficients), "numbers", where)
    return coefficients


def _lacks(foreseen: ForeseenSet) -> str | None:
    """Return what a set that is to be measured lacks; None where it has the axes and the unit."""
    if _is_triad(foreseen.axes, {foreseen.unit}) and (foreseen.form is None or foreseen.form.output is None):
        return None
    return f"got the axes {', '.join(foreseen.axes)} per {UNITS.get(foreseen.unit, foreseen.unit)}, {_NEEDED}"


def _is_triad(axes: Iterable[str], units: Set[str]) -> bool:
    return len(units) == 1 and units <= set(_KINDS) and set(axes) == set(ORDER)


def _check(coefficients: CoefficientSet, what: str, *, is_solved: bool) -> None:
    """Refuse what is no triad, and one that is not solved for what it senses. Raises: SetError."""
    axes = coefficients.axes
    units = {axis.form.unit for axis in axes.values()}
    if not (_is_triad(axes, units) and is_solved) or any(axis.model_output for axis in axes.values()):
        raise SetError(
            f"{coefficients.sensor}: {what}: got the axes {', '.join(axes)} by {coefficients.model}, {_NEEDED}; "
            "nothing was written; export c or json"
        )


def _numbers(coefficients: CoefficientSet) -> dict[str, object]:
    """Return imucal's fields but for the comment."""
    unit = next(iter(coefficients.axes.values())).form.unit
    letter, word, _ = _KINDS[unit]
    rows = _sensitivities(coefficients)
    lengths = np.linalg.norm(rows, axis=1)
    offsets = [coefficients.axes[axis].primary[coefficients.axes[axis].form.offset] for axis in ORDER]
    fields: dict[str, object] = {"acc_unit": "m/s^2", "gyr_unit": "deg/s"}
    for field_unit, kind, through in _KINDS.values():
        fields[f"from_{kind}_unit"] = through
        fields |= {
            f"K_{field_unit}": np.eye(3).tolist(),
            f"R_{field_unit}": np.eye(3).tolist(),
            f"b_{field_unit}": [0.0, 0.0, 0.0],
        }
    fields[f"from_{word}_unit"] = _measured_unit(coefficients)
    fields[f"K_{letter}"] = np.diag(lengths).tolist()
    fields[f"R_{letter}"] = (rows / lengths[:, None]).tolist()
    fields[f"b_{letter}"] = [float(value) for value in offsets]
    fields["K_ga"] = np.zeros((3, 3)).tolist()
    return {**fields, "cal_type": "Turntable", "_format_version": "2.0.0"}


def _sensitivities(coefficients: CoefficientSet) -> FloatArray:
    """Return the (3, 3) sensitivities per m/s² of specific force, or per °/s."""
    rows = np.stack([coefficients.axes[axis].direction for axis in ORDER])
    form = next(iter(coefficients.axes.values())).form
    if form.unit == "dps":
        return rows
    # CR's sets sense gravity, the opposite of the specific force that an accelerometer is said to measure.
    sense = -1.0 if form.is_gravity else 1.0
    return np.asarray(sense * rows / coefficients.gravity_mps2)


def _measured_unit(coefficients: CoefficientSet) -> str:
    return {"v": "V"}.get(unit := next(iter(coefficients.axes.values())).form.measured_unit, unit)


def _bounds(coefficients: CoefficientSet) -> list[str]:
    """Return what the neglected terms amount to, an axis a line."""
    lines = []
    for axis in ORDER:
        numbers = coefficients.axes[axis]
        length = float(np.linalg.norm(numbers.direction))
        neglected = largest_term_v(coefficients, numbers) + temperature_error_v(coefficients, numbers, length)
        lines.append(f"Neglected in {axis}: at most {neglected / length:.3g} {numbers.form.unit} within the validity.")
    return lines


FORMAT = Format("imucal", ".imucal.json", to_imucal, from_imucal, LOSES, _lacks)
