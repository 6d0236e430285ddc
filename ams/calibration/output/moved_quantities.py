"""How far the quantities of an axis moved from replication to replication, in words."""

import numpy as np

from ams.analysis.diagnostics.size_words import Scale
from ams.analysis.replication import quantity
from ams.arrays import FloatArray
from ams.calibration.solving.columns import SolvedColumns
from ams.frames import wrap_deg
from ams.rounding import significant
from ams.units import in_words, label_and_unit


def moves_between(solved: SolvedColumns, index: int, scale: Scale) -> dict[str, str]:
    """Return how far each quantity moved from replication to replication, in words."""
    if solved.replication is None:
        return {}
    found: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    for estimates in solved.per_replication(index).values():
        for name, value in estimates.items():
            found.setdefault(quantity(name), []).append(value)
            units[quantity(name)] = name
    return {
        name: _move(units[name], _span(name, np.array(values)), float(np.mean(values)), scale)
        for name, values in found.items()
        if name in solved.replication.drift
    }


def _span(name: str, values: FloatArray) -> float:
    if name.startswith("azimuth"):
        values = values[0] + wrap_deg(values - values[0])
    return float(np.ptp(values)) if np.isfinite(values).all() else float("nan")


def _move(name: str, span: float, mean: float, scale: Scale) -> str:
    if name == "offset_v":
        return scale.words(span)
    if name.startswith("sensitivity_v") and mean != 0.0:
        return f"{significant(1e6 * span / abs(mean))} ppm"
    return in_words(span, label_and_unit(name)[1], 3 if name.endswith("_deg") else 2)
