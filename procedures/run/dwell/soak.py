"""Bring an environment to a plateau and keep it there: the time counts only while the temperature is in its band."""

from collections.abc import Callable

from procedures.plan.steps import Soak
from rig.abilities.abilities import Environment, Wait
from rig.abilities.chamber_alarms import alarm_clause
from rig.clock import Clock
from rig.errors import ChamberFault

_LOOKS, _SHORTEST_LOOK_S, _LONGEST_LOOK_S = 60, 1.0, 30.0
_LIMIT_S = 6.0 * 3600.0
"""Longest way into the band; a soak itself may take as long as it is asked to."""


def soak(
    environment: Environment,
    step: Soak,
    clock: Clock,
    wait: Wait,
    tell: Callable[[float, float], None] = lambda _degc, _left_s: None,
) -> float:
    """Hold the setpoint until the band was kept for ``soak_s``; returns the last temperature, degC.

    ``tell`` hears at every look how warm it is and how many seconds are left at the least.

    Raises: ChamberFault where the band is not reached, or lost for so long, within six hours; WaitEnded.
    """
    environment.hold(step.setpoint_degc)
    look_s = min(max(step.soak_s / _LOOKS, _SHORTEST_LOOK_S), _LONGEST_LOOK_S)
    inside_since_s, last_inside_s = None, clock.monotonic_s()
    while True:
        degc, now_s = environment.temperature_degc(), clock.monotonic_s()
        if abs(degc - step.setpoint_degc) <= step.band_degc:
            inside_since_s, last_inside_s = now_s if inside_since_s is None else inside_since_s, now_s
            if now_s - inside_since_s >= step.soak_s:
                return degc
        else:
            inside_since_s = None
            if now_s - last_inside_s > _LIMIT_S:
                raise ChamberFault(
                    f"{step.environment}: at {degc:.2f} °C, wanted {step.setpoint_degc:g} ± {step.band_degc:g} °C; "
                    f"not reached in {_LIMIT_S / 3600.0:g} h; it goes on holding its"
                    f" setpoint{alarm_clause(environment)}; look at the chamber"
                )
        tell(degc, step.soak_s - (0.0 if inside_since_s is None else now_s - inside_since_s))
        wait(look_s)
