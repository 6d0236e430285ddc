"""Which calibrations a rig could make, how long each takes and what it leaves unknown: what `calrig plan` compares.

Designs on the axes' own lattice × replications × readings × integration, in one order. Every candidate is expected by
the solver itself (:mod:`procedures.solution.expected`) and timed as a plan is (:mod:`procedures.plan.estimate`).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, sqrt
from pathlib import Path

from ams.errors import AmsError
from ams.statistics.distributions import f_quantile
from ams.units import RAD_PER_ARCSEC
from procedures.check.candidate import ORDER, Asked, Candidate, Comparison, Target
from procedures.check.procedure_text import Written, procedure_text
from procedures.description.procedure_file import DwellSettings, ProcedureDescription, Solve
from procedures.errors import PlanError
from procedures.kinds.kind import PlanRequest
from procedures.kinds.read import procedure_of
from procedures.kinds.registry import KINDS
from procedures.plan.channels import channels_of, sensors_that_measure
from procedures.plan.designs import Design
from procedures.plan.estimate import expected_duration
from procedures.plan.sequential import CALIBRATION_OVER_USAGE
from procedures.plan.steps import Dwell, Step
from procedures.solution.beliefs import AxisBelief, beliefs_of
from procedures.solution.expected import ExpectedSensor, PlannedRows, expected_sensor
from rig.description.device_settings import AxisSettings
from rig.description.rig_file import RigDescription, Sensor
from rig.toml_file import TomlFile

SHORT_NPLC = 1.0
"""Tried beside the readouts' own integration, with the most readings."""
REFERENCE_EVERY = 25
"""Dwells between two visits of the reference attitudes."""
STEEPEST_DEG = 90.0
IN_HAND = 1.1
"""What is stated scatters from run to run: the choice leaves a tenth in hand."""
_S_PER_H = 3600.0


def compare(asked: Asked) -> Comparison:
    """Return the candidates compared. Raises: PlanError where none can be made or none reaches the target."""
    sensors = sensors_that_measure(asked.rig, "acceleration")
    if not sensors:
        raise PlanError("plan: the rig has no sensor that measures acceleration; there is nothing to plan for")
    _require_range(asked)
    if asked.usage.noise_arcsec is None:
        asked = replace(asked, usage=replace(asked.usage, noise_arcsec=_at_use_arcsec(asked, sensors)))
    candidates = tuple(sorted(_candidates(asked, sensors), key=lambda one: (one.hours, one.half_width_deg)))
    if not candidates:
        raise PlanError(
            "plan: no design on the lattice of these axes can be solved and reached within their limits; widen "
            "limits_deg or the usage range"
        )
    _require_parameter(asked.target, candidates)
    front: list[int] = []
    for place, one in enumerate(candidates):
        if not front or one.value(asked.target) < candidates[front[-1]].value(asked.target):
            front.append(place)
    return Comparison(asked, candidates, _chosen(asked, candidates, front), len(sensors), tuple(front))


def _require_range(asked: Asked) -> None:
    low, high = asked.usage.pitch_deg
    if not -STEEPEST_DEG <= low < high <= STEEPEST_DEG:
        raise PlanError(
            f"plan: --usage-pitch: got {low:g} to {high:g}, allowed a range that rises within ±{STEEPEST_DEG:g}°"
        )


def _require_parameter(target: Target, candidates: Sequence[Candidate]) -> None:
    if target.parameter is not None and target.parameter[0] not in candidates[0].parameters:
        raise PlanError(
            f"plan: --parameter: got {target.parameter[0]!r}, the sensors have {', '.join(candidates[0].parameters)}"
        )


