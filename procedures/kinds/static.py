"""``static``: at rest for long: offset, Allan deviation, and whether the drift is small enough for the use."""

from collections.abc import Iterator, Mapping, Sequence
from math import hypot, sqrt

import numpy as np

from ams.statistics.noise import AllanDeviation, allan_deviation, read_coefficients
from ams.statistics.noise_terms import POWER_OF_TIME, TERMS, WORDS, NoiseTerm, noise_terms
from ams.units import printed
from procedures.description.kind_tables import Static
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Forecast, Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.kinds.section import Curve, Plot, Section, TextTable, recorded_tables, section_of
from procedures.numbers import two_digits, with_uncertainty
from procedures.plan.plan import Plan
from procedures.plan.points import Point
from procedures.plan.steps import Rest
from procedures.records.dwells import DwellRecord
from procedures.solution.by_model import observed
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor, StaticAxis
from procedures.solution.type_b import shared_errors
from rig.description.rig_file import RigDescription, Sensor
from rig.toml_file import StrictTable

COVERAGE = 2.0


class LongRest(PointKind):
    """One attitude, one long recording."""

    name = "static"
    table: tuple[str, type[StrictTable]] | None = ("static", Static)
    models: tuple[str, ...] = ("linear",)

    def measures(self, model: str) -> tuple[str, ...]:
        return "acceleration", "rate", "field"

    def points(self, request: PlanRequest) -> Sequence[Point]:
        rig, procedure = request.rig, request.procedure
        static = procedure.own(Static)
        assert static is not None
        wanted = {"pitch": static.pitch_deg, "roll": static.roll_deg}
        for axis, angle in wanted.items():
            if angle != 0.0 and axis not in rig.axes:
                raise procedure.error(("static", f"{axis}_deg"), f"the rig has no axis {axis}")
        if static.shortest_s > static.duration_s / 4.0:
            raise procedure.error(
                ("static", "shortest_s"),
                f"{static.shortest_s:g} s leaves no averaging time of {static.duration_s:g} s at rest; allowed are up "
                f"to {static.duration_s / 4.0:g} s; lower it or rest for longer",
            )
        return [({name: angle for name, angle in wanted.items() if name in rig.axes}, Rest(static.duration_s), None)]

    def key_of_angle(self, axis: str) -> Key:
        return "static", f"{axis}_deg"

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        static = plan.static
        assert static is not None
        if static.duration_s >= 4.0 * static.use_s:
            return Forecast()
        sentence = (
            f"a rest of {static.duration_s:g} s says little about a use of {static.use_s:g} s: the verdict rests on a "
            "handful of neighbouring means; rest for ten times as long"
        )
        return Forecast(advice=(sentence,))

    def solve(self, item: SensorRows) -> SolvedSensor:
        rows = item.at_declared()
        return SolvedSensor(
            item.name, observed(item), None, None, static=_static(item.sensor, rows, item.rig, item.plan)
        )

    def section(self, record: RunRecord, solved: SolvedSensor) -> Section | None:
        if not solved.static:
            return section_of(record, solved)
        name, axes = solved.name, solved.static
        beyond = tuple(f"{name} {axis}: {one.verdict}" for axis, one in axes.items() if one.holds is False)
        return Section(
            _static_result(solved.name, solved.static),
            beyond,
            (_static_table(solved.static), *_terms_tables(solved.static), *recorded_tables(record.dwells)),
            tuple(_allan_plot(solved.name, solved.static)),
        )


def _static(sensor: Sensor, rows: list[DwellRecord], rig: RigDescription, plan: Plan) -> dict[str, StaticAxis]:
    return {str(axis): _static_axis(sensor, channel, rows, rig, plan) for axis, channel in sensor.channels.items()}


