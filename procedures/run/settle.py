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
from numpy.typing import NDArray

from procedures.description import Settle
from procedures.run.student import t_limit
from rig.clock import Clock
from rig.devices.abilities import Readout, Wait

FALSE_ALARM = 0.05
FEWEST_READINGS, MOST_READINGS = 5, 10
"""A window. More readings would prove no more: what matters is the time between the windows."""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Window:
    """Readings of one window and when they were taken, rig seconds."""

    times_s: FloatArray
    values_v: FloatArray


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
        windows.append(_read_window(readout, channel, count, nplc, settings.window_s, clock, wait))
        took_s = clock.monotonic_s() - started_s
        if took_s >= settings.min_s and is_at_rest(windows, settings.windows):
            return Settled(True, took_s)
        if took_s >= settings.max_s:
            return Settled(False, took_s)
        del windows[: -settings.windows]


def readings_per_window(window_s: float, reading_s: float) -> int:
    """As many as fit, at least five and at most ten."""
    fitting = MOST_READINGS if reading_s <= 0.0 else int(window_s / reading_s)
    return min(max(fitting, FEWEST_READINGS), MOST_READINGS)


def is_at_rest(windows: Sequence[Window], needed: int) -> bool:
    """True where the last ``needed`` windows cannot be told apart. An overloaded reading is never at rest."""
    last = windows[-needed:]
    if len(last) < needed or not all(np.isfinite(window.values_v).all() for window in last):
        return False
    return _means_agree(last[0].values_v, last[-1].values_v) and not has_slope(
        np.concatenate([window.times_s for window in last]),
        np.concatenate([window.values_v for window in last]),
        FALSE_ALARM,
    )


def has_slope(times_s: FloatArray, values_v: FloatArray, false_alarm: float) -> bool:
    """True where a straight line over time explains more than scatter would."""
    degrees = values_v.size - 2
    if degrees < 1:
        return False
    centred_s, centred_v = times_s - times_s.mean(), values_v - values_v.mean()
    spread = float(centred_s @ centred_s)
    if spread == 0.0:
        return False
    slope = float(centred_s @ centred_v) / spread
    rest_v = centred_v - slope * centred_s
    error = sqrt(max(float(rest_v @ rest_v), _rounding_v2(values_v)) / degrees / spread)
    return abs(slope) > t_limit(degrees, false_alarm) * error


def _means_agree(first_v: FloatArray, last_v: FloatArray) -> bool:
    degrees = first_v.size + last_v.size - 2
    squares = float(((first_v - first_v.mean()) ** 2).sum() + ((last_v - last_v.mean()) ** 2).sum())
    variance = max(squares, _rounding_v2(first_v)) / degrees * (1.0 / first_v.size + 1.0 / last_v.size)
    return abs(float(first_v.mean() - last_v.mean())) <= t_limit(degrees, FALSE_ALARM) * sqrt(variance)


def _rounding_v2(values_v: FloatArray) -> float:
    """Sum of squares that the arithmetic itself may leave in readings that are all the same."""
    return float(values_v.size * (4.0 * np.finfo(float).eps * np.abs(values_v).max()) ** 2)


def _read_window(
    readout: Readout, channel: str, count: int, nplc: float, window_s: float, clock: Clock, wait: Wait
) -> Window:
    opened_s = clock.monotonic_s()
    burst = readout.read(channel, count, wait, nplc)
    wait(window_s - (clock.monotonic_s() - opened_s))
    return Window(burst.started_s + burst.interval_s * np.arange(burst.values_v.size, dtype=np.float64), burst.values_v)
