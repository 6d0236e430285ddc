"""Angles of accelerometers with those of gyros beside them: each tells where the other is corrupted.

CR carries both so (II): packages that feel gravity, and gyros that are integrated from the start. They are
independent. A row in which an angle differs by more than both uncertainties explain (k = 2) and the limit allows beyond
that is flagged; which of them is wrong it does not tell. The answer is that of the accelerometers, with the largest
difference beside it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.errors import OutsideValidity
from ams.frames import ANGLES, wrap_deg
from ams.inference.rows.angle_stream import AngleStream, Answer, joined

COVERAGE: Final = 2.0
"""Standard deviations of a difference that are explained."""
DIFFERENCE: Final = "gyro_difference_deg"


@dataclass
class _Waiting:
    """Rows of one stream that the other has not answered yet."""

    found: Answer | None = None

    def add(self, found: Answer) -> None:
        if found.codes.size:
            self.found = found if self.found is None else joined(self.found, found)

    @property
    def rows(self) -> int:
        return 0 if self.found is None else self.found.codes.size

    def taken(self, count: int) -> Answer:
        """Take the oldest rows."""
        assert self.found is not None
        whole = self.found
        self.found = _part(whole, slice(count, None))
        return _part(whole, slice(count))


class MonitoredAngles:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` of two of them over the same rows."""

    def __init__(self, packages: AngleStream, gyros: AngleStream, limit_deg: float) -> None:
        if not limit_deg >= 0.0:
            raise OutsideValidity(f"agreement: got a limit of {limit_deg:g}°, allowed 0° or more; nothing was computed")
        self.packages, self.gyros, self.limit_deg = packages, gyros, limit_deg
        self._of_packages, self._of_gyros = _Waiting(), _Waiting()

    @property
    def needed(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*self.packages.needed, *self.gyros.needed)))

    @property
    def optional(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*self.packages.optional, *self.gyros.optional)))

    @property
    def answers(self) -> tuple[str, ...]:
        *angles, flag = self.packages.answers
        return (*angles, DIFFERENCE, flag)

    @property
    def answers_at_once(self) -> bool:
        return False

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the rows that both have answered. Raises: as the two streams."""
        self._of_packages.add(self.packages.answer(readings))
        self._of_gyros.add(self.gyros.answer(readings))
        return self._due()

    def finish(self) -> Answer:
        """Return what is still due."""
        self._of_packages.add(self.packages.finish())
        self._of_gyros.add(self.gyros.finish())
        return self._due()

    def _due(self) -> Answer:
        count = min(self._of_packages.rows, self._of_gyros.rows)
        if not count:
            return Answer({name: np.empty(0) for name in self.answers[:-1]}, np.empty(0, dtype=np.uint64))
        of_packages, beside = self._of_packages.taken(count), self._of_gyros.taken(count)
        difference, beyond = np.full(count, np.nan), np.zeros(count, dtype=bool)
        for name in ANGLES:
            if f"{name}_deg" not in of_packages.columns or f"{name}_deg" not in beside.columns:
                continue
            off = np.abs(wrap_deg(of_packages.columns[f"{name}_deg"] - beside.columns[f"{name}_deg"]))
            spread = np.hypot(of_packages.columns[f"{name}_sd_deg"], beside.columns[f"{name}_sd_deg"])
            difference = np.fmax(difference, off)
            with np.errstate(invalid="ignore"):
                beyond |= off - COVERAGE * spread > self.limit_deg
        codes = of_packages.codes | np.where(beyond, flag_codes.DISAGREE, 0).astype(np.uint64)
        codes |= np.where(np.isnan(difference), flag_codes.NOT_COMPARED, 0).astype(np.uint64)
        return Answer(
            {**of_packages.columns, DIFFERENCE: difference}, codes, {**of_packages.reasons, **flag_codes.MONITOR_WORDS}
        )


def _part(found: Answer, rows: slice) -> Answer:
    return Answer({name: values[rows] for name, values in found.columns.items()}, found.codes[rows], found.reasons)
