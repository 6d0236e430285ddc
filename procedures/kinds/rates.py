"""``rates``: gyros at constant rates, one axis after the other, in both senses, between two rests."""

from collections.abc import Sequence
from math import ceil, floor

from ams.frames import ANGLES
from ams.models.registry import names_by_option, names_of_rates, senses_rates, takes_levels
from procedures.description.kind_tables import Rates
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.plan.plan import Plan
from procedures.plan.points import Point
from procedures.plan.step_times import SWEEP_MARGIN
from procedures.plan.steps import Rest, Turn
from procedures.solution.by_model import observed, solve_by_model
from procedures.solution.expected_points import Solver, by_lines, by_model
from procedures.solution.lines import solve_lines
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.rig_file import RigDescription
from rig.errors import RequestRefused
from rig.toml_file import StrictTable

SWEPT_MARGIN_DEG = 1.0
"""Sweeps keep so far from the limits."""
LATENCY_S, LATENCY_SAMPLES = 1.0, 2.0
"""Of a sweep, lost before its first sample is read."""
SWEEP_READ = 1.0 - 2.0 * SWEEP_MARGIN
"""Of a sweep, between the margins at its ends."""


class ConstantRates(PointKind):
    """Whole revolutions, or sweeps between the limits of an axis."""

    name = "rates"
    table: tuple[str, type[StrictTable]] | None = ("rates", Rates)

    @property
    def models(self) -> tuple[str, ...]:
        return (*names_of_rates(), *filter(takes_levels, names_by_option()))

    def measures(self, model: str) -> tuple[str, ...]:
        return ("rate",)

    def points(self, request: PlanRequest) -> Sequence[Point]:
        rig, procedure, channels = request.rig, request.procedure, request.channels
        rates = procedure.table_of(Rates)
        assert rates is not None
        missing = [name for name in ANGLES if name not in rates.by_axis]
        if senses_rates(procedure.solve.model) and missing:
            raise procedure.error(
                ("rates",),
                f'the model "{procedure.solve.model}" needs turns about three axes, {" and ".join(missing)} stand '
                "still: the sensitivity along their directions cannot be determined; give rates for them, or use "
                'solve.model = "linear"',
            )
        rest: Point = ({}, Rest(rates.dwell_s), None)
        points: list[Point] = [rest] if rates.at_rest else []
        for axis, values in rates.by_axis.items():
            for rate_dps in (sign * value for value in values for sign in (1.0, -1.0)):
                turn = _turn(rig, procedure, rates, axis, rate_dps, channels)
                start_deg = 0.0 if turn.sweep_deg is None else turn.sweep_deg[0]
                points.append(({axis: start_deg}, turn, None))
        return [*points, rest] if rates.at_rest else points

    def key_of_angle(self, axis: str) -> Key:
        return "rates", f"{axis}_dps"

    def forecast_solver(self, plan: Plan) -> Solver:
        return by_lines if self.solves_lines(plan.solve.model, plan.design.kind) else by_model

    def solve(self, item: SensorRows) -> SolvedSensor:
        observations = observed(item)
        if self.solves_lines(item.plan.solve.model, item.plan.design.kind):
            return solve_lines(item, observations)
        return solve_by_model(item, observations)


def _turn(
    rig: RigDescription,
    procedure: ProcedureDescription,
    rates: Rates,
    axis: str,
    rate_dps: float,
    channels: Sequence[str],
) -> Turn:
    key = ("rates", f"{axis}_dps")
    if axis not in rig.axes:
        raise procedure.error(key, f"the rig has no axis {axis} (it has: {', '.join(rig.axes)})")
    settings = rig.axes[axis]
    try:
        settings.refuse_rate(axis, rate_dps)
    except RequestRefused as error:
        raise procedure.error(key, str(error)) from None
    if settings.turning == "sweeps":
        return _sweeps(rig, procedure, rates, axis, rate_dps, channels)
    revolutions = ceil(rates.dwell_s * abs(rate_dps) / 360.0 - 1e-9)
    low, high = settings.limits_deg
    if high - low < 360.0:
        raise procedure.error(
            key,
            f"{axis} turns whole revolutions, allowed are {low:g}° to {high:g}° (axes.{axis}.limits_deg); nothing "
            "moved; leave this axis out, or give it limits of a whole circle, such as -180° to 180°",
        )
    if settings.wrap_turns is not None and revolutions + 1 > settings.wrap_turns:
        raise procedure.error(
            key,
            f"{rates.dwell_s:g} s at {rate_dps:g} °/s are {revolutions} revolutions and the ramps, the cables bear "
            f"{settings.wrap_turns:g} (axes.{axis}.wrap_turns); nothing moved; shorten dwell_s or turn slower",
        )
    seconds = revolutions * 360.0 / abs(rate_dps)
    return Turn(axis, rate_dps, seconds, revolutions, None, 0, rates.tolerance)


def _sweeps(
    rig: RigDescription,
    procedure: ProcedureDescription,
    rates: Rates,
    axis: str,
    rate_dps: float,
    channels: Sequence[str],
) -> Turn:
    """Return a turn of as many sweeps in one sense as the reading takes."""
    key = ("rates", f"{axis}_dps")
    voltages = [channel for channel in channels if channel.partition(".")[0] in rig.readouts]
    if voltages:
        raise procedure.error(key, f"{axis} sweeps between its limits: {voltages[0]} cannot be read so; use a stream")
    slowest_hz = min(rig.streams[channel.partition(".")[0]].samples_hz() for channel in channels)
    low, high = rig.axes[axis].limits_deg
    ends = (low + SWEPT_MARGIN_DEG, high - SWEPT_MARGIN_DEG)
    inside_s = SWEEP_READ * (ends[1] - ends[0]) / abs(rate_dps) - LATENCY_S - LATENCY_SAMPLES / slowest_hz
    samples = floor(inside_s * slowest_hz)
    if samples < 2:
        raise procedure.error(
            key, f"a sweep of {axis} at {rate_dps:g} °/s is over in {inside_s:.3g} s, before two samples were read; "
            "turn slower or stream faster",
        )  # fmt: skip
    sweeps = ceil(rates.dwell_s * slowest_hz / samples - 1e-9)
    each = ceil(rates.dwell_s * slowest_hz / sweeps - 1e-9)
    sweep = ends if rate_dps > 0.0 else (ends[1], ends[0])
    return Turn(axis, rate_dps, sweeps * each / slowest_hz, 0, sweep, sweeps, rates.tolerance)


KIND = ConstantRates()
