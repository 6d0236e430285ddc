"""A design judged before anything is measured: the content of ``calrig design``.

The figures are TP's: V of (53), the mean of the variance function over the box of calibration, times the number of
points, as a square root; the same mean over a narrower usage box; the largest variance in the calibration box. Roll
runs over the full circle in both boxes. A design without roll is judged for the model without roll.
"""

import csv
import io
from pathlib import Path
from typing import Any

from ams.whole_file import write_whole
from procedures.check.request import DesignRequest, requested_design, requested_usage_deg
from procedures.plan.judged_design import JudgedDesign, judge_design


def judge(request: DesignRequest) -> JudgedDesign:
    """Make the design that is asked for and evaluate it.

    Raises: RequestError, PlanError for a design that cannot be made; ams.errors.DesignError for one that cannot
    determine its model.
    """
    return judge_design(requested_design(request), requested_usage_deg(request))


def design_document(judged: JudgedDesign) -> dict[str, Any]:
    """Return the document that ``calrig design --json`` prints."""
    return {
        "points": len(judged.design.points),
        "pitch_points": len(judged.design.pitch_values_deg),
        "roll_points": len(judged.design.roll_values_deg),
        "figure_of_merit_sqrt": judged.figures.figure_of_merit_sqrt,
        "usage_figure_of_merit_sqrt": judged.figures.usage_figure_of_merit_sqrt,
        "max_variance": judged.figures.max_variance,
    }


def design_text(judged: JudgedDesign) -> str:
    """Describe a design and its figures of merit for a person."""
    design, figures = judged.design, judged.figures
    roll = f" × {len(design.roll_values_deg)} roll" if design.has_roll else ", without roll"
    lines = [
        f"design {design.kind}: {len(design.points)} points, {len(design.pitch_values_deg)} pitch{roll}",
        f"V^½ over the calibration range   {figures.figure_of_merit_sqrt:.3f}",
        f"largest variance when calibrating {figures.max_variance:.3g} × the variance of a dwell",
    ]
    if judged.usage_pitch_deg is not None:
        low, high = judged.usage_pitch_deg
        lines.insert(2, f"V_R^½ for use from {low:g}° to {high:g}°   {figures.usage_figure_of_merit_sqrt:.3f}")
    return "\n".join(lines)


def write_design(judged: JudgedDesign, path: Path) -> None:
    """Write the points as CSV, in the form that a procedure reads with ``kind = "file"``."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["pitch_deg", "roll_deg"])
    writer.writerows([point.pitch_deg, point.roll_deg] for point in judged.design.points)
    write_whole(path, text.getvalue().encode("utf-8"))
