"""How a cell of package and table solved together is judged, for the study of silent scenes."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from physics_scenes import campaigns
from silent_cells import JudgedCell, holds, named, offset_and_k, significant
from silent_declared import separated
from solved_campaigns import ARCSEC, rows_of_package

from ams.arrays import FloatArray
from ams.calibration.jointly import calibrate_jointly
from ams.calibration_result import AxisCalibration
from ams.frames import Attitude
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import PitchRoll
from ams.models.extended import ExtendedPitchRoll
from ams.solve.table_errors import TablePriors
from ams.statistics.intervals import combined_dof, t_quantile

_STEPS = 60
_NORMAL = 1.959964
_REQUEST = CalibrationRequest(nominal_axes={axis: axis for axis in "xyz"})


def of_joint(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge joint fits of one mounting, one by one; before, linear sensors with ±1.96 u and no findings."""
    design, declared = separated(design)
    chance = np.random.default_rng(seed)
    drawn = campaigns(scene, size, chance, count, **design)
    points, limit = drawn.points_deg, drawn.setup.pitch_limit_deg
    offset, k = drawn.package.best_linear(points[:, 0], points[:, 1])
    at_deg = chance.uniform(-limit, limit, _STEPS), chance.uniform(-180.0, 180.0, _STEPS)
    true_v = drawn.true_output_v(*at_deg)[:, :, 0]
    table, _ = declared.table(scene)
    request, kinds, widths = replace(_REQUEST, shared_errors=declared.by_axis), [], []
    held: dict[str, list[FloatArray]] = {"after": [], "before": []}
    predicted: dict[str, list[FloatArray]] = {"after": [], "before": []}
    for index in range(count):
        rows, kinds_found = rows_of_package(drawn, index), set[str]()
        for word in held:
            wanted = replace(request, extended="yes" if word == "after" else "no")
            found = calibrate_jointly(rows, wanted, TablePriors(table))
            for which, axis in enumerate(found.axes.values()):
                truth = np.append(offset[index, 0, which], k[index, 0, which])
                at_v, u_v, half_v = _prediction(axis, Attitude(*np.deg2rad(at_deg)))
                is_after = word == "after"
                held[word].append(holds(axis, truth) if is_after else _holds_normal(axis, truth))
                away_v = np.abs(at_v - true_v[index, :, which])
                predicted[word].append(away_v <= (half_v if is_after else _NORMAL * u_v))
                if is_after:
                    widths.append(float(half_v.mean() / np.linalg.norm(truth[1:])) / ARCSEC)
                    kinds_found |= significant(axis.findings)
        kinds.append(kinds_found)
    shares = {
        word: {**offset_and_k(np.array(each)), "prediction": float(np.mean(predicted[word]))}
        for word, each in held.items()
    }
    rings = float(np.mean([bool(of_campaign) for of_campaign in kinds]))
    share = named(scene, size, kinds, design)
    return JudgedCell(shares["after"], shares["before"], share, rings, float(np.mean(widths)))


def _holds_normal(axis: AxisCalibration, truth: FloatArray) -> FloatArray:
    u = np.sqrt(np.diag(axis.primary_covariance)[: truth.size])
    return np.asarray(np.abs(axis.primary[: truth.size] - truth) <= _NORMAL * u)


def _prediction(axis: AxisCalibration, at: Attitude) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the output at some attitudes, its standard uncertainty and half of its 95 % interval, volts."""
    centring = axis.centring
    model = ExtendedPitchRoll(axis.nominal_axis, centring) if centring else PitchRoll(axis.nominal_axis)
    directions = model.jacobian(axis.primary, at)
    parts = np.stack(
        [np.einsum("np,pq,nq->n", directions, part.covariance, directions) for part in axis.variance_components]
    )
    dof = combined_dof(parts, np.array([part.dof for part in axis.variance_components])[:, None])
    u_v = np.sqrt(parts.sum(axis=0))
    return directions @ axis.primary, u_v, np.asarray(t_quantile(0.95, dof) * u_v)
