"""What to expect of a schedule of points: turns, rests, fields.

The uncertainty is that of the solution (:mod:`procedures.solution.expected_points`), from the twin's noise where there
is a twin; at the bench nothing is guessed.
"""

from collections.abc import Iterable, Iterator, Mapping

from ams.analysis.diagnostics.facts import time_confounded
from ams.findings import significant_texts
from ams.units import printed
from procedures.kinds.expected import ExpectedAxis
from procedures.kinds.kind import Forecast
from procedures.plan.channels import temperature_source
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell, Follow, Turn
from procedures.plan.undeclared import undeclared_of_plan
from procedures.solution.expected_points import Solver, expected_points, planned_degc
from procedures.solution.foreseen import use_remarks
from procedures.solution.temperature_of_use import use_warnings
from rig.description.rig_file import RigDescription, Sensor

FEWEST_REPLICATIONS = 4
"""Below, intervals rest on so few degrees of freedom that they are wide."""


def forecast_of_points(rig: RigDescription, plan: Plan, solver: Solver | None) -> Forecast:
    """Judge a schedule of points beforehand. ``solver``: None where its rows cannot be told before it has run."""
    expected: list[ExpectedAxis] = []
    if solver is not None:
        for name, sensor in plan.sensors.items():
            expected += _expected(rig, plan, name, sensor, solver)
    in_order = () if solver is None else tuple(_of_order(rig.all_on_twins(), plan, solver))
    remarks = [*undeclared_of_plan(rig, plan).remarks]
    if plan.environment is None:
        remarks += use_remarks(rig, plan.solve, plan.sensors)
    return Forecast(
        tuple(expected),
        (*_advice(plan), *_unguarded(rig, plan)),
        turns=_turns(plan),
        reservations=(*_of_use(rig, plan), *in_order),
        remarks=tuple(remarks),
    )


def _of_use(rig: RigDescription, plan: Plan) -> tuple[str, ...]:
    """Return the reservations about the range of use, what all sensors share once."""
    return tuple(
        _once(
            plan,
            {
                name: use_warnings(
                    sensor, planned_degc(rig, plan, sensor), is_recorded=temperature_source(rig, sensor) is not None
                )
                for name, sensor in plan.sensors.items()
            },
        )
    )


def _of_order(twins: RigDescription, plan: Plan, solver: Solver) -> Iterator[str]:
    """Yield what the report will say of the order of the points; the twins of any rig tell it."""
    yield from _once(
        plan,
        {
            name: dict.fromkeys(
                text
                for found in expected_points(twins, plan, name, sensor, solver).values()
                for text in significant_texts(time_confounded(found.solution.points))
            )
            for name, sensor in plan.sensors.items()
        },
    )


def _once(plan: Plan, texts: Mapping[str, Iterable[str]]) -> Iterator[str]:
    """Yield what is said of the sensors, by their names, what all of them share once."""
    said: dict[str, list[str]] = {}
    for name, of_sensor in texts.items():
        for text in of_sensor:
            said.setdefault(text, []).append(name)
    for text, names in said.items():
        yield text if len(names) == len(plan.sensors) else f"{', '.join(names)}: {text}"


def _turns(plan: Plan) -> dict[str, float]:
    turns: dict[str, float] = {}
    for dwell in plan.dwells:
        if isinstance(dwell.motion, Turn) and dwell.motion.sweep_deg is None:
            axis = dwell.motion.turned_axis
            turns[axis] = max(turns.get(axis, 0.0), float(dwell.motion.revolutions))
    return turns


def _led_by_a_rate(dwell: Dwell) -> Iterable[str]:
    """Return the axes whose last command is a rate while the dwell lasts."""
    match dwell.motion:
        case Turn(sweep_deg=None):
            return (dwell.motion.turned_axis,)
        case Follow():
            return dwell.motion.span_deg
    return ()


def _unguarded(rig: RigDescription, plan: Plan) -> Iterator[str]:
    """Yield the axes that turn on and on and that nothing stops when the computer dies; a sweep ends at its target."""
    turned = {name for dwell in plan.dwells for name in _led_by_a_rate(dwell)}
    for name in plan.axes:
        if name in turned and not rig.axes[name].stops_without_computer:
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


def _expected(rig: RigDescription, plan: Plan, name: str, sensor: Sensor, solver: Solver) -> Iterator[ExpectedAxis]:
    known = rig.channel_units()
    units = {str(axis): known.get(channel, "v") for axis, channel in sensor.channels.items()}
    for axis, found in expected_points(rig, plan, name, sensor, solver).items():
        stated = [item for item in found.solution.parameters if item.standard_uncertainty != 0.0]
        yield ExpectedAxis(
            sensor=name,
            axis=axis,
            noise_v=found.noise,
            noise_source=f"the twin's {found.truth.noise:g} {printed(units[axis])} a reading",
            coning_deg=found.truth.coning_deg,
            standard_uncertainty={item.name: item.standard_uncertainty for item in stated},
            half_width_95={
                item.name: None if item.interval_95 is None else 0.5 * (item.interval_95[1] - item.interval_95[0])
                for item in stated
            },
        )
