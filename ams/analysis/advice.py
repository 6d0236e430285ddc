"""What the replication tests advise, as plain values and as sentences that a report can print.

Lack of fit: which Fourier terms in pitch and roll repeat in the residuals, how large they are in volts and degrees, and
what usually causes them. Drift: which parameter, how much a replication and how much an hour. Source: TP 8 and 9.2.
"""

from dataclasses import dataclass

import numpy as np

from ams.analysis.fourier_terms import FourierTerm, fourier_basis, largest_terms
from ams.analysis.predictions import model_of_solution
from ams.analysis.replication import quantity
from ams.analysis.residual_causes import MISALIGNED, SHARES, usual_cause
from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration, Replication
from ams.frames import specific_force
from ams.models.extended import CONFOUNDED
from ams.models.registry import MODELS, is_solved_from_levels
from ams.observations import Observations
from ams.rounding import significant
from ams.solve.layout import Layout, layout_of
from ams.statistics.intervals import t_quantile
from ams.units import ARCSEC_PER_DEG

MOST_TERMS = 4
"""Of a Fourier series that are named, the largest first."""
_LARGEST_ANGLE_DEG = 10.0
"""Beyond it amplitude over sensitivity is no angle any more."""
_SHARED_WITH_THE_TABLE = ("sin 2α", "cos 2α")


@dataclass(frozen=True)
class ResidualTerm:
    """A Fourier term of the residuals that repeats from replication to replication."""

    name: str
    """Such as ``sin 2α·cos R``."""
    amplitude_v: float
    interval_95_v: tuple[float, float]
    amplitude_deg: float
    """Of pitch or roll where the sensor is most sensitive: amplitude over sensitivity."""
    interval_95_deg: tuple[float, float]
    cause: str


@dataclass(frozen=True)
class DriftRate:
    """How a parameter moved through the run: the straight line through its estimates from each replication alone."""

    parameter: str
    """Name with its unit, such as ``offset_v``."""
    per_replication: float
    """In the parameter's unit."""
    interval_95: tuple[float, float] | None
    """None with two replications: a line through two points has no error to judge it by."""
    per_hour: float | None
    """None where no times were recorded."""
    per_hour_interval_95: tuple[float, float] | None


@dataclass(frozen=True)
class Advice:
    """Of one sensor axis."""

    lack_of_fit: tuple[ResidualTerm, ...]
    """Largest first; empty where there is no significant lack of fit, or none of its terms stands out."""
    drift: tuple[DriftRate, ...]
    """Of the parameters whose drift is significant."""
    sentences: tuple[str, ...]


def advise(axis: AxisCalibration, observations: Observations) -> Advice:
    """Return advice on one axis from the observations that it was solved from."""
    replication = axis.replication
    terms = _terms(axis, observations) if replication is None or replication.lack_of_fit.is_significant else ()
    rates = () if replication is None else _rates(replication, observations)
    sentences = [_term_sentence(term) for term in terms]
    if any(term.name in _SHARED_WITH_THE_TABLE for term in terms):
        sentences.append(f"{CONFOUNDED[0].upper()}{CONFOUNDED[1:]}.")
    if replication is not None and replication.lack_of_fit.is_significant and not terms:
        sentences.append(_without_pattern(axis))
    return Advice(terms, rates, (*sentences, *map(_rate_sentence, rates)))


def _without_pattern(axis: AxisCalibration) -> str:
    """Say what lack of fit without known terms usually is, for the points that the model has."""
    if any(name.endswith("_v_per_dps") for name in axis.primary_names):
        return (
            "The lack of fit is not looked at term by term: a gyro that feels gravity, the Earth's rotation, a rate "
            "that the table does not hold or a scale that bends with the rate do that."
        )
    if is_solved_from_levels(axis.model):
        return "The lack of fit is not looked at term by term: a line that bends or levels that are wrong do that."
    return "The lack of fit has no regular pattern in pitch and roll: single indices of the table do that."


def _terms(axis: AxisCalibration, observations: Observations) -> tuple[ResidualTerm, ...]:
    sensitivity = float(np.sqrt(np.nansum(np.square(axis.sensitive_axis_v_per_g))))
    if sensitivity == 0.0 or not any(name.endswith("_v_per_g") for name in axis.primary_names):
        return ()
    layout = layout_of(observations)
    jacobian = model_of_solution(axis).jacobian(axis.primary, observations)
    first = np.unique(layout.point, return_index=True)[1]
    pitch, roll = _equivalent_attitude(axis.model, observations)
    candidates = fourier_basis(pitch[first], roll[first])
    residuals = layout.mean_by_point(axis.residuals_v)
    found = largest_terms(residuals, layout.mean_by_point(jacobian), candidates, MOST_TERMS)
    return tuple(_in_degrees(term, sensitivity, axis) for term in found)


def _equivalent_attitude(model: str, observations: Observations) -> tuple[FloatArray, FloatArray]:
    """Return (N,) pitch and roll; with yaw those without it at which the package feels the same."""
    if observations.yaw_rad is None or not observations.yaw_rad.any():
        return observations.pitch_rad, observations.roll_rad
    roll = np.zeros_like(observations.roll_rad) if model.endswith("-sting") else observations.roll_rad
    x, y, z = specific_force(observations.pitch_rad, roll, observations.yaw_rad).T
    return np.arctan2(x, np.hypot(y, z)), np.arctan2(-y, -z)


