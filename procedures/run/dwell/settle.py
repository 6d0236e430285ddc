"""Settled or not, by window statistics: at rest is what later windows cannot tell from earlier ones.

Each window is a burst of readings of one channel. The package is at rest when the last few windows have means that
agree within what their own scatter allows (first against last, Student's t) and no slope over all of them. Both tests
raise a false alarm once in twenty, which costs one more window; a stricter limit would take a slow creep for rest.
What still creeps then is met by the slope test of the dwell itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from ams.arrays import FloatArray
from procedures.description.dwell_settings import Settle
from procedures.plan.windows import FEWEST_READINGS, MOST_READINGS
from procedures.statistics import _rounding_v2, has_slope, t_limit
from rig.abilities.abilities import Readout, Wait
from rig.clock import Clock

FALSE_ALARM = 0.05
"""A window. More readings would prove no more: what matters is the time between the windows."""


@dataclass(frozen=True)
class Window:
    """Readings of one window and when they were taken, rig seconds."""

    times_s: FloatArray
    samples: FloatArray


@dataclass(frozen=True, slots=True)
class Settled:
    """How the wait for rest ended."""

    is_settled: bool
    took_s: float


def settle(readout: Readout, channel: str, settings: Settle, nplc: float, clock: Clock, wait: Wait) -> Settled:
    """Read windows until the package is at rest or ``max_s`` has passed since now."""
    started_s = clock.monotonic_s()
    count = readings_per_window(settings.window_s, readout.reading_s(nplc))
    windows: list[Window] = []
    while True:
        opened_s = clock.monotonic_s()
        burst = readout.read(channel, count, wait, nplc)
        wait(settings.window_s - (clock.monotonic_s() - opened_s))
        windows.append(
            Window(burst.started_s + burst.interval_s * np.arange(burst.samples.size, dtype=np.float64), burst.samples)
        )
        took_s = clock.monotonic_s() - started_s
        if took_s >= settings.min_s and is_at_rest(windows, settings.windows):
            return Settled(True, took_s)
        if took_s >= settings.max_s:
            return Settled(False, took_s)
        del windows[: -settings.windows]


def readings_per_window(window_s: float, reading_s: float) -> int:
    """Return as many readings as fit into a window, at least five and at most ten."""
    fitting = MOST_READINGS if reading_s <= 0.0 else int(window_s / reading_s)
    return min(max(fitting, FEWEST_READINGS), MOST_READINGS)


def is_at_rest(windows: Sequence[Window], needed: int) -> bool:
    """Return True where the last ``needed`` windows cannot be told apart. An overloaded reading is never at rest."""
    last = windows[-needed:]
    if len(last) < needed or not all(np.isfinite(window.samples).all() for window in last):
        return False
    return _means_agree(last[0].samples, last[-1].samples) and not has_slope(
        np.concatenate([window.times_s for window in last]),
        np.concatenate([window.samples for window in last]),
        FALSE_ALARM,
    )


def _means_agree(first_v: FloatArray, last_v: FloatArray) -> bool:
    degrees = first_v.size + last_v.size - 2
    squares = float(((first_v - first_v.mean()) ** 2).sum() + ((last_v - last_v.mean()) ** 2).sum())
    variance = max(squares, _rounding_v2(first_v)) / degrees * (1.0 / first_v.size + 1.0 / last_v.size)
    return abs(float(first_v.mean() - last_v.mean())) <= t_limit(degrees, FALSE_ALARM) * sqrt(variance)