def _chosen(asked: Asked, candidates: Sequence[Candidate], front: Sequence[int]) -> int:
    target = asked.target
    best = front[-1]
    if target.hours is not None:
        within = [place for place in front if candidates[place].hours <= target.hours]
        if not within:
            least = candidates[0]
            raise PlanError(
                f"plan: --hours: got {target.hours:g}, the shortest calibration that can be solved takes "
                f"{least.hours:.2g} h ({least.points} points, {least.replications} replications) and leaves "
                f"{least.half_width_deg:.2g}° of an angle; nothing was written; give as many hours"
            )
        return within[-1]
    wanted = target.parameter[1] if target.parameter is not None else target.half_width_deg
    assert wanted is not None
    for place in front:
        if IN_HAND * candidates[place].value(target) <= wanted:
            return place
    nearest = candidates[best]
    what = "an angle" if target.parameter is None else target.parameter[0]
    unit = "°" if target.parameter is None else ""
    raise PlanError(
        f"plan: a half-width of {wanted:.3g}{unit} of {what} is out of reach: the nearest possible is "
        f"{IN_HAND * nearest.value(target):.3g}{unit} in {nearest.hours:.3g} h ({nearest.points} points, "
        f"{nearest.replications} replications, {nearest.samples} readings), of which the calibration leaves "
        f"{nearest.calibration_deg:.2g}° of an angle; nothing was written; a better table, more readings at use "
        "(--usage-noise-arcsec) or a smaller usage range would help"
    )


@dataclass(frozen=True)
class _Timed:
    """How long a design takes, for one setting of the readings."""

    first_s: float
    """Everything up to the end of the first replication."""
    further_s: float
    """Each replication after it."""


def model_for(rig: RigDescription) -> str:
    """Return the model that the axes of a rig can determine."""
    return "pitch-roll" if "roll" in rig.axes else "pitch-only"


def _candidates(asked: Asked, sensors: Mapping[str, Sensor]) -> Iterator[Candidate]:
    rig = asked.rig
    solve = Solve(model=model_for(rig))
    for table in _tables(asked):
        procedure = procedure_of_table(table, solve.model)
        request = PlanRequest(rig, procedure, sensors, channels_of(rig, sensors))
        try:
            schedule = KINDS["grid"].schedule(request)
        except PlanError:
            continue
        for samples, nplc in _readings(rig, request.channels, asked.space.samples):
            dwell = procedure.dwell.model_copy(update={"samples": samples, "nplc": nplc})
            timed = _timed(rig, schedule.steps, dwell, request.channels)
            for replications in asked.space.replications:
                found = _candidate(asked, solve, sensors, table, schedule.design, replications, samples, nplc, timed)
                if found is not None:
                    yield found


def _tables(asked: Asked) -> Iterator[dict[str, object]]:
    """Yield the designs that fit the lattice and the limits of the axes, as tables of a procedure."""
    axes, (low, high) = asked.rig.axes, asked.usage.pitch_deg
    if "pitch" not in axes:
        return
    middle, half = 0.5 * (low + high), 0.5 * (high - low) * CALIBRATION_OVER_USAGE
    pitch_range = _within(axes["pitch"], max(middle - half, -STEEPEST_DEG), min(middle + half, STEEPEST_DEG))
    seen = set()
    for pitches, rolls, *fraction in (*asked.space.grids, *asked.space.fractions):
        pitch = _lattice(axes["pitch"], *pitch_range, pitches)
        roll = _circle(axes["roll"], rolls) if "roll" in axes else (0.0,)
        key = (pitch, roll, tuple(fraction))
        if len(pitch) < 3 or key in seen or (fraction and len(roll) <= fraction[0]):
            continue
        seen.add(key)
        kind = {"kind": "fractional", "fractional": (fraction[0], fraction[0])} if fraction else {"kind": "D"}
        with_roll = {"roll_deg": roll} if "roll" in axes else {}
        yield {**kind, "pitch_deg": pitch, **with_roll, "usage_pitch_deg": (low, high), "order": ORDER}
    for pitches, rolls, points in asked.space.optimal:
        pitch = _lattice(axes["pitch"], *pitch_range, pitches)
        roll = _circle(axes["roll"], rolls) if "roll" in axes else (0.0,)
        if len(pitch) * len(roll) > points:
            with_roll = {"roll_deg": roll} if "roll" in axes else {}
            chosen = {"kind": "optimal", "points": points, "criterion": "I"}
            yield {**chosen, "pitch_deg": pitch, **with_roll, "usage_pitch_deg": (low, high), "order": ORDER}


