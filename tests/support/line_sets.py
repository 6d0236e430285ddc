"""Coefficient sets of SR's straight lines, solved from levels and readings made by plain arithmetic."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from solved_sets import SITE

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.models.field_triad import FieldTriad
from ams.models.model import Model
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance, level_ranges

LEVELS_UT = np.tile([-40.0, -15.0, 20.0, 40.0], 4)
MATRIX = np.array([[31.2, 0.3, -0.2], [-0.25, -30.9, 0.1], [0.15, 0.4, 31.5]])
"""Counts per µT: three sensitive axes that lie a little beside the package's, the second with its sign turned."""
ZERO_COUNTS = np.array([12.0, -52.865, 101.32])


def line_set(
    truths: Mapping[str, tuple[float, float]],
    unit: str = "ut",
    measured_unit: str = "counts",
    *,
    levels: np.ndarray = LEVELS_UT,
    scatter: float = 0.0,
    seed: int = 1,
) -> CoefficientSet:
    """Return the set of lines real = A·measured + B along their nominal axes; ``truths``: axis to A and B."""
    chance, solved = np.random.default_rng(seed), {}
    for axis, (gain, offset) in truths.items():
        reading = (levels - offset) / gain + scatter * chance.normal(size=levels.size)
        solved[axis] = _solved(axis, StraightLine(axis, unit, measured_unit), _rows(axis, levels, reading))
    return set_of_lines(solved)


def triad_set() -> CoefficientSet:
    """Return the set of a magnetometer that was turned in a known field, with cross sensitivities."""
    pitch, roll = (np.deg2rad(entry.ravel()) for entry in np.meshgrid(np.arange(-90, 91, 30), np.arange(-180, 180, 45)))
    applied = np.tile([0.0, 40.0], (pitch.size + 1) // 2)[: pitch.size]
    identity = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    solved = {}
    for index, axis in enumerate("xyz"):
        model = FieldTriad(axis, "ut", "counts", identity, (0.0, 0.0, 1.0), (22.0, -3.0, 40.0))
        rows = replace(_rows(axis, applied, np.zeros(applied.size)), pitch_rad=pitch, roll_rad=roll)
        basis = model.basis(rows)
        order = [index, *(other for other in range(3) if other != index)]
        reading = basis @ np.array([ZERO_COUNTS[index], *MATRIX[index, order]])
        solved[axis] = _solved(axis, model, replace(rows, outputs={axis: reading}))
    return set_of_lines(solved)


def set_of_lines(solved: Mapping[str, Calibration]) -> CoefficientSet:
    """Return the set of axes that were solved each by itself."""
    together = Calibration({axis: entry.axes[axis] for axis, entry in solved.items()}, "linear", "SR")
    ranges = {"pitch_range_deg": (0.0, 0.0), "roll_range_deg": (0.0, 0.0), "level_ranges": level_ranges(together)}
    return build_set(together, Provenance(sensor="M1", run_id="20260301T080000Z-coil", **SITE, **ranges))


def _rows(axis: str, levels: np.ndarray, reading: np.ndarray) -> Observations:
    nothing, count = np.zeros(levels.size), levels.size // 4
    return Observations(
        np.repeat(np.arange(4), count) if levels.size % 4 == 0 else np.ones(levels.size, dtype=int),
        np.tile(np.arange(count), 4) if levels.size % 4 == 0 else np.arange(levels.size),
        nothing, nothing, {axis: reading}, units={axis: "counts"}, reference_level=levels,
    )  # fmt: skip


def _solved(axis: str, model: Model, rows: Observations) -> Calibration:
    rows = replace(rows, units={axis: model.measured_unit})
    return calibrate(rows, CalibrationRequest(nominal_axes={axis: axis}, models={axis: model}))
