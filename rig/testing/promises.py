"""One device of an open rig, held to the laws of its ability."""

from typing import cast

from rig.abilities.abilities import Axis, RateAxis
from rig.abilities.targets import allowed_range_deg, nearest_targets_deg
from rig.assembly.open_rig import Rig
from rig.description.device_settings import AxisSettings
from rig.motion.move import home_and_arrive
from rig.testing.axes import keep_axis_promises, keep_rate_promises
from rig.testing.dangers import keep_axis_safe
from rig.testing.instruments import (
    keep_environment_promises,
    keep_field_promises,
    keep_readout_promises,
    keep_stream_promises,
)

CLOSE_DEG = 0.1
"""No driver resolves worse: a servo's pulse has steps of a quarter microsecond."""
FARTHEST_DEG = 45.0
"""From the middle: an axis of limits ± 180 goes to + 45 and - 45."""
WARM_S = 60.0
"""A twin's air follows its set point at 0.05 °C/s."""


def keep_promises(rig: Rig, key: str, *, sets_speed: bool = True) -> None:
    """Hold the device at ``key``, such as ``axes.pitch``, to its laws. Everything moves: it must be a twin.

    An axis whose twin is in this process is also held to the laws of danger, on twins of its own; ``sets_speed`` is
    False for a machine that has no command for its speed.

    Raises: AssertionError with what was found; whatever a law did not expect.
    """
    table, _, name = key.partition(".")
    if table == "axes":
        _keep_axis(rig.axes[name], rig, sets_speed=sets_speed)
    elif table == "readouts":
        keep_readout_promises(rig.readouts[name], rig.clock, rig.description.readouts[name])
    elif table == "environment":
        limits_degc = rig.description.environment[name].limits_degc
        air, clock = rig.environments[name], rig.clock
        now_degc = round(air.temperature_degc())
        holds_degc = (now_degc + 1.5, now_degc - 7.5)
        keep_environment_promises(air, clock, limits_degc=limits_degc, holds_degc=holds_degc, warm_s=WARM_S)
    elif table == "streams":
        keep_stream_promises(rig.streams[name], rig.clock)
    elif table == "field":
        keep_field_promises(rig.fields[name], rig.clock, 0.5 * sum(rig.fields[name].limits_ut))
    else:
        raise AssertionError(f"{key}: no table {table!r} (allowed: axes, readouts, environment, streams, field)")


def _keep_axis(axis: Axis, rig: Rig, *, sets_speed: bool) -> None:
    settings = rig.description.axes[axis.name]
    ends_deg = _two_targets(settings)
    others = {name: other for name, other in rig.axes.items() if other is not axis}
    keep_axis_promises(
        axis,
        rig.clock,
        target_deg=ends_deg[0],
        far_deg=ends_deg[1],
        beyond_deg=settings.limits_deg[1] + 1.0,
        close_deg=CLOSE_DEG,
        others=others,
    )
    if settings.turning == "revolves":
        home_and_arrive(axis, rig.clock, rig.clock.sleep)
        keep_rate_promises(cast(RateAxis, axis), rig.clock)
    if rig.description.uses_twins:  # in memory, once: no port makes a difference to these
        keep_axis_safe(rig.description, axis.name, ends_deg, CLOSE_DEG, sets_speed=sets_speed)


def _two_targets(settings: AxisSettings) -> tuple[float, float]:
    """Return two places where the axis may stop, a quarter of its range but at most 90 degrees apart."""
    low_deg, high_deg = allowed_range_deg(settings)
    middle_deg, reach_deg = 0.5 * (low_deg + high_deg), min(0.125 * (high_deg - low_deg), FARTHEST_DEG)
    first_deg = nearest_targets_deg(settings, middle_deg + reach_deg)[-1]
    return first_deg, nearest_targets_deg(settings, middle_deg - reach_deg)[0]
