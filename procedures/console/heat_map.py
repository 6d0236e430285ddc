"""Residuals of a run so far as a picture's numbers: a row a channel, a column a dwell.

Every channel is taken for a straight line of the specific force, b + k·f, by least squares over the dwells that count.
That is no calibration: it shows at a glance what moved, and whether all sensors saw it.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ams.frames import specific_force
from ams.units import ARCSEC_PER_RAD
from procedures.journal.status.follower import FollowedDwell
from procedures.records.dwells import read_back_rad

FEWEST = 8
"""Dwells before a line through four numbers means anything."""
MOST_COLUMNS = 1600


@dataclass(frozen=True)
class HeatMap:
    """What a page draws."""

    channels: tuple[str, ...]
    arcsec: tuple[tuple[float | None, ...], ...]
    """Row by row; None where a channel has no reading."""
    marks: tuple[str, ...]
    """Column by column: ``d`` design, ``r`` reference, ``c`` check, ``x`` one that does not count."""
    steps: tuple[int, ...]
    rms_arcsec: tuple[float | None, ...]
    """Of each channel over what counts."""

    def to_document(self) -> dict[str, object]:
        return {
            "channels": self.channels,
            "arcsec": self.arcsec,
            "marks": "".join(self.marks),
            "steps": self.steps,
        }


def heat_map(
    dwells: Sequence[FollowedDwell], taken_back: frozenset[tuple[int, int, int]], outputs: Collection[str]
) -> HeatMap | None:
    """Return the picture of the newest dwells; None where there are too few, or no pitch and roll.

    ``taken_back``: step, attempt and epoch of accepted dwells that no longer count. ``outputs``: the channels of
    sensors. A supply or a temperature has no sensitivity to gravity: in arc seconds it would drown all others.
    """
    dwells = dwells[-MOST_COLUMNS:]
    known = [dwell for dwell in dwells if {"pitch", "roll"} <= dwell.record.measured_deg.keys()]
    counts = np.array([_counts(dwell, taken_back) for dwell in known], dtype=bool)
    if counts.sum() < FEWEST:
        return None
    force = specific_force(*read_back_rad([dwell.record for dwell in known]))
    design = np.column_stack([np.ones(len(known)), force])
    channels = tuple(dict.fromkeys(name for dwell in known for name in dwell.mean if name in outputs))
    means = np.array([[dwell.mean.get(name, np.nan) for dwell in known] for name in channels])
    rows: list[tuple[float | None, ...]] = []
    sizes: list[float | None] = []
    for values in means:
        used = counts & np.isfinite(values)
        if used.sum() < FEWEST:
            rows.append((None,) * len(known))
            sizes.append(None)
            continue
        solved = np.linalg.lstsq(design[used], values[used], rcond=None)[0]
        scale = ARCSEC_PER_RAD / max(float(np.linalg.norm(solved[1:])), 1e-12)
        residual = (values - design @ solved) * scale
        rows.append(tuple(round(float(value), 2) if np.isfinite(value) else None for value in residual))
        sizes.append(float(np.sqrt(np.mean(residual[used] ** 2))))
    marks = tuple(dwell.record.purpose[0] if good else "x" for dwell, good in zip(known, counts, strict=True))
    return HeatMap(channels, tuple(rows), marks, tuple(dwell.record.step for dwell in known), tuple(sizes))


def _counts(dwell: FollowedDwell, taken_back: frozenset[tuple[int, int, int]]) -> bool:
    record = dwell.record
    return record.accepted and (record.step, record.attempt, record.epoch) not in taken_back
