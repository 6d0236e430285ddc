"""Mean, standard deviation and count of a channel while it is being read, without keeping every reading."""

import math
from collections import deque

import numpy as np

from procedures.jog_screen.values import ChannelView
from rig.abilities.abilities import Burst

SHOWN = 120
"""Readings that are kept for the plot."""


class Running:
    """Welford's sums of one channel."""

    def __init__(self, channel: str, unit: str = "v") -> None:
        self.channel = channel
        self._unit = unit
        self.silence = ""
        self.clear()

    def clear(self) -> None:
        self._count = self._overloads = 0
        self._mean = self._squares = 0.0
        self._recent: deque[float] = deque(maxlen=SHOWN)

    def add(self, burst: Burst) -> None:
        self.silence = ""
        self._overloads += int(np.count_nonzero(burst.overload))
        for value in burst.samples[~burst.overload]:
            self._count += 1
            away = float(value) - self._mean
            self._mean += away / self._count
            self._squares += away * (float(value) - self._mean)
            self._recent.append(float(value))

    def view(self) -> ChannelView:
        return ChannelView(
            name=self.channel,
            count=self._count,
            unit=self._unit,
            mean=self._mean if self._count else math.nan,
            standard_deviation=math.sqrt(self._squares / (self._count - 1)) if self._count > 1 else math.nan,
            overloads=self._overloads,
            recent=tuple(self._recent),
            silence=self.silence,
        )