def _in_degrees(term: FourierTerm, sensitivity: float, axis: AxisCalibration) -> ResidualTerm:
    amplitude, low, high = np.rad2deg(np.array([term.amplitude_v, *term.interval_95_v]) / sensitivity).tolist()
    cause = (
        MISALIGNED if _is_straight(axis.model) and term.name in SHARES else usual_cause(term.name, axis.nominal_axis)
    )
    if any(finding.is_significant and finding.kind == "drift" for finding in axis.findings):
        cause = f"what the drift leaves, as the order of the points has it; else {cause}"
    return ResidualTerm(term.name, term.amplitude_v, term.interval_95_v, amplitude, (low, high), cause)


def _rates(replication: Replication, observations: Observations) -> tuple[DriftRate, ...]:
    names = [name for name in next(iter(replication.per_replication.values())) if _drifts(name, replication)]
    layout = layout_of(observations)
    hours = _mean_hours(layout, observations, replication)
    return tuple(_rate(name, replication, hours) for name in names)


def _drifts(name: str, replication: Replication) -> bool:
    test = replication.drift.get(quantity(name))
    return test is not None and test.is_significant


def _mean_hours(layout: Layout, observations: Observations, replication: Replication) -> FloatArray | None:
    """Return the (n,) middle of every replication that was solved."""
    if observations.time_s is None:
        return None
    means = layout.sum_by_replication(observations.time_s) / np.bincount(layout.replication)
    known = dict(zip(layout.replication_labels, means / 3600.0, strict=True))
    return np.array([known[label] for label in replication.per_replication])


def _rate(name: str, replication: Replication, hours: FloatArray | None) -> DriftRate:
    values = np.array([row[name] for row in replication.per_replication.values()])
    if name == "azimuth_deg":
        values = np.rad2deg(np.unwrap(np.deg2rad(values)))
    slope, interval = _line(np.arange(values.size, dtype=float), values)
    if hours is None or not np.ptp(hours) > 0.0:
        return DriftRate(name, slope, interval, None, None)
    return DriftRate(name, slope, interval, *_line(hours, values))


def _line(at: FloatArray, values: FloatArray) -> tuple[float, tuple[float, float] | None]:
    """Return the slope of the straight line with its 95 % interval."""
    centred = at - at.mean()
    square = float(centred @ centred)
    slope = float(centred @ values) / square
    if values.size < 3:
        return slope, None
    left = values - values.mean() - slope * centred
    dof = values.size - 2
    half = float(t_quantile(0.95, dof)) * float(np.sqrt(left @ left / dof / square))
    return slope, (slope - half, slope + half)


def _term_sentence(term: ResidualTerm) -> str:
    if abs(term.amplitude_deg) > _LARGEST_ANGLE_DEG:
        amplitude = f"{significant(term.amplitude_v)} V"
        return f"The residuals repeat as {term.name} with {amplitude}: no small error of a good model."
    low, high = map(_angle, term.interval_95_deg)
    return (
        f"The residuals repeat as {term.name} with {_angle(term.amplitude_deg)} ({_number(1e6 * term.amplitude_v)} µV; "
        f"95 %: {low} to {high}): usually {term.cause}."
    )


def _angle(angle_deg: float) -> str:
    """Return an angle in words: arc seconds below a tenth of a degree."""
    return f"{_number(angle_deg)}°" if abs(angle_deg) >= 0.1 else f"{_number(ARCSEC_PER_DEG * angle_deg)}″"


def _number(value: float) -> str:
    """Return a number in words: two significant digits, or all before the point, with a minus that reads as one."""
    text = f"{value:.0f}" if abs(value) >= 10.0 else f"{value:.2g}"
    return text.replace("-", "−")


def _rate_sentence(rate: DriftRate) -> str:
    words, unit = quantity(rate.parameter).replace("_", " "), _unit(rate.parameter)
    factor = ARCSEC_PER_DEG if unit == "″" else 1e6 if unit.startswith("µ") else 1.0
    a_replication = f"{_signed(factor * rate.per_replication)} {unit} a replication"
    if rate.interval_95 is not None:
        low, high = rate.interval_95
        a_replication += f" (95 %: {_signed(factor * low)} to {_signed(factor * high)})"
        if low < 0.0 < high:
            return f"{words.capitalize()} changes between the replications without a trend: {a_replication}."
    an_hour = "" if rate.per_hour is None else f", {_signed(factor * rate.per_hour)} {unit} an hour"
    return f"{words.capitalize()} drifts by {a_replication}{an_hour}."


def _unit(parameter: str) -> str:
    unit = parameter.removeprefix(quantity(parameter) + "_")
    return {"v": "µV", "v_per_g": "µV/g", "v_per_g2": "µV/g²", "deg": "″", "v_per_dps": "µV/(°/s)"}.get(unit, unit)


def _signed(value: float) -> str:
    return ("+" if value >= 0.0 else "") + _number(value)


def _is_straight(model: str) -> bool:
    """Return whether the model has no term for a misalignment."""
    return model in MODELS and not MODELS[model].has_misalignment
