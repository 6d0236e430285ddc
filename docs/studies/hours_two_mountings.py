"""The study's package on the study's table in several mountings, package and table solved together.

Every mounting but the first stands anew on its seat; the six replications are shared out. A certificate that states a
limit and no shape; table, level, seat, mount, drift, lack of fit and noise are drawn anew in each campaign.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from hours_coverage import TrueAxis, force_at, true_axis
from hours_laboratory import (
    ARCSEC,
    DRIFT_ARCSEC,
    DWELL_ARCSEC,
    LACK_OF_FIT_ARCSEC,
    LIMIT_ARCSEC,
    USAGE_PITCH_DEG,
    V_PER_G,
    curves,
)

from ams.analysis.angle_uncertainty import KnownAxis, UsageBox, angle_uncertainties, inferred
from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.extended import TERM_NAMES
from ams.observations import Observations
from ams.solve.joint import JointFit, joint_fit
from ams.solve.table_errors import REVERSED, UPRIGHT, Mounting, TablePriors
from ams.statistics.intervals import confidence_halfwidth

REPLICATIONS = 6
"""Of all mountings together."""
LEVEL_ARCSEC, SEAT_ARCSEC = 0.2, 10.0
TURNED_ABOUT_ROLL = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
REVERSED_TOO, ROLLED_TOO = (UPRIGHT, REVERSED), (UPRIGHT, TURNED_ABOUT_ROLL)
_PITCH_DEG, _ROLL_DEG = np.arange(-90.0, 91.0, 15.0), np.arange(-180.0, 181.0, 30.0)
_DECLARED = TablePriors(
    table=TableUncertainty(LIMIT_ARCSEC * ARCSEC, LIMIT_ARCSEC * ARCSEC, "limit"),
    pitch_zero_rad=LEVEL_ARCSEC * ARCSEC,
    base_tilt_rad=LEVEL_ARCSEC * ARCSEC,
    seat_rad=SEAT_ARCSEC * ARCSEC,
)
Turn = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Lowered:
    """U95 at use in arc seconds with what the calibration has of it, of pitch and of roll, and what intervals hold."""

    u95_arcsec: tuple[float, float]
    calibration: tuple[float, float]
    shares: tuple[float, float, float, float]
    """Offset, sensitivities, pitch at use, roll at use."""


def lowered(turns: Sequence[Turn], campaigns: int, chance: np.random.Generator) -> Lowered:
    """Return root mean squares and shares over campaigns, read at use by one dwell."""
    widths, held = [], []
    box = UsageBox((np.deg2rad(USAGE_PITCH_DEG[0]), np.deg2rad(USAGE_PITCH_DEG[1])))
    for _ in range(campaigns):
        true = {axis: true_axis(chance, 1, index) for index, axis in enumerate("xyz")}
        fit = joint_fit(_mountings(turns, true, chance), "xyz", _DECLARED)
        known = [
            KnownAxis(fit.sensors[axis].model, fit.primary[axis], DWELL_ARCSEC * ARCSEC * V_PER_G, TERM_NAMES)
            for axis in fit.axes
        ]
        angles = angle_uncertainties(known, fit.components, box)
        widths.append(
            [[angles[name].u95_rad / ARCSEC, angles[name].calibration_rad / ARCSEC] for name in ("pitch", "roll")]
        )
        held.append([*_parameters_held(fit, true, turns), *_angles_held(fit, known, true, chance)])
    (pitch, pitch_alone), (roll, roll_alone) = np.sqrt(np.mean(np.square(widths), axis=0)).tolist()
    offset, k, at_pitch, at_roll = np.nanmean(held, axis=0).tolist()
    return Lowered((pitch, roll), (pitch_alone / pitch, roll_alone / roll), (offset, k, at_pitch, at_roll))


def _mountings(turns: Sequence[Turn], true: dict[str, TrueAxis], chance: np.random.Generator) -> list[Mounting]:
    pitch, roll = (grid.ravel() for grid in np.meshgrid(np.deg2rad(_PITCH_DEG), np.deg2rad(_ROLL_DEG), indexing="ij"))
    zero, tilt = LEVEL_ARCSEC * ARCSEC * chance.standard_normal(2)
    stood = [angle + curves(angle, 1, chance, LIMIT_ARCSEC)[:, 0] for angle in (pitch, roll)]
    across = np.stack([np.zeros_like(roll), -np.cos(stood[1]), np.sin(stood[1])], axis=-1)
    force = force_at(stood[0] + zero, stood[1]) + tilt * across
    found: list[Mounting] = []
    each = REPLICATIONS // len(turns)
    for number, turn in enumerate(turns):
        seat = np.minimum(number, 1) * SEAT_ARCSEC * ARCSEC * chance.standard_normal(3)
        mounted = force @ np.array(turn).T
        mounted = mounted - np.cross(seat, mounted)
        rows = Observations(
            replication=each * number + np.repeat(np.arange(1, each + 1), pitch.size),
            point=np.tile(np.arange(pitch.size), each),
            pitch_rad=np.tile(pitch, each),
            roll_rad=np.tile(roll, each),
            outputs={axis: _output_v(sensor, mounted, each, chance) for axis, sensor in true.items()},
        )
        found.append(Mounting(rows, turn))
    return found


def _output_v(true: TrueAxis, force: FloatArray, replications: int, chance: np.random.Generator) -> FloatArray:
    volt = ARCSEC * V_PER_G
    fixed = true.volts(force[:, None, :])[:, 0] + LACK_OF_FIT_ARCSEC * volt * chance.standard_normal(len(force))
    moved = DRIFT_ARCSEC * volt * chance.standard_normal((replications, 1))
    noise = DWELL_ARCSEC * volt * chance.standard_normal((replications, len(force)))
    return np.asarray((fixed + moved + noise).ravel())


def _parameters_held(fit: JointFit, true: dict[str, TrueAxis], turns: Sequence[Turn]) -> tuple[float, float]:
    """Shares over the axes, of the linear sensor that comes closest over all mountings."""
    pitch, roll = (grid.ravel() for grid in np.meshgrid(np.deg2rad(_PITCH_DEG), np.deg2rad(_ROLL_DEG), indexing="ij"))
    force = np.concatenate([force_at(pitch, roll) @ np.array(turn).T for turn in turns])
    linear = np.column_stack([np.ones(len(force)), force])
    inside = []
    for axis, sensor in true.items():
        best = np.linalg.lstsq(linear, sensor.volts(force[:, None, :])[:, 0], rcond=None)[0]
        half = confidence_halfwidth(np.eye(fit.primary[axis].size)[:4], fit.axis_components(axis))
        inside.append(np.abs(fit.primary[axis][:4] - best) <= half)
    return float(np.mean([held[0] for held in inside])), float(np.mean([held[1:] for held in inside]))


def _angles_held(
    fit: JointFit, known: Sequence[KnownAxis], true: dict[str, TrueAxis], chance: np.random.Generator
) -> list[float]:
    at = Attitude(np.deg2rad(chance.uniform(*USAGE_PITCH_DEG, 1)), chance.uniform(-np.pi, np.pi, 1))
    angles = inferred(known, at)
    assert angles is not None
    force = force_at(at.pitch_rad, at.roll_rad)[:, None, :]
    scatter = DWELL_ARCSEC * ARCSEC * V_PER_G
    off_v = [
        float(true[name].volts(force)[0, 0] - axis.model.predict(axis.primary, at)[0])
        + scatter * chance.standard_normal()
        for name, axis in zip(fit.axes, known, strict=True)
    ]
    off, half = angles.estimator[0] @ np.array(off_v), angles.half_widths_rad(fit.components)[0]
    return [
        float(abs(off[index]) <= half[index]) if angles.is_determined[0, index] else float("nan") for index in range(2)
    ]
