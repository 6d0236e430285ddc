"""What an export format is: a name, the ending of its files, the set to bytes and the bytes back to the set."""

from collections.abc import Callable
from dataclasses import dataclass

from ams.models.sensor_model import SetForm
from ams.sets.coefficients import CoefficientSet


@dataclass(frozen=True)
class ForeseenSet:
    """What is known of a set before anything is measured."""

    axes: tuple[str, ...]
    unit: str
    """Of what is sensed, as it is written in a key."""
    form: SetForm | None
    """Of all axes; None for straight lines, whose form follows from what is measured."""


@dataclass(frozen=True)
class Format:
    """One format, by its name on the command line and in procedure files."""

    name: str
    ending: str
    """Of its files' names: a file is read as the format with the longest ending that fits."""
    to_bytes: Callable[[CoefficientSet], bytes]
    """Raises: SetError where the format has no form of this set."""
    from_bytes: Callable[[bytes, str], CoefficientSet]
    """Content and what to call it in messages. Raises: SetError, VectorsDisagree."""
    loses: str | None = None
    """What the format's own numbers do not hold; the whole set is inside every file all the same."""

    lacks: Callable[[ForeseenSet], str | None] | None = None
    """Why it has no form of a set, where that is known before anything is measured, in the words of ``to_bytes``; None:
    nothing is."""
    needs: tuple[str, ...] = ()
    """Libraries of an extra that writing it takes."""
    since: int = 1
    """Version of coefficient sets that was written when the format came: of those before no file of it exists."""

    def file_name(self, stem: str) -> str:
        """Return a file's name such as ``SN1047.fixed.h``."""
        return f"{stem}{self.ending}"
