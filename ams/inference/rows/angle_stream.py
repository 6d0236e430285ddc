"""What turns readings into angles piece by piece, whatever it remembers between the pieces."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.rows.used_beyond import codes_of_temperature
from ams.models.possible_temperature import impossible_temperature
from ams.sets.coefficients import CoefficientSet

CARRIED_CODES: Final = "codes of what was done before"
"""A column of codes that a stream takes along where it is optional: its answers are not one for each row."""
SD_FACTOR: Final = "factor of the standard deviation of a reading"
"""A column of what the standard deviation stated for a reading is multiplied by in each row: a mean of fewer readings
than it is stated for has a larger one."""
OF_STREAMS: Final = frozenset({CARRIED_CODES, SD_FACTOR})
"""Columns that streams hand to one another and no file has."""


@dataclass(frozen=True)
class Answer:
    """Angles of N rows, NaN where the code says why."""

    columns: Mapping[str, FloatArray]
    """(N,) degrees by name, in order."""
    codes: flag_codes.AnswerCodes
    reasons: Mapping[int, str] = field(default_factory=lambda: flag_codes.WORDS)
    """What the codes mean."""

    @property
    def flags(self) -> tuple[str, ...]:
        """The codes in words, empty where all is well."""
        return flag_codes.words(self.codes, self.reasons)


def joined(first: Answer, second: Answer) -> Answer:
    """Return two answers as one."""
    columns = {name: np.concatenate([values, second.columns[name]]) for name, values in first.columns.items()}
    return Answer(columns, np.concatenate([first.codes, second.codes]), first.reasons)


class AngleStream(Protocol):
    """Readings in, angles out: every row is answered once, in order, some only when later ones have come."""

    @property
    def needed(self) -> tuple[str, ...]:
        """Columns that every row must have."""

    @property
    def optional(self) -> tuple[str, ...]:
        """Columns that are used where they are there."""

    @property
    def answers(self) -> tuple[str, ...]:
        """Columns of the answer, in order, ``flag`` the last."""

    @property
    def answers_at_once(self) -> bool:
        """Whether every row is answered by the call that brings it."""

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles that (n,) further readings settle."""

    def finish(self) -> Answer:
        """Return the angles that are still due; the stream ends here."""


def with_temperature_codes(found: Answer, readings: Mapping[str, FloatArray], sets: Iterable[CoefficientSet]) -> Answer:
    """Return an answer to rows that tells which have a temperature that no sensor stands, or at which no set is valid.

    ``sets``: those that the rows are read by.
    """
    outside = codes_of_temperature(sets, readings)
    if outside is not None:
        found = Answer(found.columns, found.codes | outside, found.reasons)
    beyond = impossible_temperature(readings)
    if beyond is None:
        return found
    codes = found.codes.astype(np.uint64)
    codes[beyond] |= np.uint64(flag_codes.IMPOSSIBLE_TEMPERATURE)
    return Answer(found.columns, codes, {**found.reasons, **flag_codes.TEMPERATURE_WORDS})


def nothing(answers: tuple[str, ...]) -> Answer:
    """Return an answer to no row."""
    return Answer({name: np.empty(0) for name in answers if name != "flag"}, np.empty(0, dtype=np.uint32))
