"""Verification: read an exported file back and recompute its test vectors from its own coefficients."""

from dataclasses import dataclass
from pathlib import Path

from ams.exports.formats import format_of, load_set
from ams.sets.vectors import TOLERANCE_RELATIVE


@dataclass(frozen=True)
class Verification:
    """A file that is intact and reproduces its test vectors, in plain values."""

    path: str
    format: str
    sensor: str
    axes: tuple[str, ...]
    sha256: str
    """The set's checksum: the same in every format."""
    status: str
    standing: str
    """The status in words: an approval over the verdict ``not usable`` is said to be one."""
    verdict: str | None
    """Of the calibration: ``sound``, ``usable`` or ``not usable``; None where an earlier version tells none."""
    simulated: bool
    forward_vectors: int
    inverse_vectors: int
    largest_relative_error: float
    tolerance_relative: float


def verify(path: str | Path) -> Verification:
    """Read the file back, check it, recompute its test vectors.

    Raises: SetError for a file that is damaged, newer or no set; VectorsDisagree for an intact one whose test vectors
    its coefficients do not reproduce.
    """
    coefficients = load_set(path)
    agreement = coefficients.check_vectors(str(path))
    return Verification(
        path=str(path),
        format=format_of(Path(path)).name,
        sensor=coefficients.sensor,
        axes=tuple(coefficients.axes),
        sha256=coefficients.sha256,
        status=coefficients.status,
        standing=coefficients.standing,
        verdict=coefficients.verdict,
        simulated=coefficients.is_simulated,
        forward_vectors=agreement.forward,
        inverse_vectors=agreement.inverse,
        largest_relative_error=agreement.largest_relative_error,
        tolerance_relative=TOLERANCE_RELATIVE,
    )
