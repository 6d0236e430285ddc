"""How often each finding names its cause, and what the intervals hold meanwhile, written as Markdown.

    PYTHONPATH=tests/support python docs/studies/findings.py OUTPUT_FILE [CAMPAIGNS [SCENE …]]

The campaigns are those of ``tests/support/physics_scenes``, drawn from physics by people who had not read the
estimator: 13 × 12 points, six replications, 1.65 arc seconds a dwell. One axis of each is solved as ``calrig fit``
solves it, terms of second and third order included.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from physics_scenes import SCENES, Campaign, campaigns
from solved_campaigns import columns_of, rows_of, rows_of_package

from ams.arrays import FloatArray
from ams.calibration.packages import calibrate_packages
from ams.calibration.solving.columns import solve_columns
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.models.extended import ExtendedPitchRoll, centring_of
from ams.statistics.intervals import t_quantile

CAMPAIGNS = 400
SEED = 20
AXIS = "x"
ESTIMATED = ("temperature-lag", "temperature-curvature")
"""Scenes in which temperature coefficients are asked for."""
WITH_TEMPERATURE = CalibrationRequest(temperature="estimate", reference_temperature_degc=20.0)
LINES: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("clean", (0.0,)),
    ("wrong-dwell", (3.0, 5.0, 6.0, 8.0, 1500.0)),
    ("outliers", (3.0, 5.0, 10.0, 20.0)),
    ("k2", (0.5, 1.0, 2.0, 5.0)),
    ("k3", (1.0, 2.0, 5.0, 10.0, 20.0)),
    ("k0-asymmetry", (2.0, 5.0, 10.0, 20.0)),
    ("soft-mount", (1.0, 2.0, 5.0, 10.0)),
    ("cross-coupling", (1.0, 2.0, 5.0, 10.0)),
    ("drift-replications", (0.2, 0.5, 1.0, 5.0)),
    ("drift-linear", (0.2, 0.5, 1.0, 5.0)),
    ("drift-correlated", (0.5, 1.0, 2.0)),
    ("temperature-in-step", (0.02, 0.05, 0.1, 0.2, 0.5)),
    ("temperature-alternating", (0.02, 0.05, 0.1, 0.2)),
    ("temperature-lag", (0.1, 0.15, 0.3)),
    ("temperature-curvature", (0.05, 0.3, 1.0)),
)
HEAD = """# What the findings name

Made by `PYTHONPATH=tests/support python docs/studies/findings.py docs/studies/findings.md`: {campaigns} simulated
campaigns a line, one axis of each by itself, 13 × 12 points, six replications, 1.65″ a dwell, scenes from physics
(`tests/support/physics_scenes`); temperature coefficients are estimated where the scene is of them. *Rings*: any
finding is significant. *Cause*: a finding names the true cause. *Also*: or one that says the same of the same data.
*Wrong*: of a kind that is neither. *Before*: lack of fit or drift rang, which was all that was tested before there were
findings, five tests under one correction. *Offset* and *k*: 95 % intervals that hold the offset and the sensitivities
of the best linear sensor over the design.
"""
TABLE = """
## {name}

{physics}

| size, {unit} | rings | cause | cause or also | wrong | before | offset | k |
|---|---|---|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Line:
    """Shares over all campaigns of one size."""

    rings: float
    cause: float
    cause_or_also: float
    wrong: float
    before: float
    offset: float
    sensitivities: float


@dataclass(frozen=True)
class JudgedCampaign:
    """One campaign's axis."""

    findings: tuple[Finding, ...]
    before: bool
    primary: FloatArray
    half: FloatArray


