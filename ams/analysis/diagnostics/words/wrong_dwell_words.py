"""What is said of single dwells that the other replications contradict: which, by how much, and what to do."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BeliefTest
from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.analysis.diagnostics.size_words import Scale
from ams.analysis.diagnostics.take_back import ways_back_of, ways_in_words
from ams.analysis.diagnostics.wrong_dwells import WrongDwells
from ams.findings import Finding
from ams.inputs.known_of_run import DwellLabels
from ams.observations import Observations
from ams.rounding import significant

MOST_LISTED: Final = 5
"""Wrong dwells that a sentence names; all stand in ``steps``."""


@dataclass(frozen=True)
class Convicted:
    """Wrong dwells of one axis as rows of the observations."""

    found: WrongDwells
    rows: tuple[int, ...]


def wrong_dwell_finding(
    test: BeliefTest,
    scale: Scale,
    observations: Observations,
    convicted: Convicted,
    alike: Mapping[DwellLabels, str],
) -> Finding:
    """Return the finding of the wrong dwells of one axis.

    ``alike``: dwells at which a table that stood off would look as wrong readings, and by how much it stood off then.
    """
    rows, found = convicted.rows, convicted.found
    turns = [alike.get((int(observations.replication[row]), int(observations.point[row])), "") for row in rows]
    dwells = [
        f"{dwell_words(observations, row)} is off by {scale.words(size)}"
        f" ({significant(abs(deviations))} standard deviations of a dwell"
        f"{f'; a table that stood off by {turn} would look the same here' if turn else ''})"
        for row, size, deviations, turn in zip(rows, found.sizes, found.deviations, turns, strict=True)
    ]
    more = len(dwells) - MOST_LISTED
    listed = "; ".join(dwells[:MOST_LISTED]) + (f"; and {more} more" if more > 0 else "")
    first = rows[0]
    steps = () if observations.step is None else tuple(int(observations.step[row]) for row in rows)
    meant = np.zeros(observations.rows, dtype=bool)
    meant[list(rows)] = True
    what_to_do = (
        f"measure {'it' if len(rows) == 1 else 'them'} again ({ways_in_words(ways_back_of(meant, observations))})"
        if steps
        else f"look at it, or take {'its row' if len(rows) == 1 else 'their rows'} out of {observations.source} and "
        "solve it again"
    )
    fact = (
        f"wrong dwell: {listed}, against what the other replications say; it is in the result and in its uncertainty, "
        "and left out of all other tests"
    )
    details: dict[str, float | str | None] = {
        "test": test.name,
        **test.numbers,
        **({"confounded_with": "table-rotation"} if any(turns) else {}),
        "replication": float(observations.replication[first]),
        "point": float(observations.point[first]),
        "pitch_deg": float(np.rad2deg(observations.pitch_rad[first])),
        "roll_deg": float(np.rad2deg(observations.roll_rad[first])),
        **({} if observations.yaw_rad is None else {"yaw_deg": float(np.rad2deg(observations.yaw_rad[first]))}),
    }
    return Finding("wrong-dwell", fact, True, test.p_value, steps, details, what_to_do=what_to_do)