def _static_axis(sensor: Sensor, channel: str, rows: list[DwellRecord], rig: RigDescription, plan: Plan) -> StaticAxis:
    """Return what the longest look says of an axis.

    The Allan deviation at the time of use says how far two neighbouring means lie apart.
    """
    assert plan.static is not None
    reading = rows[0].readings[channel]
    allan = allan_deviation(reading.samples, reading.interval_s).from_tau(plan.static.shortest_s)
    coefficients = read_coefficients(allan)
    count = reading.samples.size
    factor = min(max(round(plan.static.use_s / reading.interval_s), 1), count // 2)
    at_use = float(allan_deviation(reading.samples, reading.interval_s, [factor]).deviation[0])
    axis = next(str(axis) for axis, name in sensor.channels.items() if name == channel)
    drift_deg = _drift_deg(sensor, axis, reading.unit, at_use, plan.static.use_s)
    means = [row.readings[channel].mean for row in rows]
    mean = float(np.mean(means))
    scatter = float(np.std(means, ddof=1) / sqrt(len(means))) if len(means) > 1 else float(allan.deviation[-1])
    return StaticAxis(
        unit=reading.unit,
        mean=mean,
        mean_uncertainty=hypot(scatter, *_of_the_meter(rig, sensor, channel, mean)),
        tau_s=tuple(allan.tau_s.tolist()),
        allan_deviation=tuple(allan.deviation.tolist()),
        random_walk_per_sqrt_s=coefficients.random_walk_per_sqrt_s,
        bias_instability=coefficients.bias_instability,
        is_bottom_reached=coefficients.is_bottom_reached,
        use_s=plan.static.use_s,
        allowed_deg=plan.static.allowed_deg,
        drift_deg=drift_deg,
        verdict=_verdict(drift_deg, plan.static.use_s, plan.static.allowed_deg),
        noise_terms=_terms(allan, count, reading.interval_s),
    )


def _terms(allan: AllanDeviation, count: int, interval_s: float) -> tuple[NoiseTerm, ...]:
    """Return the five terms where there are averaging times enough for them, and anything to be seen at all."""
    if allan.tau_s.size <= len(TERMS) or not allan.deviation.all():
        return ()
    return noise_terms(allan, count, interval_s)


def _of_the_meter(rig: RigDescription, sensor: Sensor, channel: str, mean: float) -> Iterator[float]:
    """Yield standard uncertainties of a mean by what the rig declares of the chain that reads it."""
    axis = next(str(axis) for axis, name in sensor.channels.items() if name == channel)
    for error in shared_errors(rig, sensor)[axis]:
        if error.effect == "reading":
            yield error.standard_uncertainty
        elif error.effect == "gain":
            yield error.standard_uncertainty * mean


def _drift_deg(sensor: Sensor, axis: str, unit: str, deviation: float, use_s: float) -> float | None:
    """Zeroed by the mean over as long as it is used: √2 of the deviation at that time, integrated for a rate."""
    if sensor.measures == "rate" and unit == "dps":
        return COVERAGE * sqrt(2.0) * deviation * use_s
    per_g = 1.0 if unit == "g" else abs(sensor.nominal_v_per_g(axis))
    if sensor.measures == "acceleration" and per_g:
        return float(np.rad2deg(COVERAGE * sqrt(2.0) * deviation / per_g))
    return None


def _verdict(drift_deg: float | None, use_s: float, allowed_deg: float) -> str:
    if drift_deg is None:
        return "no verdict: nothing says how many degrees its reading is"
    relation = "within" if drift_deg <= allowed_deg else "beyond"
    return f"drifts by {drift_deg:.3g} deg (k = 2) in {use_s:g} s, {relation} the allowed ±{allowed_deg:g} deg"


def _static_result(name: str, static: Mapping[str, StaticAxis]) -> str:
    """Say which axes hold what is allowed."""
    one = next(iter(static.values()))
    words = {True: f"within ±{one.allowed_deg:g}°", False: f"beyond ±{one.allowed_deg:g}°", None: "of unknown size"}
    parts = [
        f"{', '.join(axis for axis, each in static.items() if each.holds is held)} {word}"
        for held, word in words.items()
        if any(each.holds is held for each in static.values())
    ]
    return f"{name}: drift in {one.use_s:g} s {'; '.join(parts)}"


def _static_table(static: Mapping[str, StaticAxis]) -> TextTable:
    rows = tuple(
        (
            axis,
            printed(one.unit),
            *with_uncertainty(one.mean, one.mean_uncertainty),
            two_digits(one.random_walk_per_sqrt_s),
            f"{two_digits(one.bias_instability)}{'' if one.is_bottom_reached else ' at most'}",
            one.verdict,
        )
        for axis, one in static.items()
    )
    headings = ("axis", "unit", "offset", "u", "random walk (·√s)", "bias instability", "verdict")
    note = "Zeroed by the mean over as long as it is used: √2 of the Allan deviation at that time, expanded with k = 2."
    return TextTable("At rest", headings, rows, note)


def _terms_tables(static: Mapping[str, StaticAxis]) -> Iterator[TextTable]:
    """Yield the table of the five terms, of the axes that rested long enough for them."""
    rows = tuple(
        (axis, printed(one.unit), *(_term_in_words(term) for term in one.noise_terms))
        for axis, one in static.items()
        if one.noise_terms
    )
    if not rows:
        return
    headings = ("axis", "unit", *(f"{WORDS[term]} ({_per_time(term)})" for term in TERMS))
    note = (
        "σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3 + R²τ²/2, with 95 % intervals; a term that the record does not "
        "tell from zero has a limit alone."
    )
    yield TextTable("Terms of the noise", headings, rows, note)


def _term_in_words(term: NoiseTerm) -> str:
    if term.value is None:
        return f"at most {two_digits(term.high)}" if term.high else "none"
    return f"{two_digits(term.value)} ({two_digits(term.low)} to {two_digits(term.high)})"


def _per_time(term: str) -> str:
    return {1.0: "·s", 0.5: "·√s", 0.0: "unit", -0.5: "/√s", -1.0: "/s"}[POWER_OF_TIME[term]]


def _allan_plot(name: str, static: Mapping[str, StaticAxis]) -> Iterator[Plot]:
    by_unit = sorted({one.unit for one in static.values()})
    for unit in by_unit:
        curves = tuple(
            Curve(axis, np.array(one.tau_s), np.array(one.allan_deviation))
            for axis, one in static.items()
            if one.unit == unit
        )
        yield Plot(
            f"{name}-allan", "Allan deviation", "Overlapping estimator over the averaging time.", "averaging time (s)",
            f"deviation ({printed(unit)})", curves, is_logarithmic=True,
        )  # fmt: skip


KIND = LongRest()
