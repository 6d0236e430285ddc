"""What a profile of motion asks of its axis: angles, range, top rate and acceleration."""

from math import pi, sin

from procedures.plan.steps import Follow


def profile_deg(motion: Follow, axis: str, after_s: float) -> float:
    """Return how far an axis is from its start: before the motion 0, behind it where it ended."""
    span_deg, elapsed_s = motion.span_deg[axis], min(max(after_s, 0.0), motion.seconds)
    if motion.shape == "ramp":
        return span_deg * elapsed_s / motion.seconds
    return span_deg * sin(2.0 * pi * motion.frequency_hz[axis] * elapsed_s)


def top_rate_dps(motion: Follow, axis: str) -> float:
    """Return the largest rate of the profile."""
    span_deg = abs(motion.span_deg[axis])
    return span_deg / motion.seconds if motion.shape == "ramp" else span_deg * 2.0 * pi * motion.frequency_hz[axis]


def range_deg(motion: Follow, axis: str) -> tuple[float, float]:
    """Return the lowest and highest angle from the start."""
    angles_deg = [profile_deg(motion, axis, motion.seconds * part / 1000.0) for part in range(1001)]
    return min(angles_deg), max(angles_deg)
