"""How well the design knows every attitude, whatever the sensor: the variance function of TP as a map.

Source: TP (51), (52), theorems I to III: with independent errors of one size the variance of the fitted output over
that of a dwell depends on the attitudes visited alone.
"""

from typing import TYPE_CHECKING

import numpy as np

from ams.analysis.design_variance import PITCH_ROLL_TERMS, design_rank, variance_function
from procedures.report.canvas import FAINT, INK, Figure, angle_ticks, canvas, pitch_ticks, plain_axes, to_svg
from procedures.report.view import DesignView

if TYPE_CHECKING:
    from matplotlib.cm import ScalarMappable

STATIONS = 73
LEVELS = 8


def variance_map(design: DesignView) -> Figure | None:
    """Draw √(φᵀP⁻¹φ) over the box of attitudes visited; None where the attitudes do not determine four terms.

    Call inside ``canvas.style()``.
    """
    pitch, roll = np.deg2rad(design.pitch_deg), np.deg2rad(design.roll_deg)
    if design.points < PITCH_ROLL_TERMS or design_rank(pitch, roll) < PITCH_ROLL_TERMS:
        return None
    at_pitch, at_roll = np.meshgrid(
        np.linspace(pitch.min(), pitch.max(), STATIONS), np.linspace(roll.min(), roll.max(), STATIONS), indexing="ij"
    )
    spread = np.sqrt(variance_function(pitch, roll, at_pitch, at_roll) / design.replications)
    return Figure(
        "design-variance",
        "Variance map of the design",
        "Standard deviation of the fitted output over that of one dwell, at every attitude of the range calibrated, "
        f"for independent errors and {design.replications} replication{'' if design.replications == 1 else 's'} of "
        f"the design (dots; {design.attitudes_in_words}). "
        f"It lies between {spread.min():.4f} and {spread.max():.4f} and depends "
        "on the design alone. Source: TP (52).",
        _drawn(design, np.rad2deg(at_pitch), np.rad2deg(at_roll), spread),
    )


def _drawn(design: DesignView, at_pitch_deg: np.ndarray, at_roll_deg: np.ndarray, spread: np.ndarray) -> bytes:
    figure = canvas(2.9)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.885, top=0.96, bottom=0.16)
    plain_axes(axes)
    axes.grid(visible=False)
    flat = np.ptp(spread) < 1e-9 * spread.max()
    if flat:  # the tumble with roll: the same everywhere, which no contour shows
        marks: ScalarMappable = axes.pcolormesh(
            at_roll_deg, at_pitch_deg, spread, cmap="cividis", shading="nearest", rasterized=True
        )
    else:
        marks = axes.contourf(at_roll_deg, at_pitch_deg, spread, levels=LEVELS, cmap="cividis")
        lines = axes.contour(at_roll_deg, at_pitch_deg, spread, levels=LEVELS, colors="white", linewidths=0.5)
        axes.clabel(lines, fontsize=6.5, fmt="%.4g")
    axes.plot(
        design.roll_deg, design.pitch_deg, "o", color="white", markersize=2.6, markeredgecolor=INK, clip_on=False,
        markeredgewidth=0.4,
    )  # fmt: skip
    angle_ticks(axes, design.roll_deg)
    pitch_ticks(axes, design.pitch_deg)
    axes.set(xlabel="roll (°)", ylabel="pitch (°)")
    axes.tick_params(color=FAINT)
    bar = figure.colorbar(marks, cax=figure.add_axes((0.9, 0.16, 0.014, 0.8)))
    bar.set_label("σ of the fit / σ of a dwell")
    bar.outline.set_linewidth(0.4)
    return to_svg(figure)
