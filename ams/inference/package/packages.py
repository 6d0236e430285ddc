"""Pitch, yaw and roll from CR's sting package, alone or with its model package, reading by reading with their spread.

The unknowns are the direction of gravity in sting axes and the roll of the model: as a unit vector and an angle they
are regular wherever the packages resolve them, so one weighted Gauss-Newton serves everywhere. The angles and their
standard deviations are read off afterwards, and only there do their own singular attitudes matter: at Θ = 0 yaw is
lost, at Ψ = ±90° the sign of Θ, with the sting's x axis vertical the roll. Source: CR (IV-B.1) to (IV-B.28).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.attitude.flag_codes import Codes
from ams.attitude.redundancy import disagreement, explaining
from ams.attitude.spread import (
    PackageErrors,
    PredictionErrors,
    Spread,
    UncertainSensor,
    beside_singular,
    output_errors,
    side_by_side,
)
from ams.attitude.static import CLEARANCE_SD, LARGEST_SD_RAD, SMALLEST_SLOPE, Sensor
from ams.attitude.truncated_pivot import along_distance, factor_across, factor_along
from ams.attitude.two_package import angles_from_gravity
from ams.frames import wrap_rad
from ams.inference.package.package_fit import Fitted, PackageAxes, resolved, stacked, weights_of


@dataclass(frozen=True)
class SpreadAngles:
    """Angles with their standard deviations, (N,) each, NaN where the flag says why."""

    pitch_rad: FloatArray
    pitch_sd_rad: FloatArray
    yaw_rad: FloatArray
    yaw_sd_rad: FloatArray
    roll_rad: FloatArray
    roll_sd_rad: FloatArray
    codes: Codes
    pitch_half_95_rad: FloatArray
    """Half-width of the 95 % interval, with Student's factor for what the calibrations rest on."""
    yaw_half_95_rad: FloatArray
    roll_half_95_rad: FloatArray
    reasons: Mapping[int, str] = field(default_factory=lambda: flag_codes.WORDS)
    """What the codes mean."""


def angles_from_sting(
    sensors: Sequence[Sensor], outputs_v: FloatArray, package: PackageErrors | None = None
) -> SpreadAngles:
    """Find pitch and yaw from three sting outputs, (N, 3).

    Roll does not reach the sting and is NaN, not flagged.

    The sensors are lines in the specific force, minus gravity. Raises: DesignError where they lie in one plane.
    """
    k, volts = stacked(sensors, outputs_v)
    axes = PackageAxes(k)
    weights = weights_of(sensors, k, resolved(k, volts))
    fit = axes.fit(volts, weights)
    errors = output_errors(sensors, -fit.gravity, package)
    columns = axes.columns(fit, slopes_of(fit.gravity))
    found = _read_off(fit.gravity, fit.roll_rad, _spread(columns, weights, errors))
    return replace(found, codes=found.codes | _disagreement(fit.residual_v, columns, errors))


def angles_from_packages(
    sting: Sequence[Sensor],
    model: Sequence[Sensor],
    sting_v: FloatArray,
    model_v: FloatArray,
    packages: tuple[PackageErrors | None, PackageErrors | None] = (None, None),
    *,
    gravity_relative_u: float = 0.0,
) -> SpreadAngles:
    """Find all three angles from three sting and three model outputs, (N, 3) each, all six weighted together.

    ``gravity_relative_u``: standard uncertainty, over gravity, of what both packages take for it in common, which is
    in the errors of neither.

    Raises: DesignError where the sensors of a package lie in one plane.
    """
    k_s, volts_s = stacked(sting, sting_v)
    k_m, volts_m = stacked(model, model_v)
    axes = PackageAxes(k_s, k_m)
    weights = np.concatenate(
        [weights_of(sting, k_s, resolved(k_s, volts_s)), weights_of(model, k_m, resolved(k_m, volts_m))], axis=1
    )
    fit = axes.fit(np.concatenate([volts_s, volts_m], axis=1), weights)
    errors = errors_of_two(axes, fit, (sting, model), packages, gravity_relative_u)
    columns = axes.columns(fit, slopes_of(fit.gravity))
    found = _read_off(fit.gravity, fit.roll_rad, _spread(columns, weights, errors))
    return replace(found, codes=found.codes | _disagreement(fit.residual_v, columns, errors))


def errors_of_two(
    axes: PackageAxes,
    at: Fitted,
    sensors: tuple[Sequence[UncertainSensor], Sequence[UncertainSensor]],
    packages: tuple[PackageErrors | None, PackageErrors | None],
    gravity_relative_u: float,
) -> PredictionErrors:
    """Return the errors of the six outputs of two packages at an attitude; see :func:`angles_from_packages`."""
    apart = side_by_side(
        output_errors(sensors[0], -at.gravity, packages[0]), output_errors(sensors[1], -at.in_model, packages[1])
    )
    if not gravity_relative_u:
        return apart
    by_gravity = gravity_relative_u * axes.predicted_v(at)
    common = np.einsum("ni,nj->nij", by_gravity, by_gravity)
    return replace(apart, calibration=[*apart.calibration, (common, np.inf)])


