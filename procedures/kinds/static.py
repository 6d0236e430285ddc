"""``static``: at rest for long: offset, Allan deviation, and whether the drift is small enough for the use."""

from collections.abc import Iterator, Mapping, Sequence
from math import hypot, sqrt

import numpy as np

from ams.inputs.shared_errors import leaking_v
from ams.observations import Observations
from ams.rounding import two_digits, with_uncertainty
from ams.statistics.noise import AllanDeviation, allan_deviation, read_coefficients
from ams.statistics.noise_terms import POWER_OF_TIME, TERMS, WORDS, NoiseTerm, noise_terms
from ams.units import printed
from procedures.description.kind_tables import Static
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Forecast, Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.kinds.section import Curve, Plot, SensorPage, TextTable, recorded_tables, section_of
from procedures.kinds.sensor_parts import COVERAGE, PARTS, SensorPart, checked, forecast_of
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


class LongRest(PointKind):
    """One attitude, one long recording."""

    name = "static"
    table: tuple[str, type[StrictTable]] | None = ("static", Static)
    models: tuple[str, ...] = ("linear",)

    def measures(self, model: str) -> tuple[str, ...]:
        return "acceleration", "rate", "field"

    def points(self, request: PlanRequest) -> Sequence[Point]:
        rig, procedure = request.rig, request.procedure
        static = procedure.table_of(Static)
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
        _check_parts(request, static.parts)
        return [({name: angle for name, angle in wanted.items() if name in rig.axes}, Rest(static.duration_s), None)]

    def key_of_angle(self, axis: str) -> Key:
        return "static", f"{axis}_deg"

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        static = _table_of(plan)
        of_tables = (
            forecast_of(f"{sensor} ({name})", PARTS[name], static.use_s, static.allowed_deg)
            for sensor, name in static.parts.items()
        )
        advice = [sentence for sentence in of_tables if sentence is not None]
        if static.duration_s < 4.0 * static.use_s:
            advice.append(
                f"a rest of {static.duration_s:g} s says little about a use of {static.use_s:g} s: the verdict rests "
                "on a handful of neighbouring means; rest for ten times as long"
            )
        return Forecast(advice=tuple(advice), judged_by="static.allowed_deg")

    def solve(self, item: SensorRows) -> SolvedSensor:
        rows = item.at_declared()
        seen = observed(item)
        axes = {str(axis): _static_axis(item, channel, rows, seen) for axis, channel in item.sensor.channels.items()}
        return SolvedSensor(item.name, seen, None, None, static=axes)

    def section(self, record: RunRecord, solved: SolvedSensor) -> SensorPage | None:
        if not solved.static:
            return section_of(record, solved)
        name, axes = solved.name, solved.static
        beyond = tuple(f"{name} {axis}: {line.verdict}" for axis, line in axes.items() if line.holds is False)
        return SensorPage(
            _static_result(solved.name, solved.static),
            beyond,
            (
                _static_table(solved.static),
                *_terms_tables(solved.static),
                *_part_tables(solved.static),
                *recorded_tables(record.dwells),
            ),
            tuple(_allan_plot(solved.name, solved.static)),
        )


def _table_of(plan: Plan) -> Static:
    static = plan.kind_table("static", Static)
    assert static is not None, "a plan of this kind has its table, those stored before as well"
    return static


