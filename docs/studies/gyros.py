"""What the intervals of gyros hold, and what is told, written as Markdown.

    PYTHONPATH=tests/support python docs/studies/gyros.py OUTPUT_FILE [CAMPAIGNS [SCENE …]]

The campaigns are those of ``tests/support/physics_scenes``: six positions, seven rates to ±100 °/s, 20 µV a dwell,
1.25 V/(°/s). All three axes of each are solved as ``calrig fit --model gyro`` solves them. The truth of offset and
scale factor is the straight line that comes closest to the outputs without noise, as IEEE Std 528 has it.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from physics_scenes import SCENES, GyroRates, campaigns
from solved_campaigns import rows_of_gyros, velocity_dps_of

from ams.analysis.predictions import model_of_solution, prediction_halfwidth_v
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import AXES, Attitude, euler_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.models.extended import linear_part
from ams.statistics.intervals import t_quantile

CAMPAIGNS = 400
CLEAN_CAMPAIGNS = 2000
REPLICATIONS = 6
LEVEL = 0.95
SEED = 20
SHOWN = ("gyro-nonlinearity", "gyro-asymmetry")
Terms = Literal["no", "yes"]


@dataclass(frozen=True)
class Cell:
    """Shares of axes, and of campaigns where it says so."""

    offset: float
    scale_factor: float
    prediction: float
    named: float
    """Campaigns in which a finding of some axis has the cause."""
    rings: float
    """Campaigns in which anything is significant."""


def cell_of(scene: str, size: float, count: int, terms: Terms) -> Cell:
    """Count one cell of the table."""
    drawn: GyroRates = campaigns(scene, size, np.random.default_rng(SEED), count, replications=REPLICATIONS)
    clean: GyroRates = campaigns(
        scene, size, np.random.default_rng(SEED), count, replications=REPLICATIONS, dwell_noise_v=0.0
    )
    chance, causes = np.random.default_rng(SEED + 1), set(SCENES[scene].causes(size))
    held: dict[str, list[float]] = {"offset": [], "scale factor": [], "prediction": []}
    named, rings = 0, 0
    for campaign in range(count):
        rows, velocity = rows_of_gyros(drawn, campaign), velocity_dps_of(drawn)
        exact = rows_of_gyros(clean, campaign).outputs
        request = CalibrationRequest(model="gyro", nominal_axes={axis: axis for axis in AXES}, extended=terms)
        solved = calibrate(rows, request).axes
        for index, label in enumerate(AXES):
            for name, share in _held(solved[label], index, exact[label], velocity, drawn, chance).items():
                held[name].append(share)
        kinds = {f.kind for axis in solved.values() for f in axis.findings if f.is_significant}
        named, rings = named + bool(causes & kinds), rings + bool(kinds)
    means = {name: float(np.mean(shares)) for name, shares in held.items()}
    return Cell(means["offset"], means["scale factor"], means["prediction"], named / count, rings / count)


def _held(
    axis: AxisCalibration,
    index: int,
    exact_v: FloatArray,
    velocity_dps: FloatArray,
    drawn: GyroRates,
    chance: np.random.Generator,
) -> Mapping[str, float]:
    line = np.linalg.lstsq(linear_part(velocity_dps), exact_v, rcond=None)[0]
    halfwidth = t_quantile(LEVEL, axis.primary_dof) * np.sqrt(np.diag(axis.primary_covariance))
    inside = np.abs(axis.primary[:4] - line) <= halfwidth[:4]
    points = velocity_dps.shape[0] // REPLICATIONS
    still, reading_v = np.zeros(points), drawn.setup.dwell_noise_v
    rates = euler_rates_rad_s(np.zeros((points, 3)), np.deg2rad(velocity_dps[:points]))
    at = Attitude(still, still, still, euler_rate_rad_s=rates)
    new = exact_v[:points] + reading_v * chance.standard_normal(points)
    far = np.abs(new - model_of_solution(axis).predict(axis.primary, at))
    covered = far <= prediction_halfwidth_v(axis, at, reading_v, level=LEVEL)
    return {
        "offset": float(inside[0]),
        "scale factor": float(inside[1 + index]),
        "prediction": float(covered.mean()),
    }


def verdict(cell: Cell) -> str:
    """Return held, wide, told or outside, as the study of what is silent has them."""
    shares = (cell.offset, cell.scale_factor, cell.prediction)
    if min(shares) >= 0.93:
        return "held" if max(shares) <= 0.97 else "wide"
    return "told" if cell.named >= 0.95 else "**outside**"


def page(count: int, shown: tuple[str, ...]) -> Iterator[str]:
    """Yield the lines of the page."""
    yield "# What the intervals of gyros hold"
    yield ""
    yield (
        f"Made by `PYTHONPATH=tests/support python docs/studies/gyros.py docs/studies/gyros.md`: {count} campaigns a "
        "cell, three axes each, from `tests/support/physics_scenes`: six positions, seven rates to ±100 °/s, "
        f"{REPLICATIONS} replications, 20 µV a dwell (0.16 ppm of the output at 100 °/s)."
    )
    yield ""
    yield (
        "*b*, *k*, *prediction*: shares of 95 % intervals that hold offset and scale factor of the straight line that "
        "comes closest to the outputs (IEEE Std 528), and a reading at a rate of the design. *Named*: campaigns in "
        "which a finding of some axis has the cause; *rings*: in which anything is significant. *Before*: no terms of "
        'second and third order in the model (`extended = "no"`). *Held*: every share from 0.93 to 0.97; *wide*: none '
        "below, some above; *told*: below, and named in 95 %."
    )
    yield ""
    yield "| scene | size | b | k | prediction | named | rings | before: b | k | prediction | verdict |"
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for name in shown:
        scene = SCENES[name]
        for size in scene.sizes:
            yield _row(name, f"{size:g} {scene.unit}", cell_of(name, size, count, "yes"), name, size, count)
    clean = cell_of(shown[0], 0.0, CLEAN_CAMPAIGNS, "yes")
    yield ""
    yield f"Where nothing is wrong something rings in {clean.rings:.2%} of {CLEAN_CAMPAIGNS} campaigns."


def _row(label: str, size_text: str, cell: Cell, name: str, size: float, count: int) -> str:
    before = cell_of(name, size, count, "no")
    shares = (cell.offset, cell.scale_factor, cell.prediction, cell.named, cell.rings)
    old = (before.offset, before.scale_factor, before.prediction)
    cells = [label, size_text, *(f"{share:.3f}" for share in (*shares, *old)), verdict(cell)]
    return f"| {' | '.join(cells)} |"


def main(output: Path, count: int, shown: tuple[str, ...]) -> None:
    """Write the page."""
    output.write_text("\n".join(page(count, shown)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    given = sys.argv[2:]
    main(Path(sys.argv[1]), int(given[0]) if given else CAMPAIGNS, tuple(given[1:]) or SHOWN)
