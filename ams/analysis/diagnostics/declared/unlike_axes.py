"""Axes whose sensitivity is unlike that of the others of their package, of which nobody declared how much they read.

Elements of one package are alike within a few times: one that reads a hundredth of its siblings is dead but for what it
picks up, loose, or written in another unit. A channel of another range or gain is as unlike, so that it is told, and a
person judges it; a declared sensitivity says what is meant, and is what an axis is held against instead.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from statistics import median_low
from typing import Final

import numpy as np

from ams.analysis.diagnostics.declared.declared_axis import KIND, component_indices
from ams.calibration_result import AxisCalibration
from ams.findings import UNLIKE_SIZE, Finding, leaves_nothing
from ams.inputs.declared_direction import DeclaredDirection
from ams.rounding import significant
from ams.units import label_and_unit

_UNLIKE: Final = 20.0
"""Times: ranges of elements that are meant to be used together differ by less."""
_FAR: Final = 5.0
"""Standard uncertainties that a sensitivity may be off."""


def with_unlike_axes(
    axes: Mapping[str, AxisCalibration], declared: Mapping[str, DeclaredDirection]
) -> Mapping[str, AxisCalibration]:
    """Return the axes of one package, with a finding of each that reads twenty times less or more than the middle one.

    Of two the weaker one is told.
    """
    unlike = dict(_unlike(axes, declared))
    return {label: _with(axis, unlike[label]) if label in unlike else axis for label, axis in axes.items()}


def _with(axis: AxisCalibration, finding: Finding) -> AxisCalibration:
    return replace(axis, findings=(*axis.findings, finding), warnings=(*axis.warnings, finding.text))


def _unlike(
    axes: Mapping[str, AxisCalibration], declared: Mapping[str, DeclaredDirection]
) -> Iterator[tuple[str, Finding]]:
    """Yield labels and findings; axes whose sensitivities have the same unit are held against each other."""
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for label, axis in axes.items():
        at = component_indices(axis.primary_names).get(axis.nominal_axis)
        if at is None or any(map(leaves_nothing, axis.findings)):
            continue
        name = axis.primary_names[at].removeprefix(f"k_{axis.nominal_axis}_")
        u = float(np.sqrt(max(float(axis.primary_covariance[at, at]), 0.0)))
        found.setdefault(name, {})[label] = abs(float(axis.primary[at])), u
    for name, alike in found.items():
        sizes = [size for size, _ in alike.values()]
        usual = median_low(sizes) if len(sizes) > 2 else max(sizes)
        for label, (size, u) in alike.items():
            is_declared = label in declared and declared[label].sensitivity is not None
            if not is_declared and (_UNLIKE * (size + _FAR * u) < usual or size - _FAR * u > _UNLIKE * usual):
                yield label, _finding(size, usual, name)


def _finding(size: float, usual: float, name: str) -> Finding:
    unit = label_and_unit(f"sensitivity_{name}")[1]
    times = size / usual
    unlike = f"{significant(times, 3)} times" if times > 1.0 else f"1/{significant(1.0 / times, 3)} of"
    fact = (
        f"the sensitivity is {significant(size, 4)} {unit}, {unlike} that of the other axes ({significant(usual, 4)} "
        f"{unit}): the element is dead but for what it picks up, a line is loose, its numbers are in another unit, or "
        "it is of another range; nobody declared which"
    )
    what_to_do = "look at the channel, or declare what is meant (nominal_sensitivity_… of a rig file) and solve again"
    details: dict[str, float | str | None] = {f"{UNLIKE_SIZE}{name}": usual, f"sensitivity_{name}": size}
    return Finding(KIND, fact, True, None, details=details, what_to_do=what_to_do)