def _disagreement(residual: FloatArray, columns: FloatArray, errors: PredictionErrors) -> Codes:
    """Return the codes of rows of (n, R) residuals that no attitude explains, with the readings that may be wrong.

    Of one package no reading can be named: without any one of them nothing is left to test.
    """
    parts = np.stack([covariance for covariance, _ in errors.calibration])
    reading = errors.reading[..., None] * np.eye(residual.shape[1])
    covariance = parts.sum(axis=0) + reading
    # Welch and Satterthwaite's degrees of freedom along what is left, in the direction in which it is tested.
    tested = np.linalg.solve(covariance, residual[..., None])[..., 0]
    variances = np.einsum("ni,cnij,nj->cn", tested, parts, tested)
    total = np.einsum("ni,nij,nj->n", tested, covariance, tested)
    shares = variances / np.where(total > 0.0, total, 1.0)
    dofs = np.stack([np.broadcast_to(np.asarray(dof, dtype=float), total.shape) for _, dof in errors.calibration])
    with np.errstate(divide="ignore"):
        dof = 1.0 / np.sum(shares**2 / dofs, axis=0)
    is_valid = np.ones(residual.shape, dtype=bool)
    rows = np.flatnonzero(disagreement(residual, columns, covariance, is_valid).is_above(dof))
    codes = np.zeros(len(residual), dtype=np.uint32)
    codes[rows] = flag_codes.REDUNDANCY
    if residual.shape[1] < 6 or not rows.size:
        return codes
    may_be_wrong = explaining(residual[rows], columns[rows], covariance[rows], is_valid[rows], dof[rows])
    codes[rows] |= np.uint32(flag_codes.TWO_PACKAGES)
    for reading_index, bit in enumerate((*flag_codes.SUSPECTS, *flag_codes.MODEL_SUSPECTS)):
        codes[rows[may_be_wrong[:, reading_index]]] |= np.uint32(bit)
    return codes