def _within(axis: AxisSettings, low_deg: float, high_deg: float) -> tuple[float, float]:
    ends = sorted(axis.attitude_deg(limit) for limit in axis.limits_deg)
    room = abs(axis.approach_deg)
    return max(low_deg, ends[0] + room), min(high_deg, ends[1] - room)


def _lattice(axis: AxisSettings, low_deg: float, high_deg: float, count: int) -> tuple[float, ...]:
    """Return angles as evenly spread as the axis allows where it stops."""
    wanted = [low_deg + (high_deg - low_deg) * place / (count - 1) for place in range(count)]
    return tuple(dict.fromkeys(_stop(axis, angle, low_deg, high_deg) for angle in wanted))


def _stop(axis: AxisSettings, angle_deg: float, low_deg: float, high_deg: float) -> float:
    """Return the attitude nearest to an angle at which the axis stops, inside the range."""
    step = axis.increment_deg
    if step == 0.0:
        return round(angle_deg, 6)
    ends = sorted(axis.table_deg(end) for end in (low_deg, high_deg))
    place = min(max(round(axis.table_deg(angle_deg) / step), ceil(ends[0] / step - 1e-9)), floor(ends[1] / step + 1e-9))
    return round(axis.attitude_deg(place * step), 6)


def _circle(axis: AxisSettings, count: int) -> tuple[float, ...]:
    """Return rolls all round, or over what the axis reaches where it does not go round."""
    low, high = _within(axis, -180.0, 180.0 - 360.0 / count)
    if (low, high) != (-180.0, 180.0 - 360.0 / count):
        low, high = _within(axis, -180.0, 180.0)
    return _lattice(axis, low, high, count)


def _readings(
    rig: RigDescription, channels: Sequence[str], samples: Sequence[int]
) -> Iterator[tuple[int, float | None]]:
    """Yield readings a dwell and their integration; a short one where every readout has a longer one of its own."""
    yield from ((number, None) for number in samples)
    own = _own_nplc(rig, channels)
    if own is not None and own > SHORT_NPLC:
        yield samples[-1], SHORT_NPLC


def _own_nplc(rig: RigDescription, channels: Sequence[str]) -> float | None:
    """Return the integration of the readouts, power-line cycles, where all have the same."""
    names = {channel.partition(".")[0] for channel in channels}
    found = {getattr(rig.readouts[name], "nplc", None) if name in rig.readouts else None for name in names}
    (own,) = found if len(found) == 1 else (None,)
    return float(own) if isinstance(own, int | float) else None


def procedure_of_table(table: Mapping[str, object], model: str) -> ProcedureDescription:
    """Return a procedure of two replications, from which every number of them is timed."""
    text = procedure_text(Written("plan", table, 2, 20, model, reference_every=REFERENCE_EVERY))
    return procedure_of(TomlFile(Path("plan"), text))


def _timed(rig: RigDescription, steps: Sequence[Step], dwell: DwellSettings, channels: Sequence[str]) -> _Timed:
    """Return the durations, from the steps of two replications."""
    first = [step for step in steps if not isinstance(step, Dwell) or step.replication < 2]
    first_s = expected_duration(rig, first, dwell, channels).p50_s
    return _Timed(first_s, expected_duration(rig, steps, dwell, channels).p50_s - first_s)


