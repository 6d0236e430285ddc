"""What the attitudes that a run takes as true are wrong by.

A rig knows an attitude as well as its axes, their zeros and the level of the base are known. Where an error of an angle
is stated at such an attitude, the reference's own error is in it whole: it is no error of the coefficients, which
follow only what of it looks like another sensor.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.inputs.shared_errors import OF_THE_BASE, SharedError
from ams.inputs.table_uncertainty import corrected
from ams.observations import Observations
from ams.sets.canonical import Document, Json, table
from ams.solve.table_errors import TablePriors

TABLE: Final = "the index errors of the table"
LEVEL: Final = "the level of the base"
_TABLE_PART: Final = "table"
"""Of a set's covariance; a joint fit has the errors of the whole table in it too."""


@dataclass(frozen=True)
class ReferenceInWords:
    """What stands on a page beside errors of angles."""

    counted: str
    """As the rig declares it; empty: nothing of the reference is in their uncertainty."""
    not_counted: str = ""
    """What nobody declared; empty: nothing is missing."""

    @property
    def sentence(self) -> str:
        """Whether U counts the reference."""
        counted = f"U counts what the reference attitude itself is wrong by ({self.counted})." if self.counted else ""
        missing = f"Not in U, an error of the reference all the same: {self.not_counted}." if self.not_counted else ""
        return " ".join(part for part in (counted, missing) if part)


NOTHING_DECLARED: Final = ReferenceInWords("", f"{TABLE} and {LEVEL}")
NOT_COUNTED_THEN: Final = ReferenceInWords("", f"{TABLE} and {LEVEL} (stored before they were counted)")


@dataclass(frozen=True)
class ReferenceAttitude:
    """What is declared of the attitudes of a run, and as what."""

    errors: TablePriors
    in_words: ReferenceInWords
    parts: frozenset[str] = frozenset({_TABLE_PART})
    """Names of the parts of a set's covariance that come of these errors."""

    def corrected(self, rows: Observations) -> Observations:
        """Return the rows at the attitudes where the table truly stood, as far as its certificate lists its errors."""
        return corrected(rows, self.errors.table)

    def angle_variances(self, gain: FloatArray, k: FloatArray, pitch: FloatArray, roll: FloatArray) -> FloatArray:
        """Return (N, s) variances of the errors of angles that the reference makes, radians squared.

        ``gain``: (N, s, A) angles per output; ``k``: (A, 3) sensitivities of the A outputs; at (N,) attitudes, radians.
        """
        of_angles = np.einsum("nsa,ai,niq->nsq", gain, k, self.errors.force_errors(pitch, roll), optimize=True)
        return np.asarray(np.sum(of_angles**2, axis=-1))


def parts_of(shared: Mapping[str, Sequence[SharedError]]) -> frozenset[str]:
    """Return the names of the parts of a set's covariance that come of errors of the reference.

    ``shared``: sensor axis to the errors that all its rows share.
    """
    of_level = {error.name for each in shared.values() for error in each if error.effect in OF_THE_BASE}
    return frozenset({_TABLE_PART, *of_level})


def to_document(in_words: ReferenceInWords) -> Document:
    """Return the words as plain JSON values."""
    return {"counted": in_words.counted or None, "not_counted": in_words.not_counted or None}


def from_document(document: Json) -> ReferenceInWords:
    """Return the words back from :func:`to_document`; those of an earlier version, which had none, from None."""
    if document is None:
        return NOT_COUNTED_THEN
    stated = table(document)
    return ReferenceInWords(str(stated["counted"] or ""), str(stated["not_counted"] or ""))
