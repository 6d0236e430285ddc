"""Errors that every reading of a calibration shares, as the laboratory's certificates state them (type B).

The meter's zero and gain, the level of the base, the thermometer: one error of each, the same in every row, so that no
number of replications makes it smaller. Each is a column of U_Y, one standard uncertainty at the solution of a sensor
axis, beside the table's indices, and enters every uncertainty that is reported. Source: TP 10; GUM 4.3, F.1.2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import ObservationsError
from ams.frames import beside_axis
from ams.models.gyro import mean_from_level
from ams.models.model import Model, Stimulus
from ams.models.registry import MODELS
from ams.models.thermal import SECOND_ORDER_NAMES, TEMPERATURE_NAMES
from ams.statistics.budget import Kind

Effect = Literal[
    "reading", "gain", "rate", "pitch", "base-tilt", "temperature", "level", "field", "rotation",
    "reading-course", "gain-course", "departure", "specific-force", "squareness", "droop", "spin-direction",
    "seat", "crosstalk", "gravity-direction",
]  # fmt: skip
"""``reading``: volts on every reading; ``gain``: relative, on every output; ``rate``: relative, on every rate of
the table; ``pitch``: radians, the zero of pitch with
the tilt of the base about that axis; ``base-tilt``: radians, of the base across it; ``squareness``: radians, of the
roll axis to the pitch axis; ``droop``: radians of pitch lost at the horizontal; ``temperature``: °C;
``level``: of the known levels of a straight line, in the columns that the observations state;
``field``: the same of a field that is known as a vector, where rows across an axis scatter by it;
``rotation``: °/s along the level axes that ``columns`` names (0 to 2), seen by a gyro as the rows stood or turned;
``reading-course``, ``gain-course``: a reading or a gain that changes by it while the rows are taken, in their order of
time (:mod:`ams.solve.shifts_within`);
``departure``: volts by which an output leaves its model at any attitude, unlike at attitudes that lie apart;
``specific-force``: °/s per g along every package axis, by which the zero of a gyro follows the force on it;
``spin-direction``: radians to either side of the axis of the table that ``columns`` names (0 pitch, 1 yaw, 2 roll),
about which a gyro turns; ``seat``: the same, by an error of its own at each position;
``crosstalk``: the part of the volts of another channel that a reading has too much, of each of ``columns`` its own;
``gravity-direction``: of the direction of gravity that another package told, in the columns that the observations
state."""

LEVELS: tuple[Effect, ...] = ("level", "field")
OF_THE_BASE: tuple[Effect, ...] = ("pitch", "base-tilt")
OF_THE_AXES: tuple[Effect, ...] = ("squareness", "droop")
"""Of a table as a whole, and no turn of the package: they are named as their effects."""
OF_THE_SPIN: tuple[Effect, ...] = ("spin-direction", "seat")
COURSES: tuple[Effect, ...] = ("reading-course", "gain-course")
SHIFTS = ("shift until the next calibration, offset", "shift until the next calibration, sensitivity")
"""Names of what a sensor may do after its calibration: parts of the covariance that no run draws anew."""
SHIFTS_WITHIN = ("shift within the calibration, offset", "shift within the calibration, sensitivity")
"""Names of what it may do while it is calibrated."""
NONLINEARITY = "nonlinearity beyond the equation"
"""Name of what of an output follows the attitude and is no term of a set: the next run repeats it."""
STING_CALIBRATION = "calibration of the sting package"
"""Name of what the set of a sting package, against which a model package was calibrated, leaves uncertain."""
BETWEEN_RATES = "between the rates"
"""Name of what a gyro may do between three rates: the next run at the same rates repeats it."""
G_SENSITIVITY = "g-sensitivity"
"""Name of what the specific force does to the zero of a gyro: the same run repeats it, use elsewhere does not."""
G_SENSITIVITY_LIMIT = "largest_g_sensitivity_dps_per_g"
"""Its limit, among the notes of a solved axis."""
SHOWN_BY_ROWS = "shown by the calibration's own rows"
"""Who states an error that nobody declared."""
COUNTED_AS_SHOWN = "counted_as_shown"
"""The note of a solved axis: errors that its rows showed and its covariance holds, by name, as the budget has them."""
_STANDS = 1e-3
"""Of the largest rate: an axis that is slower stands still."""
_MOST_POSITIONS = 24
"""In which a package is seated while it turns; of more, angles that change all the time are no seats."""
HALF = float(np.sqrt(0.5))
"""Of a departure: the standard deviation that offset and sensitivities carry, each half of the variance."""


@dataclass(frozen=True)
class SharedError:
    """One error, common to all rows of a sensor axis."""

    name: str
    """In words, such as ``multimeter zero``; names a part of the covariance."""
    effect: Effect
    standard_uncertainty: float
    """In the unit of the effect."""
    kind: Kind = "standard"
    """Distribution, for the Monte Carlo check."""
    stated: str = ""
    """Where it comes from and as what, such as ``standards.meter: limit 20 µV``."""
    columns: tuple[int, ...] = ()
    """Of the observations' ``level_errors``, for the effect ``level``; of the level axes for ``rotation``; of the axes
    of the table for ``spin-direction``; of the observations' ``scanned_v`` for ``crosstalk``."""
    axes: tuple[str, ...] = ()
    """Of ``crosstalk``: the sensor axis whose channel each of ``columns`` is, empty of others'; none leaks into itself,
    so that all axes behind one scanner have one and the same error and are solved together."""
    is_of_one_channel: bool = False
    """A load resistor: other sensor axes have one of their own, as good and as wrong."""
    degrees_of_freedom: float = np.inf
    """That the standard uncertainty was estimated with; of a certificate or a limit infinite."""
    is_weighed: bool = True
    """Whether the estimate weighs the rows by it; what the same data showed is added to the covariance alone."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.standard_uncertainty) and self.standard_uncertainty >= 0.0):
            raise ObservationsError(
                f"{self.name}: standard uncertainty: got {self.standard_uncertainty!r}, allowed 0 or more; nothing was "
                "solved; correct the rig file"
            )

    @property
    def limit(self) -> float:
        """Half width of the rectangular distribution that has its standard uncertainty, in the unit of the effect."""
        return float(np.sqrt(3.0)) * self.standard_uncertainty


def notes_of(errors: Sequence[SharedError]) -> Mapping[str, object]:
    """Return limits that users of a set must know beside the covariance, and what a budget says of what is in it."""
    limit = next((error.limit for error in errors if error.name == G_SENSITIVITY), None)
    shown = {
        error.name: {"distribution": error.kind, "stated": error.stated} for error in errors if not error.is_weighed
    }
    notes: dict[str, object] = {COUNTED_AS_SHOWN: shown} if shown else {}
    return notes if limit is None else {**notes, G_SENSITIVITY_LIMIT: limit}


def shared_columns(
    errors: Sequence[SharedError], model: Model, primary: FloatArray, rows: Stimulus
) -> Mapping[str, FloatArray]:
    """Return (N, q) columns by name, volts; an error that does not reach the model (a level for a gyro) has none."""
    effects = {error.name: _columns(error, model, primary, rows) for error in errors}
    return {
        error.name: error.standard_uncertainty * effect
        for error in errors
        if (effect := effects[error.name]) is not None and effect.any() and error.standard_uncertainty > 0.0
    }


def _columns(error: SharedError, model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    if error.effect in LEVELS:
        slope = _slope_of(model)
        if rows.level_errors is None or slope is None:
            return None
        return np.asarray(primary[slope] * rows.level_errors[:, list(error.columns)])
    if error.effect in COURSES:
        return None
    if error.effect == "crosstalk":
        return leaking_v(error, model.nominal_axis, rows)
    if error.effect == "departure":
        return _departing(model, rows)
    if error.effect == "gravity-direction":
        return _of_turned_gravity(model, primary, rows)
    if error.effect == "rotation":
        return _rotated(error.columns, model, primary, rows)
    if error.effect == "specific-force":
        return _forced(model, primary, rows)
    if error.effect in OF_THE_SPIN:
        return _leaning(error, model, primary, rows)
    effect = _effect(error.effect, model, primary, rows)
    return None if effect is None else effect[:, None]


def leaking_v(error: SharedError, axis: str, rows: Stimulus) -> FloatArray:
    """Return (N, q) volts of a scanner's channels, which leak into that of an axis each by a part of its own.

    Of the channel of the axis itself they are zero.

    Raises: ObservationsError where nobody knows them: what leaks would silently be left out.
    """
    if rows.scanned_v is None:
        raise ObservationsError(
            f"{error.name}: {error.stated} is declared, and the rows do not state the volts of the other channels; "
            "nothing was solved; give them as scanned_v of the observations, or leave the error out"
        )
    is_another = np.array([of_axis != axis for of_axis in error.axes])
    return np.asarray(rows.scanned_v[:, list(error.columns)] * is_another)


def carriers(model: Model) -> list[int]:
    """Return the places of the primary parameters that carry a departure; none where what is sensed has no bound."""
    sensed = [name for name in model.primary_names if name.startswith("k_") and name.endswith("_v_per_g")]
    is_bounded = bool(sensed) and "offset_v" in model.primary_names
    return [model.primary_names.index(name) for name in ("offset_v", *sensed)] if is_bounded else []


def _departing(model: Model, rows: Stimulus) -> FloatArray:
    """Return (N, q) what a departure of one volt does to an output: of the same variance at every attitude.

    It is no term of a set. Offset and sensitivities carry it: with gravity's unit vectors a and a′ the departures at
    two attitudes correlate by ½ (1 + a·a′), whole at the same, not at all at opposite ones. Where no attitude is known,
    or what is sensed has no bound, it is one of all readings.
    """
    carried = carriers(model)
    if not carried or rows.reference_level is not None:
        return np.ones((rows.pitch_rad.size, 1))
    return np.asarray(HALF * model.jacobian(np.zeros(len(model.primary_names)), rows)[:, carried])


def _of_turned_gravity(model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return (N, q) what gravity adds to an output where its direction is another; None where nothing senses it."""
    named = dict(zip(model.primary_names, primary, strict=True))
    k = np.array([named.get(f"k_{axis}_v_per_g", 0.0) for axis in "xyz"])
    if rows.gravity_errors_rad is None or not k.any():
        return None
    return np.asarray(np.einsum("i,niq->nq", k, rows.gravity_errors_rad))