def _candidate(
    asked: Asked,
    solve: Solve,
    sensors: Mapping[str, Sensor],
    table: Mapping[str, object],
    design: Design,
    replications: int,
    samples: int,
    nplc: float | None,
    timed: _Timed,
) -> Candidate | None:
    """Return what is to be expected; None where the points do not determine a sensor."""
    own = _own_nplc(asked.rig, channels_of(asked.rig, sensors))
    believed = beliefs_of(asked.rig, solve, asked.space.samples[-1], replications, sensors, asked.pilot)
    if nplc is not None and own is not None:
        believed = {name: one.integrated(nplc / own) for name, one in believed.items()}
    rows = PlannedRows(design.points, replications, None, timed.further_s)
    found: list[ExpectedSensor] = []
    done: dict[object, ExpectedSensor] = {}
    try:
        for serial, sensor in sensors.items():
            mine = {axis: one for (name, axis), one in believed.items() if name == serial}
            key = _alike(mine)
            if key not in done:
                done[key] = expected_sensor(asked.rig, solve, serial, sensor, rows, mine, samples, asked.usage)
            found.append(done[key])
    except AmsError:
        return None
    axes = [axis for sensor in done.values() for axis in sensor.solution.axes.values()]
    halves: dict[str, float] = {}
    for item in (item for axis in axes for item in axis.parameters):
        if item.interval_95 is not None and item.standard_uncertainty:
            half = 0.5 * (item.interval_95[1] - item.interval_95[0])
            halves[item.name] = max(half, halves.get(item.name, 0.0))
    angles = [angle for sensor in found for angle in sensor.angles.values()]
    worst = max(believed.values(), key=lambda one: one.noise_v(samples))
    terms = {name for axis in axes for name in axis.added}
    blind = {"quadratic": "q_xx_v_per_g2", "cubic": "k3_v_per_g3"}
    return Candidate(
        design=table,
        points=len(design.points),
        replications=replications,
        samples=samples,
        nplc=nplc,
        hours=(timed.first_s + (replications - 1) * timed.further_s) / _S_PER_H,
        half_width_deg=max(angle.u95_deg for angle in angles),
        calibration_deg=max(angle.calibration_deg for angle in angles),
        parameters=halves,
        sees_lack_of_fit_arcsec=_sees_lack_of_fit(worst, samples, len(design.points), replications, len(terms) + 4),
        sees_drift_arcsec=_sees_drift(worst, samples, len(design.points), replications),
        blind_to=tuple(words for words, name in blind.items() if name not in terms),
    )


def _alike(believed: Mapping[str, AxisBelief]) -> object:
    """Return what tells sensors apart that are not expected alike."""
    return tuple(
        (
            axis,
            tuple(one.k_v_per_g),
            one.reading_v,
            one.dwell_v,
            one.lack_of_fit_v,
            one.offset_drift_v,
            one.sensitivity_drift,
        )
        for axis, one in believed.items()
    )


def _at_use_arcsec(asked: Asked, sensors: Mapping[str, Sensor]) -> float:
    """Return the noise of a reading at use, the same for all candidates: that of a dwell of twenty readings."""
    believed = beliefs_of(
        asked.rig, Solve(), asked.space.samples[-1], asked.space.replications[0], sensors, asked.pilot
    )
    return (
        max(one.noise_v(asked.space.samples[-1]) / float(sum(one.k_v_per_g**2) ** 0.5) for one in believed.values())
        / RAD_PER_ARCSEC
    )


def _sees_lack_of_fit(belief: AxisBelief, samples: int, points: int, replications: int, parameters: int) -> float:
    """Return the size at which the ratio of TP 8 stands at its limit on the average, arc seconds."""
    left = points - parameters
    if left < 1:
        return float("inf")
    limit = float(f_quantile(0.95, left, (replications - 1) * left))
    return _arcsec(belief, belief.noise_v(samples) * sqrt((limit - 1.0) / replications))


def _sees_drift(belief: AxisBelief, samples: int, points: int, replications: int) -> float:
    """Return the same for the offset's drift: that of one replication is known to noise/√points."""
    limit = float(f_quantile(0.95, replications - 1, (replications - 1) * max(points - 4, 1)))
    return _arcsec(belief, belief.noise_v(samples) * sqrt((limit - 1.0) / points))


def _arcsec(belief: AxisBelief, volts: float) -> float:
    return volts / float(sum(belief.k_v_per_g**2) ** 0.5) / RAD_PER_ARCSEC
