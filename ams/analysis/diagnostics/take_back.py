"""The commands by which a person has dwells of a run measured again, as findings print them, the cheapest first."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import BoolArray
from ams.observations import Observations

_IN_WHOSE_NAME: Final = "--operator NAME --reason TEXT"
"""Without these ``redo`` and ``void`` are refused."""

Measured = tuple[int, int]
"""Step and replication of a dwell of the design that counts."""


@dataclass(frozen=True)
class WayBack:
    """Commands that take back dwells, and at least those that are meant."""

    commands: tuple[str, ...]
    dwells: int
    """Of the design, that count no more then."""

    @property
    def text(self) -> str:
        """The commands with what they take back."""
        takes = "takes" if len(self.commands) == 1 else "take"
        count = f"{self.dwells} dwell{'' if self.dwells == 1 else 's'}"
        return f"{' and '.join(self.commands)} {takes} back {count} of the design"


def redo_command(replication: int | str, run: str = "") -> str:
    """Return the command that measures a replication again, whole; without a run it is for the one of the folder."""
    return f"calrig redo {run}{' ' if run else ''}--replication {replication} {_IN_WHOSE_NAME}"


def void_command(step: int | str, run: str = "") -> str:
    """Return the command that takes back a step and all that was measured after it."""
    return f"calrig void {run}{' ' if run else ''}--from {step} {_IN_WHOSE_NAME}"


def ways_back(steps: Collection[int], measured: Sequence[Measured], run: str = "") -> tuple[WayBack, ...]:
    """Return both ways to take back the dwells of some steps, the one first that takes back fewer; none for no steps.

    ``measured``: every dwell of the design that counts, in the order of time, which is that of a void: a replication
    that was measured again comes last, whatever its steps.
    """
    meant = [index for index, (step, _) in enumerate(measured) if step in steps]
    if not meant:
        return ()
    labels = sorted({measured[index][1] for index in meant})
    whole = sum(replication in labels for _, replication in measured)
    redo = WayBack(tuple(redo_command(label, run) for label in labels), whole)
    void = WayBack((void_command(measured[meant[0]][0], run),), len(measured) - meant[0])
    return tuple(sorted((redo, void), key=lambda way: (way.dwells, len(way.commands))))


def ways_in_words(ways: Sequence[WayBack]) -> str:
    """Return every way with what it takes back, for a person to choose from."""
    return ", or ".join(way.text for way in ways)


def measured_in(rows: Observations) -> tuple[Measured, ...]:
    """Return the dwells of rows in the order of time; none where the rows are of no run."""
    if rows.step is None:
        return ()
    order = rows.step.argsort() if rows.time_s is None else np.argsort(rows.time_s, kind="stable")
    return tuple(zip(rows.step[order].tolist(), rows.replication[order].tolist(), strict=True))


def ways_back_of(which: BoolArray, rows: Observations) -> tuple[WayBack, ...]:
    """Return both ways to take back the (N,) rows that are meant, as :func:`ways_back`."""
    return () if rows.step is None else ways_back(set(rows.step[which].tolist()), measured_in(rows), rows.run)
