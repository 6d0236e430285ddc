"""Panels as TP draws them: a symbol for each replication, confidence dotted, prediction dash-dotted, 1e-4 degrees."""

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from tp_study.judged import Inferred, band, residuals

from ams.calibration_result import AxisCalibration
from ams.observations import Observations
from procedures.report.bands import Along
from procedures.report.canvas import BLUE, FAINT, GRID, INK, SYMBOL_SIZES, angle_ticks, canvas, series_style, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

DPI = 130
COLOURS = 128
DOTTED, DASH_DOTTED = (0, (1, 1.5)), (0, (6, 2, 1, 2))
DODGE_SHARE, WIDEST_DODGE = 0.5, 0.03
"""Replications stand side by side over this share of the smallest step, and of the whole span."""


def save(path: Path, height_in: float, draw: "Callable[[Figure], None]") -> None:
    """One PNG of a few colours, which takes a third of the room."""
    from PIL import Image

    buffer = BytesIO()
    with style():
        figure = canvas(height_in)
        figure.set_layout_engine("constrained")
        draw(figure)
        figure.savefig(buffer, format="png", dpi=DPI)
    with Image.open(buffer) as picture:
        picture.convert("RGB").quantize(COLOURS).save(path, optimize=True)


def residual_panel(
    panel: "Axes", title: str, axis: AxisCalibration, observations: Observations, along: Along = "pitch"
) -> None:
    """Residuals of every replication with both bands; thin and blue the confidence by TP's pooled covariance."""
    _symbols(panel, _angle(observations, along), residuals(axis), observations.replication)
    reported = band(axis, observations, along)
    _both_signs(panel, reported.angle_deg, reported.confidence_v, INK, DOTTED)
    _both_signs(panel, reported.angle_deg, reported.prediction_v, INK, DASH_DOTTED)
    pooled = band(axis, observations, along, pooled=True)
    _both_signs(panel, pooled.angle_deg, pooled.confidence_v, BLUE, DOTTED)
    dress(panel, title, observations, along, "residual")


def inferred_panel(
    panel: "Axes",
    title: str,
    found: Inferred,
    observations: Observations,
    along: Along = "pitch",
    replication: int | None = None,
    limit: float | None = None,
) -> None:
    """Errors of an inferred angle, all replications or one, with the widest bands at each angle."""
    angle = _angle(observations, along)
    here = np.isfinite(found.error) & ((observations.replication == replication) if replication else True)
    _symbols(panel, angle[here], found.error[here], observations.replication[here])
    stations = np.unique(angle[here])
    for half, dashes in ((found.confidence, DOTTED), (found.prediction, DASH_DOTTED)):
        widest = np.array([np.nanmax(half[here & (angle == station)]) for station in stations])
        _both_signs(panel, stations, widest, INK, dashes)
    dress(panel, title, observations, along, "error")
    if limit is not None:
        panel.set_ylim(-limit, limit)
        note_outside(panel, found.error, limit)


def note_outside(panel: "Axes", error: FloatArray, limit: float) -> None:
    """What the frame hides is counted in it."""
    hidden, withheld = int(np.sum(np.abs(error) > limit)), int(np.isnan(error).sum())
    text = f"outside {hidden}, withheld as singular {withheld}"
    behind = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85}
    panel.text(0.99, 0.02, text, transform=panel.transAxes, ha="right", fontsize=6.5, bbox=behind)


def curve_panel(
    panel: "Axes",
    title: str,
    values: FloatArray,
    observations: Observations,
    along: Along,
    other_deg: Sequence[float],
) -> None:
    """The first replication as curves, one for each value of the other angle."""
    import matplotlib

    angle, other = _angle(observations, along), _angle(observations, "roll" if along == "pitch" else "pitch")
    first = observations.replication == observations.replication.min()
    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.92, len(other_deg)))
    for value, colour in zip(other_deg, colours, strict=True):
        rows = np.flatnonzero(first & (np.abs(other - value) < 1e-6))
        rows = rows[np.argsort(angle[rows])]
        panel.plot(angle[rows], values[rows], color=colour, linewidth=0.9, label=f"{value:g}°")
    dress(panel, title, observations, along, "replication 1")
    panel.legend(ncols=1, fontsize=5.5, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.0)


def dress(panel: "Axes", title: str, observations: Observations, along: Along, what: str) -> None:
    panel.set_title(title, loc="left")
    panel.set_xlabel(f"{along} (°)")
    panel.set_ylabel(f"{what} (10⁻⁴ °)")
    panel.grid(visible=True, color=GRID, linewidth=0.5)
    panel.axhline(0.0, color=FAINT, linewidth=0.6)
    angle_ticks(panel, _angle(observations, along), most=8.5)


def _angle(observations: Observations, along: Along) -> FloatArray:
    return np.rad2deg(observations.pitch_rad if along == "pitch" else observations.roll_rad).round(6)


def _symbols(panel: "Axes", angle: FloatArray, values: FloatArray, replication: NDArray[np.int64]) -> None:
    labels = np.unique(replication)
    steps = np.diff(np.unique(angle))
    width = min(DODGE_SHARE * float(steps.min()), WIDEST_DODGE * float(np.ptp(angle))) if steps.size else 0.0
    for index, label in enumerate(labels):
        colour, symbol = series_style(index, labels.size)
        rows = replication == label
        aside = width * ((index + 0.5) / labels.size - 0.5)
        size = 2.0 * SYMBOL_SIZES.get(symbol, 1.0)
        panel.plot(
            angle[rows] + aside, values[rows], symbol, color=colour, markersize=size, markeredgewidth=0.0, alpha=0.8
        )


def _both_signs(panel: "Axes", angle: FloatArray, half: FloatArray, colour: str, dashes: object) -> None:
    for sign in (1.0, -1.0):
        panel.plot(angle, sign * half, color=colour, linestyle=dashes, linewidth=0.9)
