"""Errors of the angles that users will infer with the new coefficients, with their expanded uncertainty.

What a tunnel cares about is an angle, not a voltage: the set is applied to the run's own outputs, and the inferred
angles are compared with those of the table. Source: TP 6; decision rules as in :mod:`ams.surveillance.adjustment`.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ams.surveillance.attitude_errors import AngleErrors
from procedures.report.canvas import (
    BLUE,
    FAINT,
    INK,
    RASTERISE_FROM,
    RED,
    Figure,
    angle_ticks,
    canvas,
    plain_axes,
    to_svg,
)
from procedures.report.view import SensorView

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MILLIDEGREE = 1e3


def angle_error_figure(sensor: SensorView) -> Figure | None:
    """Draw one row an angle, against pitch and against roll; None where the model tells no angles.

    Call inside ``canvas.style()``.
    """
    if sensor.adjustment is None or not sensor.adjustment.as_left.errors:
        return None
    as_left, limits = sensor.adjustment.as_left, sensor.adjustment.acceptance.limits_deg
    rows = list(as_left.errors.items())
    height = 0.75 + 1.6 * len(rows)
    figure = canvas(height)
    panels = figure.subplots(len(rows), 2, squeeze=False, sharey="row")
    figure.subplots_adjust(left=0.095, right=0.985, top=1 - 0.3 / height, bottom=0.45 / height, hspace=0.4, wspace=0.08)
    for row, (name, errors) in zip(panels, rows, strict=True):
        for panel, against in zip(row, ("pitch", "roll"), strict=True):
            _draw(panel, errors, against, _visible(limits.get(name), errors))
        row[0].set_ylabel(f"{name} error (m°)")
        row[0].set_title(f"inferred {name}", loc="left", pad=3.0, fontweight="bold")
    for panel, against in zip(panels[-1], ("pitch", "roll"), strict=True):
        panel.set_xlabel(f"{against} (°)")
    return Figure(
        f"{sensor.slug}-angle-errors",
        f"{sensor.name}: errors of the inferred angles",
        "Angle inferred with the new coefficients less that of the table, mean over the replications at every attitude "
        "of the usage range, in thousandths of a degree. Bars: expanded uncertainty, 95 %. Attitudes whose outputs do "
        "not tell the angle are left out." + _limits_caption(limits),
        to_svg(figure),
    )


def _draw(panel: "Axes", errors: AngleErrors, against: str, limit_deg: float | None) -> None:
    plain_axes(panel, zero_line=True)
    angle_deg = errors.pitch_deg if against == "pitch" else errors.roll_deg
    dense = angle_deg.size > RASTERISE_FROM
    bars = panel.errorbar(
        angle_deg, errors.error_deg * MILLIDEGREE, yerr=errors.expanded_deg * MILLIDEGREE, fmt="o", color=BLUE,
        markersize=2.2, markeredgewidth=0.0, ecolor=FAINT, elinewidth=0.4,
    )  # fmt: skip
    for artist in bars.get_children():
        artist.set_rasterized(dense)
    for limit in () if limit_deg is None else (limit_deg, -limit_deg):
        panel.axhline(limit * MILLIDEGREE, color=RED, linewidth=0.9, linestyle=(0, (5, 2)))
    if np.ptp(angle_deg) > 0.0:
        angle_ticks(panel, angle_deg, most=8.0)
    panel.tick_params(labelcolor=INK)


def _visible(limit_deg: float | None, errors: AngleErrors) -> float | None:
    """Return the limit, unless drawing it would press the errors into a line."""
    largest = float((np.abs(errors.error_deg) + errors.expanded_deg).max())
    return limit_deg if limit_deg is not None and limit_deg < 8.0 * largest else None


def _limits_caption(limits_deg: Mapping[str, float]) -> str:
    limits = ", ".join(f"{name} ±{limit:g}°" for name, limit in limits_deg.items())
    return f" Dashed, where in sight: the limits accepted ({limits})." if limits else ""
