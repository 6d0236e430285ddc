"""Numbers as pages and screens print them beside values with their uncertainty, which :mod:`ams.rounding` prints."""

import math
from collections.abc import Mapping

from ams.units import ARCSEC_PER_RAD, printed


def finite(value: float | None) -> float | None:
    """Return the value as JSON may have it, which knows no NaN: what is not finite is null."""
    return None if value is None or not math.isfinite(value) else value


def three_digits(value: float) -> str:
    """Return a test value or a limit of one: three significant digits, two decimals at most."""
    if not math.isfinite(value):
        return "—"
    return f"{value:.0f}" if abs(value) >= 99.95 else f"{value:.1f}" if abs(value) >= 9.995 else f"{value:.2f}"


def p_value(p: float) -> str:
    """Return a probability, never printed as zero."""
    if not math.isfinite(p):
        return "—"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def angle(value_deg: float) -> str:
    """Return an attitude of the plan: as many decimals as it has, with a sign that shows where it points."""
    text = f"{value_deg:.4f}".rstrip("0").rstrip(".")
    return "0°" if text in ("0", "-0") else text.replace("-", "−") + "°"


def attitude(targets_deg: Mapping[str, float]) -> str:
    """Return an attitude in words: ``pitch −30°, roll 0°``."""
    return ", ".join(f"{name} {angle(value)}" for name, value in targets_deg.items())


def duration(seconds: float) -> str:
    """Return ``5.2 s``, ``42 s``, ``7 min 12 s``, ``52 min`` or ``3 h 05 min``: what is smaller says nothing beside."""
    seconds = max(seconds, 0.0)
    if round(seconds) < 60:
        return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.1f}".removesuffix(".0") + " s"
    if round(seconds) < 600:
        return f"{round(seconds) // 60} min {round(seconds) % 60:02d} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def as_drawn(sensitivity_v_per_g: float, unit: str) -> tuple[float, str]:
    """Return the factor and the unit in which a change of a reading is shown: as the angle that causes it where the
    axis is most sensitive, or in its own unit where nothing says what angle it is.
    """
    if unit != "v" or not sensitivity_v_per_g:
        return 1.0, printed(unit)
    return arcsec(1.0, sensitivity_v_per_g), "″"


def arcsec(voltage_v: float, sensitivity_v_per_g: float) -> float:
    """Return a voltage as the angle, in arc seconds, that causes it where the axis is most sensitive: v/|S|."""
    return voltage_v / abs(sensitivity_v_per_g) * ARCSEC_PER_RAD
