"""Interruptions of the run on figures with a time axis."""

from typing import TYPE_CHECKING

from procedures.report.canvas import FAINT
from procedures.report.view import RunView

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def mark_interruptions(axes: "Axes", view: RunView) -> None:
    """Draw a dashed line where the run stopped; the abscissa is hours since the first dwell."""
    for interruption in view.interruptions:
        hours = (interruption.began_utc - view.started_utc).total_seconds() / 3600.0
        axes.axvline(hours, color=FAINT, linestyle=(0, (3, 2)), linewidth=0.8)


def interruption_caption(view: RunView) -> str:
    """Return what the caption adds where there are such lines."""
    return " Dashed lines: interruptions." if view.interruptions else ""
