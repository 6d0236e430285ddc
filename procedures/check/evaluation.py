"""A design judged before anything is measured: the content of ``calrig design``.

The figures are TP's: V of (53), the mean of the variance function over the box of calibration, times the number of
points, as a square root; the same mean over a narrower usage box; the largest variance in the calibration box. Roll
runs over the full circle in both boxes. A design without roll is judged for the model without roll.
"""

import csv
import io
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from ams.analysis.design_variance import AngleBox, DesignEvaluation, evaluate_design
from ams.analysis.design_without_roll import evaluate_without_roll
from ams.arrays import FloatArray
from ams.whole_file import write_whole
from procedures.check.request import DesignRequest, requested_design, requested_usage_deg
from procedures.plan.designs import Design
from procedures.plan.specific_force import equivalent_rad


@dataclass(frozen=True)
class JudgedDesign:
    """A design and its figures."""

    design: Design
    usage_pitch_deg: tuple[float, float] | None
    figures: DesignEvaluation


def judge(request: DesignRequest) -> JudgedDesign:
    """Make the design that is asked for and evaluate it.

    Raises: RequestError, PlanError for a design that cannot be made; ams.errors.DesignError for one that cannot
    determine its model.
    """
    return judge_design(requested_design(request), requested_usage_deg(request))


def judge_design(design: Design, usage_pitch_deg: tuple[float, float] | None) -> JudgedDesign:
    """Evaluate a design. Raises: ams.errors.DesignError."""
    pitch_rad, roll_rad = attitudes_rad(design)
    box = (float(pitch_rad.min()), float(pitch_rad.max()))
    usage = None if usage_pitch_deg is None else (radians(usage_pitch_deg[0]), radians(usage_pitch_deg[1]))
    if design.has_roll:
        figures = evaluate_design(pitch_rad, roll_rad, AngleBox(box), None if usage is None else AngleBox(usage))
    else:
        figures = evaluate_without_roll(pitch_rad, box, usage)
    return JudgedDesign(design, usage_pitch_deg, figures)


def design_document(judged: JudgedDesign) -> dict[str, Any]:
    """The form of ``calrig design --json``."""
    return {
        "points": len(judged.design.points),
        "pitch_points": len(judged.design.pitch_values_deg),
        "roll_points": len(judged.design.roll_values_deg),
        "figure_of_merit_sqrt": judged.figures.figure_of_merit_sqrt,
        "usage_figure_of_merit_sqrt": judged.figures.usage_figure_of_merit_sqrt,
        "max_variance": judged.figures.max_variance,
    }


def design_text(judged: JudgedDesign) -> str:
    """The same for a person."""
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
    """The points as CSV, in the form that a procedure reads with ``kind = "file"``."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["pitch_deg", "roll_deg"])
    writer.writerows([point.pitch_deg, point.roll_deg] for point in judged.design.points)
    write_whole(path, text.getvalue().encode("utf-8"))


def attitudes_rad(design: Design) -> tuple[FloatArray, FloatArray]:
    """(K,) pitch and roll of the points; on a gimbal those without yaw at which a model package feels the same."""
    if len(design.yaw_values_deg) > 1:
        return equivalent_rad(design.points)
    pitch, roll = ([getattr(point, key) for point in design.points] for key in ("pitch_deg", "roll_deg"))
    return np.deg2rad(np.array(pitch)), np.deg2rad(np.array(roll))
