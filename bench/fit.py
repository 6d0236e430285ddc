"""The fit of 481 points in six replications: ours against scipy's ``curve_fit``, lmfit and a Gauss-Newton that
goes row by row; then a batch of packages, and simulated campaigns.

The race is between equals: from the same rows to the same four parameters with their pooled covariance. What
``calibrate`` adds (mixed-model covariance, replication tests, effective degrees of freedom, intervals, residuals) is
timed on its own, and is what every axis of the batch and of the campaigns gets as well.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
from lmfit import Model as LmfitModel  # type: ignore[import-untyped]
from numpy.typing import NDArray
from scipy.optimize import curve_fit

from ams.calibration.calibrate import calibrate
from ams.calibration.solving.columns import solve_columns
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.solve.linear_form import factor
from ams.units import RAD_PER_ARCSEC
from bench.figure import Effort, Figure

FloatArray = NDArray[np.float64]
REPLICATIONS = 6
TRUTH = (0.005, 2.5, math.radians(0.5), math.radians(35.0))
START = (0.0, 2.5, math.radians(1.0), 0.0)
NOISE_V = 6e-6
_TURNS_RAD = count(2e-11, 2e-11)
TABLE = TableUncertainty(RAD_PER_ARCSEC, RAD_PER_ARCSEC, "limit")


def figures(effort: Effort) -> Iterator[Figure]:
    """Times and ratios."""
    observations = campaign()
    request = CalibrationRequest(nominal_axes={"x": "x"})
    agree(observations)
    recorded = as_recorded(observations)
    everything_s = effort.best_s(lambda: calibrate(recorded, request))
    first_s = effort.best_s(lambda: calibrate(of_another_design(recorded), request))
    beside_table_s = effort.best_s(lambda: calibrate(recorded, replace(request, table=TABLE)))
    ours_s = effort.best_s(lambda: by_linear_form(observations))
    scipy_s = effort.best_s(lambda: by_curve_fit(observations))
    lmfit_s = effort.best_s(lambda: by_lmfit(observations), repeats=3)
    rows_s = effort.best_s(lambda: by_rows(observations), repeats=3)
    yield Figure("one axis of 481 × 6, parameters and covariance", ours_s * 1e3, "ms", 1.0, at_most=True)
    for peer, peer_s, least in (("curve_fit", scipy_s, 5.0), ("lmfit", lmfit_s, 5.0), ("row by row", rows_s, 50.0)):
        note = f"{peer_s * 1e3:.2f} ms"
        yield Figure(f"  {peer} / ours", peer_s / ours_s, "×", least, at_most=False, note=note, is_gated=True)
    note = f"{first_s * 1e3:.1f} ms of a design's first axis, {beside_table_s * 1e3:.1f} ms under a table's certificate"
    yield Figure(
        "one axis of 481 × 6, everything, findings too", everything_s * 1e3, "ms", 2.0, at_most=True, note=note
    )
    yield from _many(observations, effort)
    yield _at_scattered_angles(effort, None)
    yield _at_scattered_angles(effort, TABLE)


def _at_scattered_angles(effort: Effort, table: TableUncertainty | None) -> Figure:
    """A package whose dwells stand at an angle of their own each, so that none shares an error of the table."""
    rng, dwells = np.random.default_rng(3), effort.amount(481, 60)
    grid = np.linspace(-1.2, 1.2, 37)[np.arange(dwells) % 37], np.linspace(-3.0, 3.0, 13)[np.arange(dwells) // 37]
    angles = rng.uniform(-1.2, 1.2, dwells), rng.uniform(-3.0, 3.0, dwells)
    request = CalibrationRequest(nominal_axes={axis: axis for axis in "xyz"}, table=table)
    scattered_s, grid_s = (effort.best_s(partial(_solve_anew, *at, rng, request), repeats=2) for at in (angles, grid))
    what = f"{dwells} dwells at an angle each / on a grid{', certified' if table else ''}"
    return Figure(what, scattered_s / grid_s, "×", 30.0 if table else 6.0, at_most=True, note=f"{scattered_s:.1f} s")


def _solve_anew(
    pitch_rad: FloatArray, roll_rad: FloatArray, rng: np.random.Generator, request: CalibrationRequest
) -> None:
    rows = np.arange(1, pitch_rad.size + 1)
    observations = Observations(
        np.ones_like(rows), rows, pitch_rad, roll_rad, {}, time_s=np.asarray(30.0 * rows, dtype=np.float64)
    )
    force = PitchRoll("x").basis(observations)[:, 1:]
    read = 2.5 * force + rng.normal(0.0, NOISE_V, force.shape)
    calibrate(of_another_design(replace(observations, outputs=dict(zip("xyz", read.T, strict=True)))), request)


def of_another_design(observations: Observations) -> Observations:
    """Return the rows at attitudes that nothing is remembered of, a billionth of a degree beside: a first fit."""
    return replace(observations, pitch_rad=observations.pitch_rad + next(_TURNS_RAD))


def _many(observations: Observations, effort: Effort) -> Iterator[Figure]:
    """A batch of packages on one grid, and campaigns simulated and solved."""
    packages, campaigns = effort.amount(100, 2), effort.amount(1000, 2)
    rng = np.random.default_rng(2)
    force = PitchRoll("x").basis(observations)
    models = [PitchRoll(axis) for axis in "xyz"]
    primary = rng.normal(0.0, 0.02, (4, 3 * packages)) + np.tile(2.5 * np.eye(4)[:, 1:], packages)
    outputs_v = force @ primary + rng.normal(0.0, NOISE_V, (observations.rows, 3 * packages))
    packages_s = effort.best_s(lambda: solve_columns(observations, outputs_v, models * packages))
    yield Figure(f"{packages} three-axis packages of 481 × 6", packages_s * 1e3, "ms", 20.0, at_most=True)
    recorded = as_recorded(observations)
    batch = [
        replace(recorded, outputs=dict(zip("xyz", outputs_v.T[first : first + 3], strict=True)))
        for first in range(0, 3 * packages, 3)
    ]
    request = CalibrationRequest(nominal_axes={axis: axis for axis in "xyz"})
    batch_s = effort.best_s(lambda: [calibrate(campaign, request) for campaign in batch], repeats=2)
    yield Figure(f"{packages} three-axis packages, everything", batch_s, "s", 0.6, at_most=True)
    clean_v = (force @ primary[:, :1]) + np.zeros(campaigns)

    def simulate() -> None:
        noise_v = rng.standard_normal(clean_v.shape)
        noise_v *= NOISE_V
        noise_v += clean_v
        solve_columns(observations, noise_v, [models[0]] * campaigns)

    campaigns_s = effort.best_s(simulate, repeats=3)
    yield Figure(f"{campaigns} campaigns of 481 × 6, simulated and solved", campaigns_s, "s", 0.3, at_most=True)


def campaign() -> Observations:
    """±180° pitch by 10°, full roll by 30°, six replications, one axis with white noise."""
    pitch, roll = np.meshgrid(np.deg2rad(np.arange(-180.0, 181.0, 10.0)), np.deg2rad(np.arange(-180.0, 181.0, 30.0)))
    points = pitch.size
    pitch_rad, roll_rad = np.tile(pitch.ravel(), REPLICATIONS), np.tile(roll.ravel(), REPLICATIONS)
    noise = np.random.default_rng(1).normal(0.0, NOISE_V, points * REPLICATIONS)
    return Observations(
        replication=np.repeat(np.arange(1, REPLICATIONS + 1), points),
        point=np.tile(np.arange(1, points + 1), REPLICATIONS),
        pitch_rad=pitch_rad,
        roll_rad=roll_rad,
        outputs={"x": output_v((pitch_rad, roll_rad), *TRUTH) + noise},
    )


def as_recorded(observations: Observations) -> Observations:
    """Return the rows with what a run records beside them: when, and how warm it was."""
    time_s = np.asarray(30.0 * np.arange(observations.rows), dtype=np.float64)
    return replace(observations, time_s=time_s, temperature_degc=20.0 + 0.01 * np.sin(time_s / 5000.0))


def output_v(
    angles: tuple[FloatArray, FloatArray], offset: float, sensitivity: float, coning: float, azimuth: float
) -> FloatArray:
    """TP (2)."""
    pitch, roll = angles
    along, across = np.cos(coning) * np.sin(pitch), np.sin(coning) * np.cos(pitch) * np.sin(roll + azimuth)
    return np.asarray(offset + sensitivity * (along - across))


def by_linear_form(observations: Observations) -> tuple[FloatArray, FloatArray]:
    """Parameters and covariance by the exact linear form and its propagation."""
    model, measured = PitchRoll("x"), observations.outputs["x"]
    form = factor(model.basis(observations), model.primary_names, observations)
    primary = form.solve(measured)
    residuals = measured - form.basis @ primary
    directions = model.parameters_jacobian(primary)
    variance = float(residuals @ residuals) / (observations.rows - primary.size)
    return model.parameters(primary), variance * directions @ form.unscaled_covariance @ directions.T


def by_curve_fit(observations: Observations) -> tuple[FloatArray, FloatArray]:
    """Parameters and covariance by scipy, as its manual has it."""
    angles, rows = (observations.pitch_rad, observations.roll_rad), np.arange(observations.rows)
    fitted = curve_fit(lambda _rows, *c: output_v(angles, *c), rows, observations.outputs["x"], p0=START)
    return np.asarray(fitted[0]), np.asarray(fitted[1])


def by_lmfit(observations: Observations) -> tuple[FloatArray, FloatArray]:
    """Parameters and covariance by lmfit, as its manual has it."""
    angles = (observations.pitch_rad, observations.roll_rad)

    def model_v(rows: FloatArray, offset: float, sensitivity: float, coning: float, azimuth: float) -> FloatArray:
        assert rows.size == angles[0].size
        return output_v(angles, offset, sensitivity, coning, azimuth)

    names = ("offset", "sensitivity", "coning", "azimuth")
    model = LmfitModel(model_v)
    parameters = model.make_params(**dict(zip(names, START, strict=True)))
    fitted = model.fit(observations.outputs["x"], parameters, rows=np.arange(observations.rows, dtype=float))
    return np.array([fitted.best_values[name] for name in names]), np.asarray(fitted.covar)


def by_rows(observations: Observations) -> tuple[FloatArray, FloatArray]:
    """Parameters and covariance by Gauss-Newton with the normal equations summed row after row."""
    rows = list(
        zip(
            observations.pitch_rad.tolist(),
            observations.roll_rad.tolist(),
            observations.outputs["x"].tolist(),
            strict=True,
        )
    )
    estimate: FloatArray = np.array(START)
    step: FloatArray = np.ones(4)
    squares, normal = 0.0, np.eye(4)
    while np.abs(step).max() > 1e-9:
        normal, right, squares = np.zeros((4, 4)), np.zeros(4), 0.0
        b, s, coning, azimuth = estimate.tolist()
        for pitch, roll, measured in rows:
            residual, gradient = _row(pitch, roll, measured, b, s, coning, azimuth)
            normal += np.outer(gradient, gradient)
            right += gradient * residual
            squares += residual * residual
        step = np.asarray(np.linalg.solve(normal, right))
        estimate = estimate + step
    return estimate, np.linalg.inv(normal) * squares / (len(rows) - 4)


def _row(
    pitch: float, roll: float, measured: float, b: float, s: float, coning: float, azimuth: float
) -> tuple[float, FloatArray]:
    sin_pitch, cos_pitch = math.sin(pitch), math.cos(pitch)
    sin_turn, cos_turn = math.sin(roll + azimuth), math.cos(roll + azimuth)
    unit = math.cos(coning) * sin_pitch - math.sin(coning) * cos_pitch * sin_turn
    by_coning = s * (-math.sin(coning) * sin_pitch - math.cos(coning) * cos_pitch * sin_turn)
    by_azimuth = -s * math.sin(coning) * cos_pitch * cos_turn
    return measured - b - s * unit, np.array([1.0, unit, by_coning, by_azimuth])


def agree(observations: Observations) -> None:
    """A race is worth something only between fits that give the same answer."""
    parameters, covariance = by_linear_form(observations)
    for other in (by_curve_fit, by_lmfit, by_rows):
        estimate, others_covariance = other(observations)
        to_edge_unit = np.array([1.0, 1.0, math.degrees(1.0), math.degrees(1.0)])
        uncertainty = np.sqrt(np.diag(others_covariance)) * to_edge_unit
        assert np.all(np.abs(parameters - estimate * to_edge_unit) < 1e-2 * uncertainty), other
        assert np.allclose(np.sqrt(np.diag(covariance)), uncertainty, rtol=1e-3), other