def _rotated(columns: Sequence[int], model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return (N, q) what one °/s along each of some level axes makes; None but for gyros."""
    named = dict(zip(model.primary_names, primary, strict=True))
    k = np.array([named.get(f"k_{axis}_v_per_dps", 0.0) for axis in "xyz"])
    if not k.any() or (rows.from_level is None and rows.euler_rate_rad_s is None):
        return None
    return np.asarray(np.einsum("i,nij->nj", k, mean_from_level(rows)[:, :, list(columns)]))


def _leaning(error: SharedError, model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return (N, q) what one radian to either side of some axes of the table makes; None but for gyros at rates.

    Every axis leans in what carries it, and roll in the package: by their squareness, the same at every position. Where
    there are several, the package is seated anew at each, by an error of its own.
    """
    named = dict(zip(model.primary_names, primary, strict=True))
    k = np.array([named.get(f"k_{axis}_v_per_dps", 0.0) for axis in "xyz"])
    if rows.euler_rate_rad_s is None or not k.any():
        return None
    yaw = np.zeros_like(rows.roll_rad) if rows.yaw_rad is None else rows.yaw_rad
    euler = np.stack(np.broadcast_arrays(rows.pitch_rad, yaw, rows.roll_rad), axis=-1)
    rates_dps = np.rad2deg(rows.euler_rate_rad_s)
    if error.effect == "seat" and (np.count_nonzero(_turns(rates_dps), axis=1) > 1).any():
        return None  # in a motion of several axes at once there are no positions
    found = []
    for axis in error.columns:
        leaning = rates_dps[:, axis, None] * (beside_axis(euler, axis) @ k)
        seats = [leaning * here[:, None] for here in _positions(euler, rates_dps, axis).T]
        is_seated_anew = 1 < len(seats) <= _MOST_POSITIONS
        if error.effect == "spin-direction":
            found += [leaning, *(seats if is_seated_anew else [])]
        elif seats:
            found += seats if is_seated_anew else [leaning]
    return np.asarray(np.concatenate(found, axis=1)) if found else None


def _positions(euler: FloatArray, rates_dps: FloatArray, axis: int) -> BoolArray:
    """Return (N, p) which rows are of each position in which an axis turned: of the angles that it carries, to 1°."""
    is_turned = _turns(rates_dps)[:, axis]
    turned = np.flatnonzero(is_turned)
    carried = np.rint(np.rad2deg(euler[:, axis + 1 :])) % 360.0
    at = np.full(is_turned.size, -1)
    for index, row in enumerate(np.unique(carried[turned], axis=0)):
        at[np.all(carried == row, axis=1)] = index
    at[~is_turned] = -1
    return np.asarray(at[:, None] == np.arange(at.max() + 1))


def _turns(rates_dps: FloatArray) -> BoolArray:
    """Return (N, 3) which axes turn in which rows."""
    speed = np.abs(rates_dps)
    return np.asarray(speed > _STANDS * speed.max())


def _senses_rates(model: Model) -> list[int]:
    """Return the places of the sensitivities of a gyro; none for other sensors."""
    return [
        index for index, name in enumerate(model.primary_names) if name.startswith("k_") and name.endswith("_per_dps")
    ]


def _forced(model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return (N, q) what a sensitivity of one °/s per g along each package axis makes; None but for gyros.

    The offset is the zero at the mean specific force of the calibration. What the force differs by from row to row is a
    column for each package axis. Where the gyro will be used the force lies anywhere: the farthest is one g against
    that mean, and a column of all readings has it. Where no attitude is known both are taken as those of one attitude.
    """
    sensed = _senses_rates(model)
    if not sensed:
        return None
    volts_per_dps = float(np.linalg.norm(primary[sensed]))
    if rows.from_level is None:
        return np.full((rows.pitch_rad.size, 1), 2.0 * volts_per_dps)
    force_g = -rows.from_level[:, :, 2]
    mean_g = force_g.mean(axis=0)
    in_use = np.full((force_g.shape[0], 1), 1.0 + np.linalg.norm(mean_g))
    return np.asarray(volts_per_dps * np.concatenate([in_use, force_g - mean_g], axis=1))


def _slope_of(model: Model) -> int | None:
    """Return the place of k along the nominal axis in a model of known levels; None for every other model."""
    if not model.primary_names[0].startswith("zero_level_"):
        return None
    return next(index for index, name in enumerate(model.primary_names) if name.startswith(f"k_{model.nominal_axis}_"))


def _effect(effect: Effect, model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return the (N,) volts that one unit of the error makes."""
    if effect == "reading":
        return np.ones_like(rows.pitch_rad)
    if effect == "gain":
        return model.predict(primary, rows)
    if effect == "rate":
        return _turned_faster(model, primary, rows)
    if effect == "pitch":
        return model.angle_jacobian(primary, rows).get("pitch")
    if effect == "droop":
        by_pitch = model.angle_jacobian(primary, rows).get("pitch")
        return None if by_pitch is None else -np.cos(rows.pitch_rad) * by_pitch
    if effect in ("base-tilt", "squareness"):
        across = _tilted(model, primary, rows)
        return across if across is None or effect == "base-tilt" else -np.sin(rows.pitch_rad) * across
    return _warmed(model, primary, rows)


def _turned_faster(model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return what rates that are too high, all by the same part, add to the output of a gyro."""
    named = dict(zip(model.primary_names, primary, strict=True))
    if not any(name.endswith("_v_per_dps") for name in named):
        return None
    return np.asarray(model.predict(primary, rows) - named["offset_v"])


def _tilted(model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return what a tilt across the pitch axis adds to the output per radian; None without sensitivities.

    The tilt brings gravity along it: (sin ψ, cos ψ cos R, −cos ψ sin R) in package axes.
    """
    named = dict(zip(model.primary_names, primary, strict=True))
    k = [named.get(f"k_{axis}_v_per_g", 0.0) for axis in "xyz"]
    if not any(k):
        return None
    yaw = np.zeros_like(rows.pitch_rad) if rows.yaw_rad is None else rows.yaw_rad
    registered = MODELS.get(model.name)
    is_reached = registered is None or not registered.is_of_sting
    roll = rows.roll_rad if is_reached else np.zeros_like(rows.roll_rad)
    return np.asarray(k[0] * np.sin(yaw) + np.cos(yaw) * (k[1] * np.cos(roll) - k[2] * np.sin(roll)))


def _warmed(model: Model, primary: FloatArray, rows: Stimulus) -> FloatArray | None:
    """Return the effect of a thermometer that is wrong by one °C; None where the model has no temperature terms."""
    named = dict(zip(model.primary_names, primary, strict=True))
    if TEMPERATURE_NAMES[0] not in named:
        return None
    offset_tc, sensitivity_tc = (named[name] for name in TEMPERATURE_NAMES)
    if rows.temperature_degc is not None and SECOND_ORDER_NAMES[0] in named:
        reference = model.parameters(primary)[model.parameter_names.index("reference_temperature_degc")]
        rise = rows.temperature_degc - reference
        offset_tc, sensitivity_tc = (
            first + 2.0 * named[second] * rise
            for first, second in zip((offset_tc, sensitivity_tc), SECOND_ORDER_NAMES, strict=True)
        )
    return np.asarray(offset_tc + sensitivity_tc * (model.predict(primary, rows) - named["offset_v"]))