def line(name: str, size: float, count: int, chance: np.random.Generator) -> Line:
    """Return the shares of one scene at one size."""
    drawn = campaigns(name, size, chance, count)
    judged = list(_solved(drawn, WITH_TEMPERATURE if name in ESTIMATED else CalibrationRequest()))
    before = [campaign.before for campaign in judged] if name in ESTIMATED else _rang_before(drawn)
    kinds = [{finding.kind for finding in campaign.findings if finding.is_significant} for campaign in judged]
    # A wrong dwell has an axis of its own; only campaigns in which it is this axis have anything to be named.
    struck = np.ones(count, dtype=bool)
    if name == "wrong-dwell" and drawn.event is not None:
        struck = drawn.event.axis == drawn.setup.axes.index(AXIS)
    # The causes of a size beyond nothing, whatever was declared.
    entry = SCENES[name]
    cause = {entry.true_cause} if size > 0.0 and entry.true_cause else set()
    right = cause | (set(entry.also) if cause else set())
    truth = _truth(drawn)
    held = np.stack(
        [np.abs(campaign.primary[:4] - true) <= campaign.half[:4] for campaign, true in zip(judged, truth, strict=True)]
    )
    chosen = [found for found, is_struck in zip(kinds, struck, strict=True) if is_struck]
    return Line(
        rings=_share(bool(found) for found in chosen),
        cause=_share(bool(found & cause) for found in chosen),
        cause_or_also=_share(bool(found & right) for found in chosen),
        wrong=_share(bool(found - right) for found in kinds),
        before=_share(rang for rang, is_struck in zip(before, struck, strict=True) if is_struck),
        offset=float(held[:, 0].mean()),
        sensitivities=float(held[:, 1:].mean()),
    )


def _rang_before(drawn: Campaign) -> Sequence[bool]:
    """Return by campaign whether lack of fit or a drift rang over all of its dwells, a wrong one among them."""
    rows = rows_of(drawn)
    centring = centring_of(rows, len(drawn.points_deg), AXIS)
    assert centring is not None
    models = [ExtendedPitchRoll(AXIS, centring)] * drawn.campaigns
    tests = solve_columns(rows, columns_of(drawn, AXIS), models).replication
    assert tests is not None
    every = (tests.lack_of_fit, *tests.drift.values())
    return [any(bool(test.is_significant[index]) for test in every) for index in range(drawn.campaigns)]


def _share(flags: Iterator[bool]) -> float:
    return float(np.mean(list(flags)))


def _truth(drawn: Campaign) -> FloatArray:
    """(n, 4) offset and k of the best linear sensor over the design."""
    index, points = drawn.setup.axes.index(AXIS), drawn.points_deg
    offset, k = drawn.package.best_linear(points[:, 0], points[:, 1])
    return np.concatenate([offset[:, 0, index, None], k[:, 0, index]], axis=-1)


def _solved(drawn: Campaign, request: CalibrationRequest) -> Iterator[JudgedCampaign]:
    for index in range(drawn.campaigns):
        rows = rows_of_package(drawn, index)
        seen = replace(rows, outputs={AXIS: rows.outputs[AXIS]})
        yield _of_axis(calibrate_packages({AXIS: seen}, request)[AXIS].axes[AXIS])


def _of_axis(axis: AxisCalibration) -> JudgedCampaign:
    half = t_quantile(0.95, axis.primary_dof) * np.sqrt(np.diag(axis.primary_covariance))
    assert axis.replication is not None
    tests = (axis.replication.lack_of_fit, *axis.replication.drift.values())
    return JudgedCampaign(axis.findings, any(test.p_value <= 0.05 / len(tests) for test in tests), axis.primary, half)


def page(campaigns_a_line: int, lines: Mapping[str, tuple[float, ...]]) -> Iterator[str]:
    """Yield the page, piece by piece."""
    yield HEAD.format(campaigns=campaigns_a_line)
    for name, sizes in lines.items():
        entry = SCENES[name]
        yield TABLE.format(name=name, physics=entry.physics.split("\n")[0], unit=entry.unit)
        for size in sizes:
            found = line(name, size, campaigns_a_line, np.random.default_rng(SEED))
            has_cause = size > 0.0 and entry.true_cause is not None
            named = (found.cause, found.cause_or_also) if has_cause else (None, None)
            cells = (found.rings, *named, found.wrong, found.before, found.offset, found.sensitivities)
            yield f"| {size:g} | {' | '.join('—' if cell is None else f'{cell:.3f}' for cell in cells)} |\n"


if __name__ == "__main__":
    wanted = int(sys.argv[2]) if len(sys.argv) > 2 else CAMPAIGNS
    with Path(sys.argv[1]).open("w", encoding="utf-8") as file:
        chosen = {name: sizes for name, sizes in LINES if name in sys.argv[3:] or not sys.argv[3:]}
        for piece in page(wanted, chosen):
            file.write(piece)
            file.flush()
