"""Attitudes as pictures: each angle along the rows with its band, as CR has them, and its spread along pitch, as TP.

The left panels show an angle over the rows with two standard deviations about it, rows with a flag marked below; the
right ones its standard deviation against pitch, which is where the singular attitudes show. Source: CR figures 6 to 10
and 20 to 23; TP figures 6 to 20.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.frames import ANGLES
from procedures.report import canvas
from procedures.report.canvas import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROW_IN, HEAD_IN = 1.9, 0.65
CAPTION = (
    "Left: each angle along the rows, with two standard deviations about it; marks below: rows with a flag. "
    "Right: standard deviation against pitch."
)


def attitude_figure(sensor: str, row: IntArray, columns_deg: Mapping[str, FloatArray], is_flagged: BoolArray) -> Figure:
    """Draw (N,) answers by the number of their row; an angle that a row does not tell is a gap."""
    names = [name for name in ANGLES if f"{name}_deg" in columns_deg]
    with canvas.style():
        figure = canvas.canvas(HEAD_IN + ROW_IN * len(names))
        grid = figure.subplots(len(names), 2, squeeze=False, gridspec_kw={"width_ratios": [1.7, 1.0]})
        pitch = columns_deg.get("pitch_deg", np.full(row.size, np.nan))
        for (along, spread), name in zip(grid, names, strict=True):
            value, sd = columns_deg[f"{name}_deg"], columns_deg[f"{name}_sd_deg"]
            _draw_along(along, name, row, (value, sd), is_flagged)
            _draw_spread(spread, name, pitch, sd)
        grid[-1][0].set_xlabel("row")
        grid[-1][1].set_xlabel("pitch, degrees")
        figure.suptitle(f"{sensor}: {row.size} rows drawn", fontsize=9.5, x=0.01, ha="left")
        figure.tight_layout(rect=(0.0, 0.0, 1.0, 0.985))
        svg = canvas.to_svg(figure)
    return Figure(f"attitude-{sensor}", f"Attitude by {sensor}", CAPTION, svg)


def _draw_along(
    axes: "Axes", name: str, row: IntArray, angle: tuple[FloatArray, FloatArray], is_flagged: BoolArray
) -> None:
    value, sd = angle
    is_large = row.size > canvas.RASTERISE_FROM
    canvas.plain_axes(axes)
    axes.fill_between(
        row, value - 2.0 * sd, value + 2.0 * sd, color=canvas.SKY, alpha=0.35, linewidth=0.0, rasterized=is_large
    )
    axes.plot(row, value, color=canvas.BLUE, linewidth=0.8, rasterized=is_large)
    marked = row[is_flagged]
    axes.plot(
        marked, np.full(marked.size, 0.02), "|", color=canvas.RED, markersize=5, rasterized=is_large,
        transform=axes.get_xaxis_transform(),
    )  # fmt: skip
    axes.set_ylabel(f"{name}, degrees")


def _draw_spread(axes: "Axes", name: str, pitch: FloatArray, sd: FloatArray) -> None:
    canvas.plain_axes(axes)
    is_drawn = np.isfinite(pitch) & np.isfinite(sd)
    is_large = pitch.size > canvas.RASTERISE_FROM
    axes.plot(pitch[is_drawn], sd[is_drawn], ".", color=canvas.INK, markersize=2.0, rasterized=is_large)
    axes.set_ylim(bottom=0.0, top=1.15 * float(sd[is_drawn].max()) if is_drawn.any() and sd[is_drawn].any() else None)
    axes.set_ylabel(f"s. d. of {name}, degrees")
