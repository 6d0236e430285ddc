"""Known levels for straight lines: what the nominal axis of a sensor was exposed to, dwell by dwell, and how well.

Specific force follows from the attitude, angular velocity from the rates that were measured, a field from the coil. An
attitude that is wrong by θ changes the level by its slope times θ and, where the axis lies along gravity or field and
there is no slope, by θ²/2 of the level: always to the same side, so it is common to all dwells. A coil whose field is
wrong by u_B at its largest field B is wrong in scale: every level by u_B/B of it. One that points beside its direction,
and surroundings that are not quite as declared, add a field across or along that turns with the attitude.
Source: SR 4.1; GUM 5.1.2, F.2.4.4.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.frames import ANGLES, body_rates_rad_s
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty, index_columns
from ams.models.linear import magnet_difference
from ams.observations import Observations
from procedures.description.kind_tables import Levels
from procedures.plan.plan import Plan
from procedures.plan.rotations import UP, body_axis, to_stage
from procedures.records.dwells import DwellRecord
from procedures.solution.request import SensorRows
from procedures.solution.type_b import shared_errors, table_in_words, table_uncertainty
from rig.description.rig_file import RigDescription

LEAST_ALONG = 0.5
"""SR's two positions: rows where an axis is less along gravity or a coil say nothing about it."""
STEP_RAD = 1e-4
"""Of the differences that tell how a level changes with an attitude; smooth functions of size one, so 1e-8 is kept."""
BASE_ABOUT_PITCH, BASE_ACROSS = "base about pitch", "base across"
TURNED = (*ANGLES, BASE_ABOUT_PITCH, BASE_ACROSS)
"""What may be turned by a little: the angles that the axes stand at, and the base."""
OF_BASE = {"pitch": BASE_ABOUT_PITCH, "base-tilt": BASE_ACROSS}
"""Effect of a level's error to the base's turn."""

LevelOf = Callable[[int, Mapping[str, float]], float]
"""Row and how far each place is turned beyond what is known (radians) to the level."""


@dataclass(frozen=True)
class LevelError:
    """One source of error of the known levels."""

    error: SharedError
    columns: FloatArray
    """(N, q) what one standard uncertainty of each of its independent parts does to every level, in its unit."""


@dataclass(frozen=True)
class LevelRows:
    """One axis: which rows tell it something, its known levels there and its readings."""

    rows: IntArray
    level: FloatArray
    reading: FloatArray
    sense: FloatArray | None = None
    """±1: along or against a coil beside which an unknown field stands."""
    errors: tuple[LevelError, ...] = field(default=())

    def kept(self, indices: IntArray) -> "LevelRows":
        """Return the rows at these places only."""
        return replace(
            self,
            rows=self.rows[indices],
            level=self.level[indices],
            reading=self.reading[indices],
            sense=None if self.sense is None else self.sense[indices],
            errors=tuple(replace(error, columns=error.columns[indices]) for error in self.errors),
        )


def levels_of(plan: Plan) -> Levels | None:
    """Return the table ``[levels]`` that a run was planned by; None for a run of another kind."""
    return plan.kind_table("levels", Levels)


def known_levels(item: SensorRows, observations: Observations, axis: str) -> LevelRows:
    """Return what the nominal axis of a sensor was exposed to: specific force (g), rate (dps), field (uT)."""
    reading, levels = observations.outputs[axis], levels_of(item.plan)
    if levels is not None and levels.method == "magnet-difference":
        return _magnet_levels(item.dwells, reading)
    is_beside_the_unknown = levels is not None and levels.surroundings_ut is None
    along = body_axis(item.sensor, axis)
    known = None if levels is None else levels.surroundings_ut
    level_of = _level_of(item, observations, along, np.zeros(3) if known is None else np.array(known))
    level = np.array([level_of(row, {}) for row in range(len(item.dwells))])
    sense = None
    if is_beside_the_unknown:
        turned = _turned(observations, along)
        sense = np.array([turned(row, {}, _coil(row, item)) for row in range(level.size)])
    errors = tuple(_errors(item, observations, axis, along, level_of, level))
    found = LevelRows(np.arange(level.size), level, reading, sense, errors)
    if sense is not None:
        return found.kept(np.flatnonzero(np.abs(sense) > LEAST_ALONG))
    if item.sensor.measures == "acceleration":
        return found.kept(np.flatnonzero(np.abs(level) > LEAST_ALONG))
    return found