def _static_axis(item: SensorRows, channel: str, rows: list[DwellRecord], seen: Observations) -> StaticAxis:
    """Return what the longest look says of an axis.

    The Allan deviation at the time of use says how far two neighbouring means lie apart.
    """
    sensor, rig, static = item.sensor, item.rig, _table_of(item.plan)
    reading = rows[0].readings[channel]
    allan = allan_deviation(reading.samples, reading.interval_s).from_tau(static.shortest_s)
    coefficients = read_coefficients(allan)
    count = reading.samples.size
    factor = min(max(round(static.use_s / reading.interval_s), 1), count // 2)
    at_use = float(allan_deviation(reading.samples, reading.interval_s, [factor]).deviation[0])
    axis = next(str(axis) for axis, name in sensor.channels.items() if name == channel)
    part_name = static.parts.get(item.name, "")
    part = PARTS.get(part_name)
    per_unit = _per_unit(sensor, axis, reading.unit, part)
    drift_deg = _drift_deg(sensor, at_use, static.use_s, per_unit)
    means = [row.readings[channel].mean for row in rows]
    mean = float(np.mean(means))
    scatter = float(np.std(means, ddof=1) / sqrt(len(means))) if len(means) > 1 else float(allan.deviation[-1])
    return StaticAxis(
        unit=reading.unit,
        mean=mean,
        mean_uncertainty=hypot(scatter, *_of_the_meter(rig, sensor, channel, mean, seen)),
        tau_s=tuple(allan.tau_s.tolist()),
        allan_deviation=tuple(allan.deviation.tolist()),
        random_walk_per_sqrt_s=coefficients.random_walk_per_sqrt_s,
        bias_instability=coefficients.bias_instability,
        is_bottom_reached=coefficients.is_bottom_reached,
        use_s=static.use_s,
        allowed_deg=static.allowed_deg,
        drift_deg=drift_deg,
        verdict=_verdict(drift_deg, static.use_s, static.allowed_deg),
        noise_terms=_terms(allan, count, reading.interval_s),
        part="" if part is None else f"{part_name} ({part.source})",
        beside_table=()
        if part is None or per_unit is None
        else checked(part, coefficients.random_walk_per_sqrt_s, at_use, per_unit),
    )


def _terms(allan: AllanDeviation, count: int, interval_s: float) -> tuple[NoiseTerm, ...]:
    """Return the five terms where there are averaging times enough for them, and anything to be seen at all."""
    if allan.tau_s.size <= len(TERMS) or not allan.deviation.all():
        return ()
    return noise_terms(allan, count, interval_s)


def _check_parts(request: PlanRequest, parts: Mapping[str, str]) -> None:
    """Refuse a part that no table has, of a sensor that is not there or measures something else. Raises: PlanError."""
    for name, part in parts.items():
        sensor, known = request.sensors.get(name), PARTS.get(part)
        where = ("static", "parts")
        if sensor is None:
            raise request.procedure.error(where, f"no sensor {name}; allowed are {', '.join(request.sensors)}")
        if known is None:
            raise request.procedure.error(where, f"{name}: got part {part!r}; allowed are {', '.join(PARTS)}")
        if known.measures != sensor.measures:
            raise request.procedure.error(
                where, f"{name}: {part} measures {known.measures}, the sensor {sensor.measures}; name another part"
            )


def _of_the_meter(
    rig: RigDescription, sensor: Sensor, channel: str, mean: float, seen: Observations
) -> Iterator[float]:
    """Yield standard uncertainties of a mean by what the rig declares of the chain that reads it."""
    axis = next(str(axis) for axis, name in sensor.channels.items() if name == channel)
    for error in shared_errors(rig, sensor, counts_shift=False)[axis]:
        if error.effect == "reading":
            yield error.standard_uncertainty
        elif error.effect == "gain":
            yield error.standard_uncertainty * mean
        elif error.effect == "crosstalk":
            yield from (error.standard_uncertainty * leaking_v(error, axis, seen).mean(axis=0)).tolist()


def _per_unit(sensor: Sensor, axis: str, unit: str, part: SensorPart | None) -> float | None:
    """Return the reading per g or per °/s; None where nothing says it."""
    if unit == sensor.sensed_unit and sensor.measures != "field":
        return 1.0
    declared = abs(sensor.nominal_v_per_g(axis)) if sensor.measures == "acceleration" and unit == "v" else 0.0
    return declared or (None if part is None else part.scale.get(unit))


def _drift_deg(sensor: Sensor, deviation: float, use_s: float, per_unit: float | None) -> float | None:
    """Zeroed by the mean over as long as it is used: √2 of the deviation at that time, integrated for a rate."""
    if per_unit is None:
        return None
    error = COVERAGE * sqrt(2.0) * deviation / per_unit
    return error * use_s if sensor.measures == "rate" else float(np.rad2deg(error))


def _verdict(drift_deg: float | None, use_s: float, allowed_deg: float) -> str:
    if drift_deg is None:
        return "no verdict: nothing says how many degrees its reading is"
    relation = "within" if drift_deg <= allowed_deg else "beyond"
    return f"drifts by {drift_deg:.3g}° (k = 2) in {use_s:g} s, {relation} the allowed ±{allowed_deg:g}°"


def _static_result(name: str, static: Mapping[str, StaticAxis]) -> str:
    """Say which axes hold what is allowed."""
    line = next(iter(static.values()))
    words = {True: f"within ±{line.allowed_deg:g}°", False: f"beyond ±{line.allowed_deg:g}°", None: "of unknown size"}
    parts = [
        f"{', '.join(axis for axis, each in static.items() if each.holds is held)} {word}"
        for held, word in words.items()
        if any(each.holds is held for each in static.values())
    ]
    return f"{name}: drift in {line.use_s:g} s {'; '.join(parts)}"


def _static_table(static: Mapping[str, StaticAxis]) -> TextTable:
    rows = tuple(
        (
            axis,
            printed(line.unit),
            *with_uncertainty(line.mean, line.mean_uncertainty),
            two_digits(line.random_walk_per_sqrt_s),
            f"{two_digits(line.bias_instability)}{'' if line.is_bottom_reached else ' at most'}",
            line.verdict,
        )
        for axis, line in static.items()
    )
    headings = ("axis", "unit", "offset", "u", "random walk (·√s)", "bias instability", "verdict")
    note = "Zeroed by the mean over as long as it is used: √2 of the Allan deviation at that time, expanded with k = 2."
    return TextTable("At rest", headings, rows, note)


def _terms_tables(static: Mapping[str, StaticAxis]) -> Iterator[TextTable]:
    """Yield the table of the five terms, of the axes that rested long enough for them."""
    rows = tuple(
        (axis, printed(line.unit), *(_term_in_words(term) for term in line.noise_terms))
        for axis, line in static.items()
        if line.noise_terms
    )
    if not rows:
        return
    headings = ("axis", "unit", *(f"{WORDS[term]} ({_per_time(term)})" for term in TERMS))
    note = (
        "σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3 + R²τ²/2, with 95 % intervals; a term that the record does not "
        "tell from zero has a limit alone."
    )
    yield TextTable("Terms of the noise", headings, rows, note)


def _part_tables(static: Mapping[str, StaticAxis]) -> Iterator[TextTable]:
    """Yield what a table of the reports says of the part beside what it showed."""
    rows = tuple((axis, *line.beside_table) for axis, line in static.items() if line.beside_table)
    if rows:
        headings = ("axis", "what", "stated", "shown", "")
        note = "White noise is a one-sided density, √2 of the random walk; a drift is expanded with k = 2."
        yield TextTable(f"Beside {next(iter(static.values())).part}", headings, rows, note)


def _term_in_words(term: NoiseTerm) -> str:
    if term.value is None:
        return f"at most {two_digits(term.high)}" if term.high else "none"
    return f"{two_digits(term.value)} ({two_digits(term.low)} to {two_digits(term.high)})"


def _per_time(term: str) -> str:
    return {1.0: "·s", 0.5: "·√s", 0.0: "unit", -0.5: "/√s", -1.0: "/s"}[POWER_OF_TIME[term]]


def _allan_plot(name: str, static: Mapping[str, StaticAxis]) -> Iterator[Plot]:
    by_unit = sorted({line.unit for line in static.values()})
    for unit in by_unit:
        curves = tuple(
            Curve(axis, np.array(line.tau_s), np.array(line.allan_deviation))
            for axis, line in static.items()
            if line.unit == unit
        )
        yield Plot(
            f"{name}-allan", "Allan deviation", "Overlapping estimator over the averaging time.", "averaging time (s)",
            f"deviation ({printed(unit)})", curves, is_logarithmic=True,
        )  # fmt: skip


KIND = LongRest()
