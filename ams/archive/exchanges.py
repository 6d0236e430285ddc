"""Which sensors of a run look exchanged, by the sets that the archive holds of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sqlalchemy import Connection, select

from ams.archive.approvals import is_signed
from ams.archive.set_before import set_before
from ams.archive.tables import SETS
from ams.sets.coefficients import CoefficientSet
from ams.surveillance.exchanged import Exchange, Recalibrated, exchanged


def exchanges_of(
    connection: Connection, sets: Sequence[CoefficientSet], before: Mapping[str, CoefficientSet | None]
) -> Mapping[str, Exchange]:
    """Return which sensors look exchanged; which of their sets are the others' is told by those of before that.

    A set that a person released from quarantine is its sensor's, by that person's word.
    """
    recalibrated = [Recalibrated(made, old) for made in sets if (old := before[made.sensor]) is not None]
    found = exchanged(recalibrated)
    if not found:
        return found
    return exchanged([replace(entry, earlier=_earlier(connection, entry.before)) for entry in recalibrated])


def _earlier(connection: Connection, before: CoefficientSet) -> CoefficientSet | None:
    """Return the set before one, None where a person released that one."""
    released = select(SETS.c.sha256).where(SETS.c.sha256 == before.sha256, is_signed(SETS.c.sha256, "released"))
    return None if connection.execute(released).first() is not None else set_before(connection, before)
