"""Pulse widths of a servo as table angles: straight lines between two or more calibrated points."""

from collections.abc import Sequence
from itertools import pairwise


class PulseCalibration:
    """``points``: pairs of pulse width (µs) and table angle (degrees), angles strictly rising or falling with pulses.

    Beyond the last points the outer lines go on. Raises: ValueError where the points are no such calibration.
    """

    def __init__(self, points: Sequence[tuple[float, float]]) -> None:
        self.points = tuple(sorted((float(pulse_us), float(angle_deg)) for pulse_us, angle_deg in points))
        steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(self.points)]
        rising = [pulse_us > 0.0 and angle_deg > 0.0 for pulse_us, angle_deg in steps]
        falling = [pulse_us > 0.0 and angle_deg < 0.0 for pulse_us, angle_deg in steps]
        if not steps or not (all(rising) or all(falling)):
            found = ", ".join(f"[{pulse_us:g}, {angle_deg:g}]" for pulse_us, angle_deg in self.points)
            raise ValueError(
                "a calibration needs two or more [pulse_us, angle_deg] pairs, the angle strictly rising or falling"
                f" with the pulse, got {found or 'none'}"
            )

    @property
    def smallest_us_per_deg(self) -> float:
        """Of the flattest line: where a change of the pulse turns the servo farthest."""
        return min(abs((b[0] - a[0]) / (b[1] - a[1])) for a, b in pairwise(self.points))

    def deg_per_us(self, pulse_us: float) -> float:
        """Return the slope of the line that holds at ``pulse_us``."""
        return self.angle_deg(pulse_us + 0.5) - self.angle_deg(pulse_us - 0.5)

    def pulse_us(self, angle_deg: float) -> float:
        return _interpolated([(angle, pulse) for pulse, angle in self.points], angle_deg)

    def angle_deg(self, pulse_us: float) -> float:
        return _interpolated(self.points, pulse_us)


def _interpolated(points: Sequence[tuple[float, float]], x: float) -> float:
    ordered = sorted(points)
    inner = sum(1 for known, _ in ordered[1:-1] if known <= x)
    (x0, y0), (x1, y1) = ordered[inner], ordered[inner + 1]
    return y0 + (x - x0) * (y1 - y0) / (x1 - x0)
