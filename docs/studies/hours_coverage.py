"""How often the 95 % intervals of simulated campaigns hold the truth: a run's design in the laboratory of the study.

Everything that the laboratory has is drawn anew in each campaign: the table's curve as large as its certificate
allows, or what its list leaves open; sensors, soft mounts, drift, lack of fit and noise.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from hours_laboratory import (
    ARCSEC,
    DRIFT_ARCSEC,
    DWELL_ARCSEC,
    LACK_OF_FIT_ARCSEC,
    LIMIT_ARCSEC,
    LIST_LIMIT_ARCSEC,
    NOISE_V,
    READOUT_NPLC,
    SOFT_ARCSEC,
    TEETH_ARCSEC,
    USAGE_PITCH_DEG,
    V_PER_G,
    Measured,
    curves,
)

from ams.analysis.angle_uncertainty import KnownAxis, inferred
from ams.arrays import FloatArray
from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.frames import Attitude
from ams.inputs.table_uncertainty import TableUncertainty, corrected
from ams.models.extended import ExtendedPitchRoll, centring_of
from ams.observations import Observations
from ams.solve.package import SolvedAxis, package_covariance
from ams.statistics.intervals import t_quantile

BATCH = 250


@dataclass(frozen=True)
class Coverage:
    """Shares of 95 % intervals that hold the truth."""

    shares: tuple[float, float, float, float]
    """Offset, sensitivities, pitch at use, roll at use."""
    half_width_arcsec: float
    """Of pitch at use, root mean square."""


def coverage(run: Measured, campaigns: int, chance: np.random.Generator) -> Coverage:
    """Draw campaigns of the run's design and count what their intervals hold; a dwell of twenty readings at use."""
    held: list[tuple[float, float, float, float]] = []
    squares: list[float] = []
    for first in range(0, campaigns, BATCH):
        _batch(run, min(BATCH, campaigns - first), chance, held, squares)
    shares = np.nanmean(np.array(held), axis=0)
    return Coverage((shares[0], shares[1], shares[2], shares[3]), sqrt(float(np.mean(squares))))


def _batch(
    run: Measured, count: int, chance: np.random.Generator, held: list[tuple[float, ...]], squares: list[float]
) -> None:
    points, n = run.plan.design.points, run.plan.replications
    angles = np.deg2rad([[point.pitch_deg, point.roll_deg] for point in points])
    rows = Observations(
        replication=np.repeat(np.arange(1, n + 1), len(points)),
        point=np.tile(np.arange(1, len(points) + 1), n),
        pitch_rad=np.tile(angles[:, 0], n),
        roll_rad=np.tile(angles[:, 1], n),
        outputs={},
        source="campaign",
    )
    seen = corrected(rows, run.table)
    design = Attitude(seen.pitch_rad[: len(points)], seen.roll_rad[: len(points)])
    stood = [_stood(run.table, axis, angles[:, index], count, chance) for index, axis in enumerate(("pitch", "roll"))]
    true = {axis: true_axis(chance, count, index) for index, axis in enumerate("xyz")}
    outputs = {axis: _outputs(run, *stood, axis_truth, chance) for axis, axis_truth in true.items()}
    solved: dict[str, SolvedColumns] = {}
    for axis in "xyz":
        model = ExtendedPitchRoll(axis, centring_of(design, len(points), axis))
        solved[axis] = solve_columns(rows, outputs[axis], [model] * count, table=run.table)
    pitch = np.deg2rad(chance.uniform(*USAGE_PITCH_DEG, count))
    roll = chance.uniform(-pi, pi, count)
    for row in range(count):
        at = Attitude(pitch[row : row + 1], roll[row : row + 1])
        held.append(_held(solved, true, row, at, chance, squares))


@dataclass(frozen=True)
class TrueAxis:
    """Sensors of one axis, one a campaign."""

    offset_v: FloatArray
    k_v_per_g: FloatArray
    """(m, 3)"""
    q_v_per_g2: FloatArray
    """(m, 3, 3) without trace."""

    def volts(self, force: FloatArray) -> FloatArray:
        """(…, m) from (…, m, 3)."""
        bent = np.einsum("...mi,mij,...mj->...m", force, self.q_v_per_g2, force)
        return np.asarray(self.offset_v + np.einsum("...mi,mi->...m", force, self.k_v_per_g) + bent)


def true_axis(chance: np.random.Generator, count: int, index: int) -> TrueAxis:
    """Draw sensors with a soft mount."""
    k = 0.01 * V_PER_G * chance.standard_normal((count, 3))
    k[:, index] += V_PER_G
    half = SOFT_ARCSEC * ARCSEC * V_PER_G * chance.standard_normal((count, 3, 3)) / 2.0
    q = half + np.swapaxes(half, 1, 2)
    q -= np.eye(3) * (np.trace(q, axis1=1, axis2=2) / 3.0)[:, None, None]
    return TrueAxis(0.01 * chance.standard_normal(count), k, q)