def errors_of_field(
    item: SensorRows, observations: Observations, axis: str, along: FloatArray, beside_ut: FloatArray
) -> tuple[LevelError, ...]:
    """Return what the rig file declares, for a sensor that lies along a vector in stage axes, in a field beside coils.

    The errors are of the component along the vector; one of length other than one gives them in proportion.
    """
    level_of = _level_of(item, observations, along, beside_ut)
    level = np.array([level_of(row, {}) for row in range(len(item.dwells))])
    return tuple(_errors(item, observations, axis, along, level_of, level))


Turned = Callable[[int, Mapping[str, float], FloatArray], float]


def _turned(observations: Observations, along: FloatArray) -> Turned:
    """Return the component along a vector in stage axes of one that is known in level axes."""
    known = _angles_rad(observations)

    def component(row: int, by_rad: Mapping[str, float], vector: FloatArray) -> float:
        pitch, yaw, roll = (known[name][row] + by_rad.get(name, 0.0) for name in ANGLES)
        pitch += by_rad.get(BASE_ABOUT_PITCH, 0.0)
        tilt = by_rad.get(BASE_ACROSS, 0.0)
        leaned = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(tilt), -np.sin(tilt)], [0.0, np.sin(tilt), np.cos(tilt)]])
        return float(along @ to_stage(pitch, yaw, roll) @ leaned @ vector)

    return component


def _level_of(item: SensorRows, observations: Observations, along: FloatArray, beside_ut: FloatArray) -> LevelOf:
    known = _angles_rad(observations)
    rates = observations.euler_rate_rad_s
    turned = _turned(observations, along)

    def rate_dps(row: int, by_rad: Mapping[str, float]) -> float:
        if rates is None:
            return 0.0
        angles = np.array([[known[name][row] + by_rad.get(name, 0.0) for name in ANGLES]])
        return float(np.rad2deg(body_rates_rad_s(angles, rates[row : row + 1])[0]) @ along)

    if item.sensor.measures == "rate":
        return rate_dps
    if item.sensor.measures == "acceleration":
        return lambda row, by_rad: turned(row, by_rad, UP)
    return lambda row, by_rad: turned(row, by_rad, beside_ut + applied_ut(item.dwells[row], item.rig))


def _angles_rad(observations: Observations) -> Mapping[str, FloatArray]:
    yaw = np.zeros(observations.rows) if observations.yaw_rad is None else observations.yaw_rad
    return {"pitch": observations.pitch_rad, "yaw": yaw, "roll": observations.roll_rad}


def applied_ut(row: DwellRecord, rig: RigDescription) -> FloatArray:
    """Return the field of the coils in level axes."""
    assert row.motion is not None
    applied = [field_ut * _unit(rig, coil) for coil, field_ut in row.motion.field_ut.items()]
    return np.asarray(np.sum([np.zeros(3), *applied], axis=0))


def _unit(rig: RigDescription, coil: str) -> FloatArray:
    direction = np.array(rig.field[coil].direction)
    return np.asarray(direction / np.linalg.norm(direction))


def _coil(row: int, item: SensorRows) -> FloatArray:
    motion = item.dwells[row].motion
    assert motion is not None
    ((coil, _),) = motion.field_ut.items()
    return _unit(item.rig, coil)


def _errors(
    item: SensorRows,
    observations: Observations,
    axis: str,
    along: FloatArray,
    level_of: LevelOf,
    level: FloatArray,
) -> Iterator[LevelError]:
    """Tell every error of the levels that the rig file declares: attitudes, the level of the base, coils."""
    slope, curvature = _changes(level_of, level)
    table = table_uncertainty(item.rig)
    if table is not None:
        columns = _of_attitudes(table, observations, slope, curvature)
        yield LevelError(SharedError("table", "level", 1.0, "standard", table_in_words(item.rig)), columns)
    for error in shared_errors(item.rig, item.sensor, counts_earth=item.plan.counts_earth)[axis]:
        if error.effect in OF_BASE:
            angle, u_rad = OF_BASE[error.effect], error.standard_uncertainty
            columns = np.stack([slope[angle] * u_rad, curvature[angle] * u_rad**2 / 2.0], axis=-1)
            yield LevelError(replace(error, effect="level", standard_uncertainty=1.0), columns)
            continue
        if error.effect == "rotation" and observations.from_level is not None:
            columns = np.einsum("i,nij->nj", along, observations.from_level[:, :, list(error.columns)])
            yield LevelError(
                replace(error, effect="level", standard_uncertainty=1.0, columns=()),
                columns * error.standard_uncertainty,
            )
    yield from _of_coils(item, observations, along)
    yield from _of_surroundings(item, observations, along)


