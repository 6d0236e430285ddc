"""What to expect of a schedule of points: turns, rests, fields.

The uncertainty is that of ordinary least squares at the planned rates or levels, from the twin's noise where there is a
twin; at the bench nothing is guessed.
"""

from collections.abc import Iterable, Iterator
from math import sqrt

import numpy as np

from ams.arrays import FloatArray
from procedures.kinds.expected import ExpectedAxis
from procedures.kinds.kind import Forecast
from procedures.plan.channels import AXES
from procedures.plan.plan import Plan
from procedures.plan.rotations import UP, body_axis, to_stage
from procedures.plan.steps import Dwell, Follow, Rest, Turn
from rig.description.rig_file import RigDescription, Sensor

FEWEST_REPLICATIONS = 4
"""Below, intervals rest on so few degrees of freedom that they are wide."""


def forecast_of_points(rig: RigDescription, plan: Plan) -> Forecast:
    """Judge a schedule of points beforehand."""
    expected = [axis for name, sensor in plan.sensors.items() for axis in _expected(rig, plan, name, sensor)]
    return Forecast(tuple(expected), (*_advice(plan), *_unguarded(rig, plan)), turns=_turns(plan))


def _turns(plan: Plan) -> dict[str, float]:
    turns: dict[str, float] = {}
    for dwell in plan.dwells:
        if isinstance(dwell.motion, Turn) and dwell.motion.sweep_deg is None:
            axis = dwell.motion.turned_axis
            turns[axis] = max(turns.get(axis, 0.0), float(dwell.motion.revolutions))
    return turns


def _led_by_a_rate(dwell: Dwell) -> Iterable[str]:
    """Axes whose last command is a rate while the dwell lasts."""
    match dwell.motion:
        case Turn(sweep_deg=None):
            return (dwell.motion.turned_axis,)
        case Follow():
            return dwell.motion.span_deg
    return ()


def _unguarded(rig: RigDescription, plan: Plan) -> Iterator[str]:
    """Axes that turn on and on and that nothing stops when the computer dies; a sweep ends at its target."""
    turned = {name for dwell in plan.dwells for name in _led_by_a_rate(dwell)}
    for name in plan.axes:
        if name in turned and getattr(rig.axes[name], "watchdog_s", None) is None:
            yield (
                f"axes.{name} has no watchdog_s: if this computer dies while it turns, it turns on; keep the machine's "
                "stop button within reach"
            )


def _advice(plan: Plan) -> Iterator[str]:
    if plan.replications < FEWEST_REPLICATIONS:
        yield (
            f"{plan.replications} replication{'s' if plan.replications > 1 else ''}: intervals rest on few degrees of "
            f"freedom; {FEWEST_REPLICATIONS} or more make them much narrower"
        )


def _expected(rig: RigDescription, plan: Plan, name: str, sensor: Sensor) -> Iterator[ExpectedAxis]:
    """Yield every axis whose noise the twin knows and whose rows can be told beforehand."""
    truths = {} if rig.twin is None else {str(axis): truth for axis, truth in rig.twin.truth.get(name, {}).items()}
    if _follows(plan) or plan.solve.model not in ("gyro", "linear"):
        return
    rates = np.array([_rates_dps(dwell) for dwell in plan.design_dwells])
    for axis in map(str, sensor.channels):
        truth = truths.get(axis)
        if truth is None or truth.noise == 0.0:
            continue
        columns: list[FloatArray] = [np.ones(len(plan.design_dwells))]
        names: tuple[str, ...]
        if plan.solve.model == "gyro":
            columns += [rates[:, place] for place in range(3)]
            names = ("offset_v", "k_x_v_per_dps", "k_y_v_per_dps", "k_z_v_per_dps")
        else:
            columns.append(_levels(rig, plan, sensor, axis, rates))
            names = ("reading at zero", "reading per unit")
        noise = np.array([truth.noise / sqrt(_samples(rig, plan, dwell, sensor, axis)) for dwell in plan.design_dwells])
        scaled = np.stack(columns, axis=-1) / noise[:, None]
        covariance = np.linalg.pinv(scaled.T @ scaled)
        values = {key: sqrt(float(value)) for key, value in zip(names, np.diag(covariance), strict=True)}
        yield ExpectedAxis(
            name, axis, float(noise.max()), f"the twin's {truth.noise:g} a reading", truth.coning_deg, values
        )


def _follows(plan: Plan) -> bool:
    return any(isinstance(dwell.motion, Follow) for dwell in plan.design_dwells)


def _rates_dps(dwell: Dwell) -> tuple[float, float, float]:
    """Angular velocity in package axes: one axis turns by itself, the others stand at 0."""
    about = {"roll": 0, "pitch": 1, "yaw": 2}
    rates = [0.0, 0.0, 0.0]
    if isinstance(dwell.motion, Turn):
        rates[about[dwell.motion.turned_axis]] = dwell.motion.rate_dps
    return rates[0], rates[1], rates[2]


def _levels(rig: RigDescription, plan: Plan, sensor: Sensor, axis: str, rates: FloatArray) -> FloatArray:
    along = body_axis(sensor, axis)
    if sensor.measures == "rate":
        return np.asarray(rates @ along)
    levels = []
    for dwell in plan.design_dwells:
        angles = [np.deg2rad(dwell.targets_deg.get(name, 0.0)) for name in AXES]
        if sensor.measures == "acceleration":
            levels.append(float(along @ to_stage(*angles) @ UP))
            continue
        assert plan.levels is not None
        assert dwell.applied is not None
        coil = np.array(rig.field[dwell.applied.coil].direction)
        beside = np.array(plan.levels.surroundings_ut or (0.0, 0.0, 0.0))
        level = beside + dwell.applied.field_ut * coil / np.linalg.norm(coil)
        levels.append(float(along @ to_stage(*angles) @ level))
    return np.array(levels)


def _samples(rig: RigDescription, plan: Plan, dwell: Dwell, sensor: Sensor, axis: str) -> float:
    """Return how many readings of one channel a dwell takes."""
    name = {str(key): channel for key, channel in sensor.channels.items()}[axis].partition(".")[0]
    if name in rig.readouts:
        return float(plan.dwell.samples)
    seconds = dwell.motion.seconds if isinstance(dwell.motion, Turn) else _rest_s(dwell.motion)
    return max(seconds * rig.streams[name].samples_hz(), 1.0)


def _rest_s(motion: object) -> float:
    return motion.rest_seconds if isinstance(motion, Rest) else 0.0
