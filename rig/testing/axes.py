"""Laws of axes: they go to angles inside their limits, tell the truth about it and stop; some turn on and on."""

from collections.abc import Mapping

from rig.abilities.abilities import Axis, RateAxis
from rig.abilities.rates import measured_rate
from rig.clock import Clock
from rig.errors import RigError
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all
from rig.testing.law import expect, expect_near, expect_refusal

REST_S = 5.0


def keep_axis_promises(
    axis: Axis,
    clock: Clock,
    *,
    target_deg: float,
    beyond_deg: float,
    close_deg: float,
    others: Mapping[str, Axis],
    far_deg: float | None = None,
) -> None:
    """Identity, home before moves, arrival, limits, a stop that is harmless at rest and ends a move.

    The home is wherever the machine has it: the second search ends where the first did. ``far_deg``: another place
    inside the limits, by default on the other side of 0. ``others``: axes of the same controller, which must stay where
    they are.
    """
    expect(axis.identify() == axis.identify(), f"{axis.name}: it says of itself one thing, then another")
    if not axis.state().is_homed:
        expect_refusal(lambda: axis.start_move(target_deg), f"{axis.name}: a move without a home", "not homed")
    else:
        _keep_home_that_is_reported(axis, clock, target_deg)
    home_deg = home_and_arrive(axis, clock, clock.sleep)
    expect_rest_at_home(axis, home_deg)
    before_deg = {name: other.state().position_deg for name, other in others.items()}
    arrived_deg = move_and_arrive(axis, target_deg, clock, clock.sleep)
    expect_near(arrived_deg, target_deg, close_deg, f"{axis.name}: arrival")
    for name, other in others.items():
        expect_near(other.state().position_deg, before_deg[name], close_deg, f"{name}: it moved with {axis.name}")
    rested_deg = axis.state().position_deg
    axis.stop()
    state = axis.state()
    expect(state.is_seated, f"{axis.name}: a stop at rest unseated it")
    expect(state.position_deg == rested_deg, f"{axis.name}: a stop at rest moved it to {state.position_deg:g}°")
    for wrong_deg in (beyond_deg, float("nan"), float("inf")):
        for request in (axis.check_target, axis.start_move):
            expect_refusal(lambda request=request, wrong=wrong_deg: request(wrong), f"{axis.name}: {wrong_deg}°")  # type: ignore[misc]
    expect(axis.state().position_deg == rested_deg, f"{axis.name}: a refused target moved it")
    _keep_stop(axis, clock, target_deg, -target_deg if far_deg is None else far_deg)
    again_deg = home_and_arrive(axis, clock, clock.sleep)
    expect_near(again_deg, home_deg, close_deg, f"{axis.name}: a second home is another place")


def _keep_home_that_is_reported(axis: Axis, clock: Clock, target_deg: float) -> None:
    """Move an axis that says that it is homed before anybody homed it: it must have been true."""
    try:
        move_and_arrive(axis, target_deg, clock, clock.sleep)
    except RigError as error:
        raise AssertionError(f"{axis.name}: it says that it is homed, but does not move: {error}") from error


def expect_rest_at_home(axis: Axis, home_deg: float) -> None:
    """Require that an axis behind its search is homed, at rest, seated and where it said it is."""
    state = axis.state()
    rests = state.is_homed and not state.is_moving and state.is_seated
    expect(rests and state.position_deg == home_deg, f"{axis.name}: behind its home it does not rest there: {state}")


def _keep_stop(axis: Axis, clock: Clock, from_deg: float, to_deg: float) -> None:
    """Stop a move on its way; it must stay there."""
    axis.start_move(to_deg)
    clock.sleep(min(2.0, 0.5 * abs(to_deg - from_deg) / axis.speed_dps))
    stop_all({axis.name: axis}, clock)
    state = axis.state()
    expect(not state.is_moving, f"{axis.name}: it moves after a stop")
    expect(abs(state.position_deg - to_deg) > axis.arrival_tolerance_deg, f"{axis.name}: the stop let it arrive")
    clock.sleep(REST_S)
    expect(axis.state().position_deg == state.position_deg, f"{axis.name}: it goes on after a stop")


def keep_rate_promises(axis: RateAxis, clock: Clock, rates_dps: tuple[float, float] = (25.0, -40.0)) -> None:
    """Refuse rates that it has not; turn at others, measured by looks at angle and clock, beyond a turn; stop.

    The axis must be homed.
    """
    for wrong_dps in (0.0, float("nan"), float("inf"), 1.01 * axis.top_rate_dps, -1.01 * axis.top_rate_dps):
        for request in (axis.check_rate, axis.start_rate):
            expect_refusal(
                lambda request=request, wrong=wrong_dps: request(wrong),  # type: ignore[misc]
                f"{axis.name}: {wrong_dps} °/s",
                "nothing moved",
            )
    for rate_dps in rates_dps:  # the second from within the first: both senses, no stop between
        axis.start_rate(rate_dps)
        clock.sleep(4.0)  # a change of 65 deg/s at 20 deg/s² takes 3.25 s
        expect(axis.state().is_moving, f"{axis.name}: it turns and says that it rests")
        first = axis.turn_look(clock)
        clock.sleep(15.0)
        measured = measured_rate(first, axis.turn_look(clock))
        limit_dps = 3.0 * measured.uncertainty_dps + 0.01
        expect_near(measured.rate_dps, rate_dps, limit_dps, f"{axis.name}: rate")
        expect(abs(measured.turned_deg) > 360.0, f"{axis.name}: its angle does not go on beyond a turn")
        expect(first.uncertainty_s >= 0.0, f"{axis.name}: a look has a negative uncertainty")
    stop_all({axis.name: axis}, clock)  # type: ignore[dict-item]
    rested_deg = axis.turn_look(clock).angle_deg
    clock.sleep(REST_S)
    expect(axis.turn_look(clock).angle_deg == rested_deg, f"{axis.name}: it turns on after a stop")
    expect(not axis.state().is_moving, f"{axis.name}: it rests and says that it moves")
