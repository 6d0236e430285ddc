"""What a judged cell of the study of silent scenes holds, and what counts as named in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from physics_scenes import SCENES
from silent_declared import THERMOMETER

from ams.analysis.diagnostics.beliefs import SQUARENESS, TABLE_LIMIT
from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration
from ams.finding_kinds import FindingKind
from ams.findings import Finding
from ams.statistics.intervals import t_quantile

LEAST, MOST, NAMED = 0.93, 0.97, 0.95
Line = dict[str, Any]
"""A cell as it is written down."""
Shares = Mapping[str, float]
TABLE = "table"
"""A finding that names the table: a general lack of fit does not count where its curve is beyond the limit."""
RECORDED: FindingKind = "temperature-residual"
"""What is told where the sensor's own temperature is recorded and not modelled."""


@dataclass(frozen=True)
class JudgedCell:
    """Of one cell."""

    after: Shares
    """``offset``, ``k`` and ``prediction`` or ``angle``; what a scene does not have is not there."""
    before: Shares
    named: float | None
    """Share of the campaigns in which the true cause is named, or rows in use are flagged."""
    rings: float | None
    """Share of the campaigns in which anything is told."""
    half_width_arcsec: float | None = None
    """Mean of a prediction's, or of an angle's that nothing flags."""


def significant(findings: Sequence[Finding]) -> set[str]:
    """Return the kinds of findings; one that names the table has its name beside."""
    every = [finding for finding in findings if finding.is_significant]
    of_table = (TABLE_LIMIT, SQUARENESS)
    return {finding.kind for finding in every} | {TABLE for finding in every if finding.details.get("test") in of_table}


def named(
    scene: str, size: float, kinds: Sequence[set[str]], design: Mapping[str, float] = MappingProxyType({})
) -> float | None:
    """Return the share of the campaigns in which the true cause is named; None where nothing is to be found."""
    entry = SCENES[scene]
    if THERMOMETER in design and size > 0.0:
        return float(np.mean([RECORDED in of_campaign for of_campaign in kinds]))
    if entry.true_cause is None or size == 0.0:
        return None
    is_table = scene.startswith("table-")
    right = {TABLE, *entry.also} if is_table else {entry.true_cause, *entry.also}
    return float(np.mean([bool(of_campaign & right) for of_campaign in kinds]))


def holds(axis: AxisCalibration, truth: FloatArray) -> FloatArray:
    """Return whether the 95 % intervals of the first parameters hold the truth."""
    size = truth.size
    half = t_quantile(0.95, axis.primary_dof[:size]) * np.sqrt(np.diag(axis.primary_covariance)[:size])
    return np.asarray(np.abs(axis.primary[:size] - truth) <= half)


def offset_and_k(held: FloatArray) -> Shares:
    """Return the shares of offset and sensitivities."""
    return {"offset": float(held[:, 0].mean()), "k": float(held[:, 1:].mean())}


def verdict(line: Line) -> str:
    """Return held, wide, told or outside."""
    shares = shares_of(line)
    if min(shares) >= LEAST:
        return "wide" if max(shares) > MOST else "held"
    return "told" if line["named"] is not None and line["named"] >= NAMED else "outside"


def shares_of(line: Line) -> list[float]:
    """Return those that have to hold; zero where every row is flagged."""
    shares = line["after"]
    return [shares[name] for name in ("offset", "k", "prediction", "angle") if name in shares] or [0.0]
