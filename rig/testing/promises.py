"""One device of an open rig, held to the laws of its ability."""

from typing import cast

from rig.assembly.open_rig import Rig
from rig.devices.abilities import Axis, RateAxis
from rig.motion.move import home_and_arrive
from rig.testing.axes import keep_axis_promises, keep_rate_promises
from rig.testing.instruments import (
    keep_environment_promises,
    keep_field_promises,
    keep_readout_promises,
    keep_stream_promises,
)

CLOSE_DEG = 0.1
"""No driver resolves worse: a servo's pulse has steps of a quarter microsecond."""
WARM_S = 60.0
"""A twin's air follows its set point at 0.05 °C/s."""


def keep_promises(rig: Rig, key: str) -> None:
    """Hold the device at ``key``, such as ``axes.pitch``, to its laws. Everything moves: it must be a twin.

    Raises: AssertionError with what was found; whatever a law did not expect.
    """
    table, _, name = key.partition(".")
    if table == "axes":
        _keep_axis(rig.axes[name], rig)
    elif table == "readouts":
        keep_readout_promises(rig.readouts[name], rig.clock)
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


def _keep_axis(axis: Axis, rig: Rig) -> None:
    low_deg, high_deg = axis.limits_deg
    step_deg = axis.increment_deg
    reach_deg = 0.25 * min(-low_deg, high_deg)
    target_deg = max(1, round(reach_deg / step_deg)) * step_deg if step_deg else reach_deg
    others = {name: other for name, other in rig.axes.items() if other is not axis}
    keep_axis_promises(
        axis, rig.clock, target_deg=target_deg, beyond_deg=high_deg + 1.0, close_deg=CLOSE_DEG, others=others
    )
    if rig.description.axes[axis.name].turning == "revolves":
        home_and_arrive(axis, rig.clock, rig.clock.sleep)
        keep_rate_promises(cast(RateAxis, axis), rig.clock)
