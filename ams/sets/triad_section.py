"""Three straight lines together, as a matrix: what IMU software takes, and how square the package is.

Everything in it follows from the axes' numbers; who reads a set finds it again and refuses a set whose own differs.
"""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from ams.arrays import FloatArray
from ams.errors import VectorsDisagree
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.equations import AxisNumbers, are_lines
from ams.sets.vectors import resolves

TEXT = (
    "outputs = zero_level + matrix level; level = inverse (outputs - zero_level); rows of the matrix in the order of "
    "axes, its columns x, y, z of the package; angles between the sensitive axes, 90 where the package is square, not "
    "there where the lines are along their nominal axes alone"
)
_TOLERANCE_RELATIVE = 1e-9


def has_unmeasured_directions(axes: Mapping[str, AxisNumbers]) -> bool:
    """Return whether two straight lines or more are along their nominal axes alone: how these lie nobody measured."""
    lines = are_lines(axes) and len(axes) > 1
    return lines and not any(_tells_direction(numbers) for numbers in axes.values())


def _tells_direction(numbers: AxisNumbers) -> bool:
    return all(name in numbers.primary for name in numbers.form.directions)


def triad_section(axes: Mapping[str, AxisNumbers]) -> Document:
    """Return ``{"triad": …}``, nothing where the axes are no three straight lines that resolve three directions."""
    forms = [numbers.form for numbers in axes.values()]
    if not are_lines(axes) or not resolves(axes):
        return {}
    matrix = np.stack([numbers.direction for numbers in axes.values()])
    measured, unit = forms[0].measured_unit, forms[0].unit
    has_all = all(_tells_direction(numbers) for numbers in axes.values())
    angles = (
        {"angle_between_deg": _angles_deg(matrix, [axis.nominal_axis for axis in axes.values()])} if has_all else {}
    )
    return {
        "triad": {
            "axes": list(axes),
            f"matrix_{measured}_per_{unit}": _rows(matrix),
            f"inverse_{unit}_per_{measured}": _rows(np.asarray(np.linalg.inv(matrix), dtype=float)),
            f"zero_level_{measured}": [numbers.primary[numbers.form.offset] for numbers in axes.values()],
            **angles,
            "text": TEXT,
        }
    }


def check_triad(axes: Mapping[str, AxisNumbers], document: Mapping[str, Json], where: str) -> None:
    """Refuse a matrix that is not that of the axes. Raises: VectorsDisagree."""
    if "triad" not in document:
        return
    stated, computed = table(document["triad"]), table(triad_section(axes).get("triad", {}))
    # Its text may be that of another version, and an entry of another version is none of ours to judge.
    wrong = [
        name for name in computed if name != "text" and name in stated and not _agrees(stated[name], computed[name])
    ]
    if wrong or not computed:
        raise VectorsDisagree(
            f"{where}: triad: {', '.join(wrong) or 'there is none'}: not what the axes' coefficients make; do not use "
            "this set; it was assembled wrongly"
        )


def _agrees(stated: Json, computed: Json) -> bool:
    if isinstance(computed, dict):
        return all(_agrees(table(stated).get(name), value) for name, value in computed.items())
    if isinstance(computed, list):
        others = listed(stated)
        scale = max((abs(number(value)) for value in _flat(computed)), default=0.0)
        pairs = zip(_flat(others), _flat(computed), strict=False)
        return len(_flat(others)) == len(_flat(computed)) and all(_near(a, b, scale) for a, b in pairs)
    return _near(stated, computed, 180.0)


def _flat(values: list[Json]) -> list[Json]:
    return [
        item for value in values for item in (value if isinstance(value, list) else [value]) if type(item) is not str
    ]


def _near(stated: Json, computed: Json, scale: float) -> bool:
    if isinstance(computed, str):
        return stated == computed
    return abs(number(stated) - number(computed)) <= _TOLERANCE_RELATIVE * scale


def _rows(matrix: FloatArray) -> list[Json]:
    return [[float(value) for value in row] for row in matrix]


def _angles_deg(matrix: FloatArray, nominal: list[str]) -> Document:
    """Return the angle between every two sensitive axes, polarity taken off."""
    signs = [np.sign(row["xyz".index(axis)]) or 1.0 for row, axis in zip(matrix, nominal, strict=True)]
    units = [sign * row / np.linalg.norm(row) for sign, row in zip(signs, matrix, strict=True)]
    return {
        f"{nominal[a]}{nominal[b]}": float(
            np.degrees(np.arctan2(np.linalg.norm(np.cross(units[a], units[b])), units[a] @ units[b]))
        )
        for a, b in combinations(range(3), 2)
    }
