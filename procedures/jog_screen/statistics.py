"""Mean, standard deviation and count of a channel while it is being read, without keeping every reading."""

import math
from collections import deque

import numpy as np

from procedures.jog_screen.values import ChannelView
from rig.devices.abilities import Burst

SHOWN = 120
"""Readings that are kept for the plot."""


class Running:
    """Welford's sums of one channel."""

    def __init__(self, channel: str) -> None:
        self.channel = channel
        self.silence = ""
        self.clear()

    def clear(self) -> None:
        self._count = self._overloads = 0
        self._mean_v = self._squares_v2 = 0.0
        self._recent: deque[float] = deque(maxlen=SHOWN)

    def add(self, burst: Burst) -> None:
        self.silence = ""
        self._overloads += int(np.count_nonzero(burst.overload))
        for value_v in burst.samples[~burst.overload]:
            self._count += 1
            away_v = float(value_v) - self._mean_v
            self._mean_v += away_v / self._count
            self._squares_v2 += away_v * (float(value_v) - self._mean_v)
            self._recent.append(float(value_v))

    def view(self) -> ChannelView:
        return ChannelView(
            name=self.channel,
            count=self._count,
            mean_v=self._mean_v if self._count else math.nan,
            standard_deviation_v=math.sqrt(self._squares_v2 / (self._count - 1)) if self._count > 1 else math.nan,
            overloads=self._overloads,
            recent_v=tuple(self._recent),
            silence=self.silence,
        )
