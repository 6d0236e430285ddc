"""What is said of an output that is off at one index of the table, at few, or at one attitude alone."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BeliefTest
from ams.analysis.diagnostics.locations import Location
from ams.analysis.diagnostics.size_words import Scale
from ams.arrays import IntArray
from ams.findings import Finding
from ams.observations import Observations

_NOT_HELD: Final = (
    "offset and sensitivities hold part of it, and the stated uncertainties do not hold that: they take what repeats "
    "for errors that differ from attitude to attitude"
)
_HELD: Final = "it is within the declared largest_nonlinearity_v"
_CAUSES: Final = (
    "vibration that the sensor rectifies, an end of its range, a cable or a stop that touches, a magnet, or an index "
    "of the table that is wrong"
)
_EXPANDED: Final = 2.0


def location_finding(test: BeliefTest, locations: Sequence[Location], scale: Scale, rows: Observations) -> Finding:
    """Return the finding, which names the locations, how far the output is off there, and the points of its dwells."""
    meant = np.isin(rows.point, np.concatenate([location.labels for location in locations]))
    off = "; ".join(_off(location, scale, rows) for location in locations)
    fact = (
        f"in every replication the output is off the model {off}, and hardly elsewhere: something there alone "
        f"({_CAUSES}); {_HELD if test.is_held else _NOT_HELD}"
    )
    steps = () if rows.step is None else tuple(int(step) for step in np.sort(rows.step[meant]))
    left_out = "out of the design" if steps else f"out of {rows.source} and solve it again"
    what_to_do = f"look at what is there and measure again, or leave these points {left_out}"
    plainest = locations[0]
    details: dict[str, float | str | None] = {
        "test": test.name,
        **test.numbers,
        "place": plainest.axis or "attitude",
        **({f"{plainest.axis}_deg": plainest.index_deg} if plainest.axis else _attitude(plainest, rows)),
    }
    return Finding(test.kind, fact, True, test.p_value, steps, details, is_held=test.is_held, what_to_do=what_to_do)


def _off(location: Location, scale: Scale, rows: Observations) -> str:
    points = _in_ranges(location.labels)
    if not location.axis:
        at = _attitude(location, rows)
        return f"at pitch {_deg(at['pitch_deg'])}, roll {_deg(at['roll_deg'])} by {_even(location, scale)} ({points})"
    others = "".join(f" or {_deg(other)}" for other in location.or_at_deg)
    by = (
        _even(location, scale)
        if location.is_even
        else (f"{scale.words(location.size)} (root of the mean square over its attitudes, of each another amount)")
    )
    return f"at {location.axis} index {_deg(location.index_deg)}{others} by {by} ({points})"


def _even(location: Location, scale: Scale) -> str:
    return scale.within(location.size, _EXPANDED * location.standard_uncertainty)


def _attitude(location: Location, rows: Observations) -> dict[str, float]:
    row = int(np.flatnonzero(rows.point == location.labels[0])[0])
    return {"pitch_deg": float(np.rad2deg(rows.pitch_rad[row])), "roll_deg": float(np.rad2deg(rows.roll_rad[row]))}


def _deg(angle_deg: float) -> str:
    return f"{round(angle_deg, 4) + 0.0:g}°".replace("-", "−")


def _in_ranges(labels: IntArray) -> str:
    """Return labels of points, those that follow one another as a range."""
    runs: list[list[int]] = []
    for label in np.sort(labels).tolist():
        if runs and label == runs[-1][-1] + 1:
            runs[-1].append(label)
        else:
            runs.append([label])
    shown = ", ".join(f"{run[0]}" if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs)
    return f"point{'' if labels.size == 1 else 's'} {shown}"