def _stood(
    table: TableUncertainty, axis: str, shown_rad: FloatArray, count: int, chance: np.random.Generator
) -> FloatArray:
    """Return (K, m) angles where the table truly stood, as its certificate allows."""
    known = table.declared(axis).known
    if known is None:
        return np.asarray(shown_rad[:, None] + curves(shown_rad, count, chance, LIMIT_ARCSEC))
    weights = known.weights(shown_rad)
    listed = known.error_rad[:, None] - curves(known.angle_rad, count, chance, LIST_LIMIT_ARCSEC)
    is_between = weights.max(axis=1) < 1.0 - 1e-9
    teeth = is_between[:, None] * chance.uniform(-TEETH_ARCSEC, TEETH_ARCSEC, (shown_rad.size, count)) * ARCSEC
    return np.asarray(shown_rad[:, None] + weights @ listed + teeth)


def _outputs(
    run: Measured, pitch_rad: FloatArray, roll_rad: FloatArray, true: TrueAxis, chance: np.random.Generator
) -> FloatArray:
    """(N, m) volts."""
    count, n = pitch_rad.shape[1], run.plan.replications
    volt = ARCSEC * V_PER_G
    fixed = true.volts(force_at(pitch_rad, roll_rad))
    fixed += LACK_OF_FIT_ARCSEC * volt * chance.standard_normal(fixed.shape)
    middle = np.arange(n) - (n - 1) / 2.0
    drift = DRIFT_ARCSEC * volt * chance.standard_normal(count) * middle[:, None]
    reading_v = NOISE_V / sqrt((run.plan.dwell.nplc or READOUT_NPLC) / READOUT_NPLC)
    noise = reading_v / sqrt(run.plan.dwell.samples) * chance.standard_normal((n, *fixed.shape))
    return np.asarray((fixed + drift[:, None, :] + noise).reshape(-1, count))


def force_at(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return the (…, 3) specific force."""
    level = np.cos(pitch_rad)
    return np.stack([np.sin(pitch_rad), -level * np.sin(roll_rad), -level * np.cos(roll_rad)], axis=-1)


def _held(
    solved: dict[str, SolvedColumns],
    true: dict[str, TrueAxis],
    row: int,
    at: Attitude,
    chance: np.random.Generator,
    squares: list[float],
) -> tuple[float, float, float, float]:
    """Return whether the intervals of one campaign hold the truth; NaN for an angle that is not told."""
    reading_v = DWELL_ARCSEC * ARCSEC * V_PER_G
    known = [KnownAxis(columns.problem.models[row], columns.primary[row], reading_v) for columns in solved.values()]
    package = package_covariance(
        [
            SolvedAxis(axis, columns.problem.model.primary_names, columns.components, row)
            for axis, columns in solved.items()
        ]
    )
    angles = inferred(known, at)
    assert angles is not None
    half = angles.half_widths_rad(package.components)[0]
    force = force_at(at.pitch_rad, at.roll_rad)[:, None, :]
    off_v = []
    for axis, known_axis in known_by_axis(solved, known).items():
        mine = true[axis]
        alone = TrueAxis(mine.offset_v[[row]], mine.k_v_per_g[[row]], mine.q_v_per_g2[[row]])
        read = alone.volts(force)[0, 0] + reading_v * chance.standard_normal()
        off_v.append(read - float(known_axis.model.predict(known_axis.primary, at)[0]))
    off = angles.estimator[0] @ np.array(off_v)
    held = [
        float(abs(off[index]) <= half[index]) if angles.is_determined[0, index] else float("nan") for index in range(2)
    ]
    if angles.is_determined[0, 0]:
        squares.append((half[0] / ARCSEC) ** 2)
    return (*_parameters_held(solved, true, row), held[0], held[1])


def known_by_axis(solved: dict[str, SolvedColumns], known: list[KnownAxis]) -> dict[str, KnownAxis]:
    """Return the axes by name."""
    return dict(zip(solved, known, strict=True))


def _parameters_held(solved: dict[str, SolvedColumns], true: dict[str, TrueAxis], row: int) -> tuple[float, float]:
    """Shares over the axes: the offset without trace, and the sensitivities of the model as it is written."""
    offset, k = [], []
    for axis, columns in solved.items():
        model, mine = columns.problem.models[row], true[axis]
        best = np.linalg.lstsq(
            model.basis(columns.problem.block),
            TrueAxis(mine.offset_v[[row]], mine.k_v_per_g[[row]], mine.q_v_per_g2[[row]]).volts(
                force_at(columns.problem.block.pitch_rad, columns.problem.block.roll_rad)[:, None, :]
            )[:, 0],
            rcond=None,
        )[0]
        spread = np.sqrt(np.diag(columns.primary_covariance[row])) * t_quantile(0.95, columns.primary_dof[row])
        inside = np.abs(columns.primary[row] - best) <= spread
        offset.append(inside[0])
        k += inside[1:4].tolist()
    return float(np.mean(offset)), float(np.mean(k))