def slopes_of(gravity: FloatArray) -> FloatArray:
    """Return (N, 3, 2) ∂G/∂Θ and ∂G/∂(sin Θ Ψ), sting axes: unit vectors across G, regular everywhere."""
    sine = np.hypot(gravity[:, 0], gravity[:, 1])
    sign = np.where(gravity[:, 0] > 0.0, -1.0, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        c_yaw = np.where(sine > 0.0, -sign * gravity[:, 0] / sine, 1.0)
        s_yaw = np.where(sine > 0.0, sign * gravity[:, 1] / sine, 0.0)
    c_pitch, s_pitch = gravity[:, 2], sign * sine
    by_pitch = np.stack([-c_pitch * c_yaw, c_pitch * s_yaw, -s_pitch], axis=-1)
    return np.stack([by_pitch, np.stack([s_yaw, c_yaw, np.zeros_like(s_yaw)], axis=-1)], axis=-1)


def _spread(columns: FloatArray, weights: FloatArray, errors: PredictionErrors) -> Spread:
    """Return the spread of two turns of gravity and, with a model package, of roll, (N, s).

    Where the outputs do not tell a direction, all is put on the last.
    """
    weighted = np.swapaxes(columns, -1, -2) * weights[:, None, :]
    normal = weighted @ columns
    values = np.linalg.eigvalsh(normal)
    lost = (values[:, 0] < SMALLEST_SLOPE**2 * values[:, -1])[:, None]
    solvable = np.where(lost[..., None], np.eye(normal.shape[-1]), normal)
    spread = errors.of_angles(np.asarray(np.linalg.solve(solvable, weighted), dtype=np.float64))
    nothing = np.where(np.arange(normal.shape[-1]) == normal.shape[-1] - 1, np.inf, 0.0)
    sd, half_95 = (np.where(lost, nothing, values) for values in (spread.sd, spread.half_95))
    return Spread(sd, half_95, spread.covariance)


def _read_off(gravity: FloatArray, roll: FloatArray, spread: Spread) -> SpreadAngles:
    found = angles_from_gravity(gravity, gravity)
    sd, half = spread.sd, spread.half_95
    sine = np.hypot(gravity[:, 0], gravity[:, 1])
    with np.errstate(divide="ignore"):
        yaw_sd, yaw_half = sd[:, 1] / sine, half[:, 1] / sine
    level = ~(yaw_sd <= LARGEST_SD_RAD)
    sideways = ~level & ~(np.abs(gravity[:, 0]) > np.maximum(CLEARANCE_SD * sd[:, :2].max(axis=1), SMALLEST_SLOPE))
    has_roll = sd.shape[-1] == 3
    roll_sd, roll_half = (sd[:, 2], half[:, 2]) if has_roll else np.full((2, roll.size), np.nan)
    on_end = ~(roll_sd <= LARGEST_SD_RAD) if has_roll else np.zeros(roll.size, dtype=bool)
    codes = np.zeros(roll.size, dtype=np.uint32)
    for is_so, code in (
        (level, flag_codes.YAW_LEVEL),
        (sideways, flag_codes.SIDEWAYS),
        (on_end, flag_codes.ROLL_ON_END),
    ):
        codes[is_so] |= np.uint32(code)
    pitch_sd, size_half = (beside_singular(pair[:, 0], pair[:, 1], level) for pair in (sd, half))
    pitch_half = _half_with_sign(gravity, size_half, level)
    factors = np.where((codes != 0)[:, None], 1.0, _factors_of_read(gravity, spread))
    pitch_half, yaw_half = factors[:, 0] * pitch_half, factors[:, 1] * yaw_half
    roll_half = factors[:, 2] * roll_half if has_roll else roll_half
    wrapped = wrap_rad(roll)
    return SpreadAngles(
        np.where(sideways, np.nan, _pitch(gravity, found.pitch_rad)),
        np.where(sideways, np.nan, pitch_sd),
        np.where(level | sideways, np.nan, found.yaw_rad),
        np.where(level | sideways, np.nan, yaw_sd),
        np.where(on_end, np.nan, wrapped),
        np.where(on_end, np.nan, roll_sd),
        codes,
        np.where(sideways, np.nan, pitch_half),
        np.where(level | sideways, np.nan, yaw_half),
        np.where(on_end, np.nan, roll_half),
    )


def _factors_of_read(gravity: FloatArray, spread: Spread) -> FloatArray:
    """Return what to widen the (N, s) half-widths by next to the bounds beyond which angles are told.

    Towards Θ = 0 pitch is the distance and yaw the angle about it; towards Ψ = ±90° the distance is that of g_x from
    zero; towards a vertical sting g_x is what is left of it, and roll the angle about it.
    """
    sd, covariance, count = spread.sd, spread.covariance, spread.sd.shape[-1]
    sine, by_g_x = np.hypot(gravity[:, 0], gravity[:, 1]), np.zeros(spread.sd.shape)
    by_g_x[:, :2] = slopes_of(gravity)[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        level_sd, share = along_distance(covariance, np.eye(1, count).repeat(len(sd), axis=0))
        from_level = (sine - sd[:, 1] / LARGEST_SD_RAD) / level_sd
        factors = factor_along(from_level[:, None], share)
        factors[:, 1] = np.fmax(factors[:, 1], factor_across(sine / level_sd, from_level))
        aside_sd, share = along_distance(covariance, by_g_x)
        from_aside = (np.abs(gravity[:, 0]) - CLEARANCE_SD * sd[:, :2].max(axis=1)) / aside_sd
        factors = np.fmax(factors, factor_along(from_aside[:, None], share))
        if count == 3:
            from_end = 1.0 / sd[:, 2]
            beyond = from_end - 1.0 / LARGEST_SD_RAD
            factors = np.fmax(factors, factor_along(beyond[:, None], share))
            factors[:, 2] = np.fmax(factors[:, 2], factor_across(from_end, beyond))
    return factors


def _half_with_sign(gravity: FloatArray, size_half: FloatArray, is_level: BoolArray) -> FloatArray:
    """Return the half-width of pitch near zero, where its sign may be the other one.

    Gravity across the sting lies in a circle of radius ``size_half`` about (g_x, g_y). Where that circle reaches over
    g_x = 0 the sign of pitch is not known, and the far end of the chord is what pitch may be beyond zero.
    """
    g_x, g_y = np.abs(gravity[:, 0]), np.abs(gravity[:, 1])
    reaches_over = is_level & (g_x < size_half)
    chord = np.sqrt(np.where(reaches_over, size_half**2 - g_x**2, 0.0))
    return np.where(reaches_over, np.hypot(g_x, g_y) + g_y + chord, size_half)


def _pitch(gravity: FloatArray, pitch_rad: FloatArray) -> FloatArray:
    """Return the pitch of gravity.

    Where gravity lies across the sting its own sign is flagged elsewhere; the size is always known.
    """
    size = np.arctan2(np.hypot(gravity[:, 0], gravity[:, 1]), gravity[:, 2])
    return np.where(np.isnan(pitch_rad), size, pitch_rad)
