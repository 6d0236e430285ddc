"""What estimated temperature coefficients do not tell: how offset and sensitivity bend where nothing was measured.

A polynomial of order n over n + 1 temperatures leaves nothing over: whatever the sensor does between them, it goes
through what was read. Of two temperatures a bend stands in no residual, and moves offset and sensitivity at the
reference by all of itself where that lies between; of three, so does a bend of third order, which is zero at all of
them beside a straight line. Beyond the temperatures measured no polynomial is tested, of whatever order.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.models.added_parameters import WithAddedParameters
from ams.models.model import Model
from ams.models.thermal import WithTemperature, tells_curvature
from ams.observations import Observations
from ams.sets.verdict_conditions import CUBIC_BEND_UNDETERMINED, CURVATURE_UNDETERMINED, REFERENCE_NOT_MEASURED
from ams.solve.whole_plots import SMALLEST_GAP_DEGC

_HOLDS: Final = (
    "hold only for a sensor that runs straight over temperature, and what a bend does there is in no figure stated here"
)
_ELSEWHERE: Final = (
    "measure near the reference as well, or state them at a temperature that was measured (calrig fit: "
    "--reference-temperature-degc)"
)


def curvature_warnings(rows: Observations, model: Model) -> tuple[str, ...]:
    """Return the reservation about curvature that the temperatures do not tell, the reference named; else nothing."""
    fitted, temperature = _estimated(model), rows.temperature_degc
    if fitted is None or temperature is None:
        return ()
    reference, levels = fitted.reference_degc, held_degc(temperature)
    low, high = levels if len(levels) == 2 else (float(temperature.min()), float(temperature.max()))
    away_degc = float(np.abs(temperature - reference).min())
    if fitted.order == 1 and (len(levels) == 2 or not tells_curvature(temperature)):
        between = "nowhere" if len(levels) == 2 else "hardly"
        ends = f"{_rounded(low)} and {_rounded(high)}"
        measured = f"it was measured at {ends} °C and {between} between"
        if away_degc <= SMALLEST_GAP_DEGC:
            return (
                f"{CURVATURE_UNDETERMINED}: {measured}: there, up to {0.5 * _widest_gap(temperature):.2g} °C from the "
                f"nearest, offset and sensitivities {_HOLDS}; measure at a temperature between as well",
            )
        return (
            f"{REFERENCE_NOT_MEASURED}: {_rounded(reference)} °C lies {away_degc:.2g} °C from the nearest temperature; "
            f"{measured}, which tells no curvature: offset and sensitivities there, and wherever it was not "
            f"measured, {_HOLDS}; {_ELSEWHERE}",
        )
    if away_degc > SMALLEST_GAP_DEGC and not low < reference < high:
        return (
            f"{REFERENCE_NOT_MEASURED}: {_rounded(reference)} °C lies {away_degc:.2g} °C beyond {_rounded(low)} to "
            f"{_rounded(high)} °C, where it was measured: offset and sensitivities there hold only if they run on as "
            f"they were fitted, and what they do otherwise is in no figure stated here; {_ELSEWHERE}",
        )
    return ()


def bend_remarks(rows: Observations, model: Model) -> tuple[str, ...]:
    """Return that three temperatures do not tell a bend of third order, where there are three; else nothing."""
    fitted, temperature = _estimated(model), rows.temperature_degc
    levels = () if fitted is None or temperature is None else held_degc(temperature)
    if temperature is None or len(levels) != 3:
        return ()
    first, second, third = map(_rounded, levels)
    return (
        f"{CUBIC_BEND_UNDETERMINED} ({first}, {second} and {third} °C): between, up to "
        f"{0.5 * _widest_gap(temperature):.2g} °C from the nearest, what one does to offset and sensitivities is not "
        "in the uncertainty; a fourth temperature tells it",
    )


def held_degc(temperature_degc: FloatArray) -> tuple[float, ...]:
    """Return the means of the temperatures that (N,) recorded ones gather at; none where they lie no farther apart."""
    ordered = np.sort(temperature_degc)
    gaps = np.diff(ordered)
    groups = np.split(ordered, np.flatnonzero(gaps >= SMALLEST_GAP_DEGC) + 1)
    spread = max(float(np.ptp(group)) for group in groups)
    between = gaps[gaps >= SMALLEST_GAP_DEGC]
    return tuple(float(group.mean()) for group in groups) if between.size and spread <= between.min() else ()


def _rounded(degc: float) -> str:
    return f"{round(degc, 1):g}"


def _widest_gap(temperature_degc: FloatArray) -> float:
    return float(np.diff(np.sort(temperature_degc)).max())


def _estimated(model: Model) -> WithTemperature | None:
    """Return the temperature terms of a model where they are estimated."""
    while not isinstance(model, WithTemperature):
        if not isinstance(model, WithAddedParameters):
            return None
        model = model.base
    return model if model.known is None else None
