"""The picture of a design: where its points lie, and how well it predicts along pitch (TP figures 2 to 5 and 21)."""

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ams.analysis.design_variance import variance_function
from ams.analysis.design_without_roll import variance_without_roll
from ams.arrays import FloatArray
from ams.whole_file import write_whole
from procedures.errors import RequestError
from procedures.plan.judged_design import JudgedDesign
from procedures.plan.specific_force import attitudes_rad
from procedures.report import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

FORMATS = (".svg", ".png", ".pdf")
PITCH_STATIONS, ROLL_STATIONS = 181, 73


def plot_design(judged: JudgedDesign, path: Path) -> None:
    """Draw into an SVG, PNG or PDF file.

    Raises: RequestError for another ending, WriteFailed where it cannot be written.
    """
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise RequestError(f"design: --plot: got {path.name!r}, allowed are names that end in {', '.join(FORMATS)}")
    with canvas.style():
        figure = canvas.canvas(3.3)
        points, along = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.085, right=0.985, top=0.9, bottom=0.14, wspace=0.24)
        pitch_deg, roll_deg = (np.rad2deg(angle) for angle in attitudes_rad(judged.design))
        canvas.plain_axes(points)
        points.plot(roll_deg, pitch_deg, "o", color=canvas.BLUE, markersize=2.5)
        canvas.angle_ticks(points, roll_deg, 8.0)
        canvas.pitch_ticks(points, pitch_deg)
        points.set(xlabel="roll (°)", ylabel="pitch (°)")
        points.set_title(f"design {judged.design.kind}: {len(judged.design.points)} points", loc="left")
        _draw_variance(along, judged)
        write_picture(figure, path)


def write_picture(figure: "Canvas", path: Path) -> None:
    """Write a figure in the format that the name ends in. Raises: WriteFailed."""
    ending = path.suffix.lower()
    write_whole(path, canvas.to_svg(figure) if ending == ".svg" else _to_bytes(figure, ending[1:]))


def variance_along_pitch(judged: JudgedDesign) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pitch stations (°) over the calibration range, and the least and the greatest √(K·σ_v²/σ_E²) over roll there."""
    pitch_rad, roll_rad = attitudes_rad(judged.design)
    stations = np.linspace(pitch_rad.min(), pitch_rad.max(), PITCH_STATIONS)
    if judged.design.has_roll:
        circle = np.linspace(-np.pi, np.pi, ROLL_STATIONS)
        variance = variance_function(pitch_rad, roll_rad, *np.meshgrid(stations, circle, indexing="ij"))
    else:
        variance = variance_without_roll(pitch_rad, stations)[:, None]
    normalised = np.sqrt(pitch_rad.size * variance)
    return np.rad2deg(stations), normalised.min(axis=1), normalised.max(axis=1)


def _draw_variance(axes: "Axes", judged: JudgedDesign) -> None:
    pitch_deg, least, greatest = variance_along_pitch(judged)
    canvas.plain_axes(axes)
    axes.fill_between(pitch_deg, least, greatest, color=canvas.SKY, alpha=0.4, linewidth=0.0)
    axes.plot(pitch_deg, greatest, color=canvas.BLUE)
    axes.axhline(judged.figures.figure_of_merit_sqrt, color=canvas.FAINT, linestyle="--", linewidth=0.8)
    if judged.usage_pitch_deg is not None:
        axes.axvspan(*judged.usage_pitch_deg, color=canvas.GREEN, alpha=0.12, linewidth=0.0)
    canvas.angle_ticks(axes, pitch_deg, 8.0)
    axes.set_ylim(0.95 * float(least.min()), 1.05 * float(greatest.max()))
    axes.set(xlabel="pitch (°)", ylabel="√K · σ of the output / σ of a dwell")
    axes.set_title(f"V^½ = {judged.figures.figure_of_merit_sqrt:.3f} (dashed); band: over roll", loc="left")


def _to_bytes(figure: "Canvas", form: str) -> bytes:
    """Return PNG or PDF without a date, so that the same design is the same file."""
    buffer = BytesIO()
    dated = {"Software": None} if form == "png" else {"CreationDate": None, "Creator": None}
    figure.savefig(buffer, format=form, dpi=150, metadata=dated)
    return buffer.getvalue()
