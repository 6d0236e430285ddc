"""What the stated uncertainties of one output may hold, by what is declared of its sensor."""

from collections.abc import Mapping, Sequence

import numpy as np

from ams.analysis.diagnostics.beliefs import LACK_OF_FIT, AxisTests
from ams.analysis.diagnostics.declared.differing_replications import LARGEST, ShiftLimits
from ams.analysis.diagnostics.declared.laid_points import is_alike_over_turns
from ams.analysis.diagnostics.locations import alike_over
from ams.analysis.diagnostics.size_words import Scale
from ams.analysis.diagnostics.stated_limits import LARGEST_LACK
from ams.analysis.diagnostics.tested_terms import AnyGyro, tested_base
from ams.analysis.diagnostics.words.held_words import TURNS
from ams.calibration.output.believed import Believed
from ams.calibration.steps import step_words
from ams.inputs.shared_errors import G_SENSITIVITY, NONLINEARITY, SHIFTS_WITHIN, SharedError
from ams.observations import Observations


def declared_departure(shared: Sequence[SharedError]) -> float:
    """Return how far the sensor is declared to be from its equation at most, in the output's unit; 0: not declared."""
    return max((error.limit for error in shared if error.name == NONLINEARITY), default=0.0)


def largest_lack(seen: Believed, shared: Sequence[SharedError]) -> float:
    """Return the lack of fit that the stated uncertainties may hold, in the output's unit."""
    model, primary = seen.solved.problem.models[seen.index], seen.solved.primary[seen.index]
    of_full = np.linalg.norm(primary[1:4])
    if seen.rows.is_of_levels:
        of_full = 0.5 * np.ptp(model.predict(primary, seen.rows))
    return max(declared_departure(shared), LARGEST_LACK * float(of_full))


def largest_shifts(scale: Scale, shared: Sequence[SharedError]) -> ShiftLimits:
    """Return what replications of an axis may differ by: what is declared of the sensor, where that is more."""
    limits = shift_limits(shared)
    per_g = scale.volts_per_radian
    offset_g = 0.0 if per_g is None else limits[step_words.OFFSET_LIMIT] / per_g
    return ShiftLimits(max(LARGEST, limits[step_words.SENSITIVITY_LIMIT]), max(LARGEST, offset_g))


def shift_limits(shared: Sequence[SharedError]) -> Mapping[str, float]:
    """Return by key what a sensor is declared to shift by while it is calibrated; 0 where nothing is."""
    keys = zip((step_words.OFFSET_LIMIT, step_words.SENSITIVITY_LIMIT), SHIFTS_WITHIN, strict=True)
    return {key: max((error.limit for error in shared if error.name == name), default=0.0) for key, name in keys}


def declared_g_sensitivity(shared: Sequence[SharedError]) -> float | None:
    """Return the limit of what gravity does to a gyro, °/s per g; None where none is declared."""
    return next((error.limit for error in shared if error.name == G_SENSITIVITY), None)


def counts_earth(rows: Observations, shared: Sequence[SharedError]) -> bool:
    """Return whether the rates of the rows have the Earth's, or what is not known of it is an error that they share."""
    return rows.from_level is not None or any(error.effect == "rotation" for error in shared)


def lack_alike_over(seen: Believed, tests: AxisTests, departure: float) -> tuple[str, ...]:
    """Return the axes of the table over whose indices a lack of fit that is told goes alike; of gyros :data:`TURNS`.

    None where it is within the ``departure`` that is declared of the sensor, which may be alike.
    """
    if not tests.is_significant.get(LACK_OF_FIT) or tests.tests[LACK_OF_FIT].size <= departure:
        return ()
    known = seen.evidence.layout.mean_by_point(seen.taken)
    if isinstance(tested_base(seen.evidence.models[seen.index]), AnyGyro):
        return (TURNS,) if is_alike_over_turns(seen.evidence, seen.index, known) else ()
    return () if seen.accelerometer is None else alike_over(seen.evidence, seen.index, known)
