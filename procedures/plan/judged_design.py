"""A design judged before anything is measured: figures of merit over the calibration and the usage range."""

from dataclasses import dataclass
from math import radians

from ams.analysis.design_variance import AngleBox, DesignEvaluation, evaluate_design
from ams.analysis.design_without_roll import evaluate_without_roll
from procedures.plan.designs import Design
from procedures.plan.specific_force import attitudes_rad


@dataclass(frozen=True)
class JudgedDesign:
    """A design and its figures."""

    design: Design
    usage_pitch_deg: tuple[float, float] | None
    figures: DesignEvaluation


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