def _changes(level_of: LevelOf, level: FloatArray) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Return the first and second derivatives of every row's level by the turn of each place."""
    rows = range(level.size)
    slope, curvature = {}, {}
    for angle in TURNED:
        ahead, behind = (np.array([level_of(row, {angle: sense * STEP_RAD}) for row in rows]) for sense in (1.0, -1.0))
        slope[angle] = (ahead - behind) / (2.0 * STEP_RAD)
        curvature[angle] = (ahead - 2.0 * level + behind) / STEP_RAD**2
    return slope, curvature


def _of_attitudes(
    table: TableUncertainty,
    observations: Observations,
    slope: Mapping[str, FloatArray],
    curvature: Mapping[str, FloatArray],
) -> FloatArray:
    """Return one column an index, and one for what all of them do to the same side."""
    u_rad = table.standard_rad()
    each = index_columns(table, _angles_rad(observations), {name: slope[name] for name in ANGLES})
    together = np.sum([curvature[name] * u_rad[name] ** 2 / 2.0 for name in ANGLES], axis=0)
    return np.concatenate([each, together[:, None]], axis=1)


def _of_coils(item: SensorRows, observations: Observations, along: FloatArray) -> Iterator[LevelError]:
    turned = _turned(observations, along)
    applied: dict[str, list[float]] = {}
    for row in item.dwells:
        for coil in () if row.motion is None else row.motion.field_ut:
            applied[coil] = [
                0.0 if dwell.motion is None else dwell.motion.field_ut.get(coil, 0.0) for dwell in item.dwells
            ]
    for coil, fields_ut in applied.items():
        u_ut, largest_ut = item.rig.field[coil].uncertainty_ut, max(map(abs, fields_ut))
        if u_ut > 0.0 and largest_ut > 0.0:
            share = [turned(row, {}, _unit(item.rig, coil)) * field_ut for row, field_ut in enumerate(fields_ut)]
            stated = f"field.{coil}: standard {u_ut:g} µT of {largest_ut:g} µT, an error of its scale"
            column = np.array(share)[:, None] * u_ut / largest_ut
            yield LevelError(SharedError(f"scale of field {coil}", "level", 1.0, "standard", stated), column)
        u_deg = item.rig.field[coil].direction_uncertainty_deg
        if u_deg > 0.0 and largest_ut > 0.0:
            sides = _across(_unit(item.rig, coil)) * np.deg2rad(u_deg)
            columns = [[turned(row, {}, side) * field_ut for side in sides] for row, field_ut in enumerate(fields_ut)]
            stated = f"field.{coil}: standard {u_deg:g}° to either side"
            yield LevelError(
                SharedError(f"direction of field {coil}", "level", 1.0, "standard", stated), np.array(columns)
            )


def _across(unit: FloatArray) -> FloatArray:
    """Return (2, 3) unit vectors at right angles to one and to each other."""
    return np.asarray(np.linalg.svd(unit[None, :])[2][1:])


def _of_surroundings(item: SensorRows, observations: Observations, along: FloatArray) -> Iterator[LevelError]:
    levels = levels_of(item.plan)
    if item.sensor.measures != "field" or levels is None or levels.surroundings_uncertainty_ut == 0.0:
        return
    u_ut, turned = levels.surroundings_uncertainty_ut, _turned(observations, along)
    columns = [[turned(row, {}, component) for component in u_ut * np.eye(3)] for row in range(observations.rows)]
    stated = f"levels: standard {u_ut:g} µT of each component"
    yield LevelError(SharedError("surroundings", "level", 1.0, "standard", stated), np.array(columns))


def _magnet_levels(rows: Sequence[DwellRecord], reading: FloatArray) -> LevelRows:
    """SR's magnet: within a replication the difference that it makes tells its field, and that the levels.

    An axis is where the magnet changes its reading most: once up, once down.
    """
    kept: list[int] = []
    levels: list[float] = []
    for replication in sorted({row.replication for row in rows}):
        off, on = (
            {
                tuple(row.targets_deg.items()): index
                for index, row in enumerate(rows)
                if row.replication == replication
                and (row.motion is not None and any(row.motion.field_ut.values())) == is_on
            }
            for is_on in (False, True)
        )
        changed = {attitude: reading[on[attitude]] - reading[off[attitude]] for attitude in off if attitude in on}
        up, down = max(changed, key=lambda coil: changed[coil]), min(changed, key=lambda coil: changed[coil])
        found = magnet_difference(
            with_magnet=(float(reading[on[up]]), float(reading[on[down]])),
            without_magnet=(float(reading[off[up]]), float(reading[off[down]])),
        )
        kept += [off[up], off[down]]
        levels += found.real
    indices = np.array(kept, dtype=np.int64)
    return LevelRows(indices, np.array(levels), reading[indices])
