"""Which finite steps an axis can be jogged by: what its machine resolves, what its limits hold."""

from collections.abc import Sequence
from fractions import Fraction

from rig.abilities.abilities import Axis
from rig.description.device_settings import AxisSettings

STEPS_DEG = (0.0001, 0.0005, 0.001, 0.005, 0.01, 0.05, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0)
_ROUNDING = 1e-9


def resolution_deg(settings: AxisSettings) -> float:
    """Return the smallest step that the machine has by its data sheet; 0 where the file tells none."""
    steps_deg = (getattr(settings, "microstep_deg", None), getattr(settings, "step_deg", None), settings.increment_deg)
    return max(float(step_deg) for step_deg in steps_deg if step_deg is not None)


def steps_deg(axis: Axis, settings: AxisSettings) -> tuple[float, ...]:
    """Return steps from 0.0001 to 90 deg that end where the axis can stop and that it can tell from standing still.

    Never empty: where none of the round ones fits, it is the machine's own.
    """
    finest_deg = max(resolution_deg(settings), 2.0 * axis.arrival_tolerance_deg)
    span_deg = axis.limits_deg[1] - axis.limits_deg[0]
    able = [step for step in STEPS_DEG if finest_deg <= step <= span_deg and _fits(step, axis.increment_deg)]
    return tuple(able) or (axis.increment_deg or finest_deg,)


def nearest_step_deg(steps: Sequence[float], wanted_deg: float) -> float:
    """Return the largest step that is not above the wanted one, else the smallest."""
    return max((step for step in steps if step <= wanted_deg * (1.0 + _ROUNDING)), default=min(steps))


def _fits(step_deg: float, increment_deg: float) -> bool:
    """Return whether a step is a multiple of the increment, as decimal numbers."""
    return increment_deg == 0.0 or Fraction(str(step_deg)) % Fraction(str(increment_deg)) == 0
