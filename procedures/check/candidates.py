"""Which calibrations a rig could make, how long each takes and what it leaves unknown: what `calrig plan` compares.

Designs on the axes' own lattice × replications × readings × integration × order × sensors on the table at once. Every
candidate is expected by the solver itself (:mod:`procedures.solution.expected`) and timed as a plan is
(:mod:`procedures.plan.estimate`). The matrices are small: one thread of the linear algebra is quicker than several.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, sqrt
from pathlib import Path

from threadpoolctl import threadpool_limits

from ams.errors import AmsError
from ams.statistics.distributions import f_quantile
from ams.units import RAD_PER_ARCSEC
from procedures.check.candidate import STEEPEST_DEG, Candidate, Comparison, SearchRequest, Target, half_in_words
from procedures.check.candidate_lattice import tables_on_the_lattice
from procedures.check.candidate_timing import Ordered, Timed, in_orders, readings_of, readout_nplc
from procedures.check.procedure_text import Written, procedure_text
from procedures.description.procedure_file import ProcedureDescription, Solve
from procedures.errors import PlanError
from procedures.kinds.read import procedure_of
from procedures.plan.adaptive import Reading
from procedures.plan.channels import sensors_that_measure, temperature_source
from procedures.solution.beliefs import AxisBelief, beliefs_of
from procedures.solution.expected import Believed, ExpectedSensor, PlannedRows, expected_each
from rig.description.rig_file import RigDescription, Sensor
from rig.toml_file import TomlFile

REFERENCE_EVERY = 25
"""Dwells between two visits of the reference attitudes."""
IN_HAND = 1.1
"""What is stated scatters from run to run: the choice leaves a tenth in hand."""
_BLIND = {"quadratic": "q_xx_v_per_g2", "cubic": "k3_v_per_g3"}

_HELPS = {
    True: (
        "a better table or one whose errors are listed (index_table), more readings at use (--usage-noise-arcsec) or a "
        "smaller usage range would help"
    ),
    False: "a better table or one whose errors are listed (index_table) would help",
}
"""What would, for an angle and for a parameter."""


def compare(request: SearchRequest) -> Comparison:
    """Return the candidates compared. Raises: PlanError where none can be made or none reaches the target."""
    with threadpool_limits(limits=1, user_api="blas"):
        return _compared(request)


def _compared(request: SearchRequest) -> Comparison:
    sensors = sensors_that_measure(request.rig, "acceleration")
    if not sensors:
        raise PlanError("plan: the rig has no sensor that measures acceleration; there is nothing to plan for")
    low, high = request.usage.pitch_deg
    if not -STEEPEST_DEG <= low < high <= STEEPEST_DEG:
        raise PlanError(
            f"plan: --usage-pitch: got {low:g} to {high:g}, allowed a range that rises within ±{STEEPEST_DEG:g}°"
        )
    if request.usage.noise_arcsec is None:
        request = replace(request, usage=replace(request.usage, noise_arcsec=_at_use_arcsec(request, sensors)))
    candidates = tuple(
        sorted(_candidates(request, sensors), key=lambda candidate: (candidate.hours, candidate.half_width_deg))
    )
    if not candidates:
        raise PlanError(
            "plan: no design on the lattice of these axes can be solved and reached within their limits; widen "
            "limits_deg or the usage range"
        )
    target = request.target
    if target.parameter is not None and target.parameter[0] not in candidates[0].parameters:
        raise PlanError(
            f"plan: --parameter: got {target.parameter[0]!r}, the sensors have {', '.join(candidates[0].parameters)}"
        )
    front: list[int] = []
    is_choice = [not candidate.is_confounded for candidate in candidates]
    for index, candidate in enumerate(candidates):
        if not is_choice[index] and any(is_choice):
            continue
        if not front or candidate.value(request.target) < candidates[front[-1]].value(request.target):
            front.append(index)
    return Comparison(request, candidates, _chosen(request, candidates, front), len(sensors), tuple(front))


def _chosen(request: SearchRequest, candidates: Sequence[Candidate], front: Sequence[int]) -> int:
    target = request.target
    best = front[-1]
    if target.hours is not None:
        within = [index for index in front if candidates[index].hours <= target.hours]
        if not within:
            least = candidates[front[0]]
            raise PlanError(
                f"plan: --hours: got {target.hours:g}, the shortest calibration that can be solved takes "
                f"{_rounded_up(least.hours)} h ({least.points} points, {least.replications} replications) and leaves "
                f"{least.half_width_deg:.2g}° of an angle; nothing was written; give as many hours"
            )
        return within[-1]
    wanted = target.parameter[1] if target.parameter is not None else target.half_width_deg
    assert wanted is not None
    for index in front:
        if IN_HAND * candidates[index].value(target) <= wanted:
            return index
    nearest = candidates[best]
    what = "an angle" if target.parameter is None else target.parameter[0]
    in_reach = _half_width_in_words(target, IN_HAND * nearest.value(target))
    raise PlanError(
        f"plan: a half-width of {_half_width_in_words(target, wanted)} of {what} is out of reach: with 10 % in hand "
        f"the nearest is {in_reach} in {nearest.hours:.3g} h ({nearest.points} points, {nearest.replications} "
        f"replications, {nearest.samples} readings), of which the calibration leaves "
        f"{nearest.calibration_deg:.2g}° of an angle; nothing was written; {_HELPS[target.parameter is None]}"
    )


def _half_width_in_words(target: Target, half_width: float) -> str:
    return f"{half_width:.3g}°" if target.parameter is None else half_in_words(target.parameter[0], half_width)


def _rounded_up(hours: float) -> str:
    """Return hours in words that may be asked for: what is said to be enough is."""
    return f"{ceil(hours * 100.0) / 100.0:.2f}"


def model_for(rig: RigDescription) -> str:
    """Return the model that the axes of a rig can determine."""
    return "pitch-roll" if "roll" in rig.axes else "pitch-only"


def procedure_of_table(table: Mapping[str, object], model: str) -> ProcedureDescription:
    """Return a procedure of two replications, from which every number of them is timed."""
    text = procedure_text(Written("plan", table, 2, 20, model, reference_every=REFERENCE_EVERY))
    return procedure_of(TomlFile(Path("plan"), text))


def _candidates(request: SearchRequest, sensors: Mapping[str, Sensor]) -> Iterator[Candidate]:
    solve = Solve(model=model_for(request.rig))
    readings = readings_of(request.rig, sensors, request.space.samples)
    believed = {
        replications: _believed(request, solve, sensors, replications, readings)
        for replications in request.space.replications
    }
    for table in tables_on_the_lattice(request):
        procedure = procedure_of_table(table, solve.model)
        try:
            designs = in_orders(request.rig, procedure, sensors, request.space.orders, request.learned)
        except PlanError:
            continue
        timed = [_timed(ordered, readings) for ordered in designs]
        for replications, beliefs in believed.items():
            foreseen: dict[int, Sequence[_Foreseen]] = {}
            for ordered, durations in zip(designs, timed, strict=True):
                points = len(ordered.design.points)
                if points not in foreseen:
                    foreseen[points] = _foreseen(request, solve, sensors, ordered, replications, beliefs)
                design_table = {**table, "order": ordered.order}
                for reading, forecast in zip(readings, foreseen[points], strict=False):
                    yield from _at_once(ordered, design_table, replications, reading, durations[reading], forecast)


@dataclass(frozen=True)
class _Foreseen:
    """What a design leaves unknown, for one setting of the readings and one number of replications."""

    half_width_deg: float
    calibration_deg: float
    shares_deg: Mapping[str, float]
    parameters: Mapping[str, float]
    sees_lack_of_fit_arcsec: float
    sees_drift_arcsec: float
    blind_to: tuple[str, ...]


def _timed(ordered: Ordered, readings: Sequence[Reading]) -> dict[Reading, dict[int, Timed]]:
    """Return the durations with one sensor on the table at once, with some and with all."""
    every = len(ordered.sensors)
    counts = sorted({*(2**power for power in range(every.bit_length())), every})
    return {reading: {count: ordered.timed(reading, count) for count in counts} for reading in readings}


def _at_once(
    ordered: Ordered,
    table: Mapping[str, object],
    replications: int,
    reading: Reading,
    durations: Mapping[int, Timed],
    foreseen: _Foreseen,
) -> Iterator[Candidate]:
    """Yield the candidate with every number of sensors on the table at once."""
    for count, timed in durations.items():
        run_hours = timed.hours(replications)
        yield Candidate(
            design=table,
            points=len(ordered.design.points),
            replications=replications,
            samples=reading.samples,
            nplc=reading.nplc,
            order=ordered.order,
            sensors=count,
            hours=ceil(len(ordered.sensors) / count) * run_hours,
            run_hours=run_hours,
            time_correlation=ordered.time_correlation,
            **vars(foreseen),
        )


def _believed(
    request: SearchRequest, solve: Solve, sensors: Mapping[str, Sensor], replications: int, readings: Sequence[Reading]
) -> list[dict[str, Believed]]:
    """Return what is believed of every sensor, for each setting of the readings."""
    nplc = readout_nplc(request.rig, sensors)
    plain = beliefs_of(request.rig, solve, request.space.samples[-1], replications, sensors, request.pilot)
    found = []
    for reading in readings:
        ratio = 1.0 if reading.nplc is None or nplc is None else reading.nplc / nplc
        found.append(
            {
                serial: Believed(
                    {axis: belief.integrated(ratio) for (name, axis), belief in plain.items() if name == serial},
                    reading.samples,
                )
                for serial in sensors
            }
        )
    return found


def _foreseen(
    request: SearchRequest,
    solve: Solve,
    sensors: Mapping[str, Sensor],
    ordered: Ordered,
    replications: int,
    beliefs: Sequence[Mapping[str, Believed]],
) -> list[_Foreseen]:
    """Return what is to be expected with each belief; nothing where the points do not determine a sensor."""
    points = ordered.design.points
    rows = PlannedRows(points, replications, None, 3600.0)
    done: dict[object, list[ExpectedSensor]] = {}
    try:
        for serial, sensor in sensors.items():
            sensor_beliefs = [each[serial] for each in beliefs]
            key = (sensor.rolls, *_used(request.rig, sensor), *map(_alike, sensor_beliefs))
            if key not in done:
                done[key] = expected_each(request.rig, solve, serial, sensor, rows, sensor_beliefs, request.usage)
    except AmsError:
        return []
    return [
        _of_all([found[index] for found in done.values()], each, len(points), replications)
        for index, each in enumerate(beliefs)
    ]


def _of_all(
    found: Sequence[ExpectedSensor], beliefs: Mapping[str, Believed], points: int, replications: int
) -> _Foreseen:
    """Return the worst of all sensors."""
    axes = [axis for sensor in found for axis in sensor.solution.axes.values()]
    halves: dict[str, float] = {}
    for item in (item for axis in axes for item in axis.parameters):
        if item.interval_95 is not None and item.standard_uncertainty:
            half = 0.5 * (item.interval_95[1] - item.interval_95[0])
            halves[item.name] = max(half, halves.get(item.name, 0.0))
    angles = [angle for sensor in found for angle in sensor.angles.values()]
    worst_angle = max(angles, key=lambda angle: angle.u95_deg)
    each = [
        (axis_belief, sensor_beliefs.samples)
        for sensor_beliefs in beliefs.values()
        for axis_belief in sensor_beliefs.axes.values()
    ]
    worst, samples = max(each, key=lambda pair: pair[0].noise_v(pair[1]))
    terms = {name for axis in axes for name in axis.added}
    return _Foreseen(
        half_width_deg=worst_angle.u95_deg,
        calibration_deg=worst_angle.calibration_deg,
        shares_deg=worst_angle.shares_deg,
        parameters=halves,
        sees_lack_of_fit_arcsec=sees_lack_of_fit_arcsec(worst, samples, points, replications, len(terms) + 4),
        sees_drift_arcsec=sees_drift_arcsec(worst, samples, points, replications),
        blind_to=tuple(words for words, name in _BLIND.items() if name not in terms),
    )


def _used(rig: RigDescription, sensor: Sensor) -> Iterator[object]:
    """Yield what of a sensor decides what its use does to it."""
    yield temperature_source(rig, sensor) is None
    yield sensor.use_temperature_degc
    yield from (sensor.largest_offset_tc_v_per_degc, sensor.largest_sensitivity_tc_per_degc)
    yield from (sensor.largest_offset_shift_v, sensor.largest_sensitivity_shift)
    yield sensor.largest_nonlinearity_v
    yield sensor.largest_g_sensitivity_dps_per_g


def _alike(believed: Believed) -> object:
    """Return what tells sensors apart that are not expected alike: neither the offset nor the azimuth does."""
    return tuple(
        (
            axis,
            float(f"{sum(axis_belief.k_v_per_g**2) ** 0.5:.4g}"),
            axis_belief.coning_deg,
            axis_belief.reading_v,
            axis_belief.dwell_v,
            axis_belief.lack_of_fit_v,
            axis_belief.offset_drift_v,
            axis_belief.sensitivity_drift,
        )
        for axis, axis_belief in believed.axes.items()
    )


def _at_use_arcsec(request: SearchRequest, sensors: Mapping[str, Sensor]) -> float:
    """Return the noise of a reading at use, the same for all candidates: that of a dwell of twenty readings."""
    believed = beliefs_of(
        request.rig, Solve(), request.space.samples[-1], request.space.replications[0], sensors, request.pilot
    )
    return (
        max(
            belief.noise_v(request.space.samples[-1]) / float(sum(belief.k_v_per_g**2) ** 0.5)
            for belief in believed.values()
        )
        / RAD_PER_ARCSEC
    )


def sees_lack_of_fit_arcsec(belief: AxisBelief, samples: int, points: int, replications: int, parameters: int) -> float:
    """Return the size at which the ratio of TP 8 stands at its limit on the average, arc seconds."""
    left = points - parameters
    if left < 1:
        return float("inf")
    limit = float(f_quantile(0.95, left, (replications - 1) * left))
    return _arcsec(belief, belief.noise_v(samples) * sqrt((limit - 1.0) / replications))


def sees_drift_arcsec(belief: AxisBelief, samples: int, points: int, replications: int) -> float:
    """Return the same for the offset's drift: that of one replication is known to noise/√points."""
    limit = float(f_quantile(0.95, replications - 1, (replications - 1) * max(points - 4, 1)))
    return _arcsec(belief, belief.noise_v(samples) * sqrt((limit - 1.0) / points))


def _arcsec(belief: AxisBelief, volts: float) -> float:
    return volts / float(sum(belief.k_v_per_g**2) ** 0.5) / RAD_PER_ARCSEC
