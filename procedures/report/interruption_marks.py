"""Interruptions of the run on figures with a time axis."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ams.arrays import FloatArray
from procedures.report.canvas import FAINT, INK
from procedures.report.view import RunView

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def mark_interruptions(axes: "Axes", view: RunView) -> None:
    """Draw a dashed line where the run stopped; the abscissa is hours since the first dwell."""
    for hours in _hours(view):
        axes.axvline(hours, color=FAINT, linestyle=(0, (3, 2)), linewidth=0.8)


def mark_interruptions_between(axes: "Axes", view: RunView, visit_hours: FloatArray) -> None:
    """Draw a dashed line between the visits where the run stopped; the abscissa is the number of a visit from 0."""
    for hours in _hours(view):
        between = float(np.searchsorted(visit_hours, hours)) - 0.5
        axes.axvline(between, color=INK, linestyle=(0, (3, 2)), linewidth=0.8)


def _hours(view: RunView) -> Iterator[float]:
    """Yield when the run stopped, in hours since its first dwell."""
    return ((entry.began_utc - view.started_utc).total_seconds() / 3600.0 for entry in view.interruptions)


def interruption_caption(view: RunView) -> str:
    """Return what the caption adds where there are such lines."""
    return " Dashed lines: interruptions." if view.interruptions else ""
