"""Residuals of one sensor: against pitch and roll with their bands, over time, by attitude, and their distribution.

Source: TP figures 22 to 54: a symbol for each replication, the 95 % confidence interval of the calibration dotted, the
95 % prediction interval dash-dotted. Here the left scale is the output and the right scale the same as an angle.
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.observations import Observations
from ams.statistics.distributions import normal_quantile
from ams.units import ARCSEC_PER_RAD
from procedures.report.bands import Along, band_along
from procedures.report.canvas import (
    BLUE,
    FAINT,
    INK,
    RASTERISE_FROM,
    SYMBOL_SIZES,
    Figure,
    angle_ticks,
    canvas,
    legend_entry,
    pitch_ticks,
    plain_axes,
    series_style,
    to_svg,
)
from procedures.report.conclusions import mean_residuals
from procedures.report.interruption_marks import interruption_caption, mark_interruptions
from procedures.report.view import AxisView, RunView, SensorView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.lines import Line2D

MICROVOLT = 1e6
MOST_WITH_WORD = 4
"""Replications that the legend names in full."""
DODGE = 0.6
"""Replications stand side by side over this share of the smallest step of the angle."""


def residual_figures(view: RunView, sensor: SensorView) -> Iterator[Figure]:
    """Draw the figures of one solved sensor. Call inside ``canvas.style()``."""
    observations = sensor.observations
    if observations is None or not sensor.axes:
        return
    yield _against(sensor, observations, "pitch")
    if np.ptp(observations.roll_rad) > 0.0:
        yield _against(sensor, observations, "roll")
    if observations.time_s is not None:
        yield _over_time(view, sensor, observations, observations.time_s)
    yield _by_attitude(sensor, observations)
    yield _distribution(sensor)


def _against(sensor: SensorView, observations: Observations, along: Along) -> Figure:
    angle_deg = np.rad2deg(observations.pitch_rad if along == "pitch" else observations.roll_rad)

    def draw(axes: "Axes", view: AxisView) -> None:
        _points(axes, _dodged(angle_deg, observations.replication), view, observations)
        band = band_along(view.calibration, observations, along)
        for half_v, dashes in ((band.confidence_v, (0, (1, 1.5))), (band.prediction_v, (0, (6, 2, 1, 2)))):
            for sign in (1.0, -1.0):
                axes.plot(band.angle_deg, sign * half_v * MICROVOLT, color=INK, linestyle=dashes)
        angle_ticks(axes, angle_deg)

    figure = _stacked(sensor, draw, f"{along} (°)")
    _legend(figure, observations, with_bands=True)
    return Figure(
        f"{sensor.slug}-residuals-{along}",
        f"{sensor.name}: residuals against {along}",
        "Observed less fitted output of every accepted dwell, a symbol for each replication (drawn side by side). "
        "Dotted: 95 % confidence interval of the calibration. Dash-dotted: 95 % prediction interval of one more dwell "
        f"of this calibration. Both are the widest over the design's {'roll' if along == 'pitch' else 'pitch'} angles. "
        "Right scale: the residual as an angle, residual / |S|.",
        to_svg(figure),
    )


def _over_time(view: RunView, sensor: SensorView, observations: Observations, time_s: FloatArray) -> Figure:
    hours = time_s / 3600.0

    def draw(axes: "Axes", axis: AxisView) -> None:
        _points(axes, hours, axis, observations)
        for label in np.unique(observations.replication):
            rows = observations.replication == label
            mean = float(axis.calibration.residuals_v[rows].mean()) * MICROVOLT
            axes.plot([hours[rows].min(), hours[rows].max()], [mean, mean], color=INK, linewidth=1.6)
        mark_interruptions(axes, view)

    figure = _stacked(sensor, draw, "time since the first dwell (h)")
    _legend(figure, observations, with_bands=False)
    return Figure(
        f"{sensor.slug}-residuals-time",
        f"{sensor.name}: residuals over time",
        "The same residuals in the order in which they were measured. Black bars: mean of each replication."
        + interruption_caption(view),
        to_svg(figure),
    )


def _stacked(sensor: SensorView, draw: "Callable[[Axes, AxisView], None]", label: str) -> "Canvas":
    """Draw one panel an axis, a common abscissa, volts on the left and arc seconds on the right."""
    count = len(sensor.axes)
    height = 0.95 + 1.75 * count
    figure = canvas(height)
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    figure.subplots_adjust(left=0.095, right=0.9, top=1.0 - 0.5 / height, bottom=0.45 / height, hspace=0.24)
    for panel, axis in zip(panels, sensor.axes, strict=True):
        plain_axes(panel, zero_line=True)
        draw(panel, axis)
        panel.set_ylabel("residual (µV)")
        panel.set_title(f"{axis.axis} axis", loc="left", pad=3.0, fontweight="bold")
        low, high = panel.get_ylim()
        limit = max(abs(low), abs(high), 1e-9)
        panel.set_ylim(-limit, limit)
        scale = panel.twinx()
        arcsec = limit / MICROVOLT / axis.sensitivity_v_per_g * ARCSEC_PER_RAD
        scale.set_ylim(-arcsec, arcsec)
        scale.set_ylabel("arc seconds")
        scale.spines[["top", "left"]].set_visible(False)
        scale.tick_params(length=2.5, width=0.6)
    panels[-1].set_xlabel(label)
    return figure


def _points(axes: "Axes", abscissa: FloatArray, view: AxisView, observations: Observations) -> None:
    labels = np.unique(observations.replication)
    dense = observations.rows > RASTERISE_FROM
    for index, label in enumerate(labels):
        colour, symbol = series_style(index, labels.size)
        rows = observations.replication == label
        axes.plot(
            abscissa[rows],
            view.calibration.residuals_v[rows] * MICROVOLT,
            symbol,
            color=colour,
            markersize=(2.6 if dense else 3.4) * SYMBOL_SIZES.get(symbol, 1.0),
            markeredgewidth=0.0,
            alpha=0.75,
            rasterized=dense,
        )


def _dodged(angle_deg: FloatArray, replication: IntArray) -> FloatArray:
    """Return the abscissas with the replications side by side instead of on top of each other."""
    labels, index = np.unique(replication, return_inverse=True)
    steps = np.diff(np.unique(np.round(angle_deg, 3)))
    if labels.size < 2 or steps.size == 0:
        return angle_deg
    width = DODGE * min(float(steps.min()), float(np.ptp(angle_deg)) / 12.0)
    return angle_deg + width * (index / (labels.size - 1) - 0.5)


def _legend(figure: "Canvas", observations: Observations, *, with_bands: bool) -> None:
    labels = np.unique(observations.replication)
    shown = range(labels.size) if labels.size <= 8 else (0, labels.size - 1)
    entries = [_entry(index, labels) for index in shown]
    if len(entries) > MOST_WITH_WORD:  # "repl." at each of eight would run off the figure
        entries = [legend_entry(linestyle="", label="replication"), *entries]
        for entry, index in zip(entries[1:], shown, strict=True):
            entry.set_label(f"{labels[index]}")
    if with_bands:
        entries.append(legend_entry(color=INK, linestyle=(0, (1, 1.5)), label="confidence 95 %"))
        entries.append(legend_entry(color=INK, linestyle=(0, (6, 2, 1, 2)), label="prediction 95 %"))
    figure.legend(
        handles=entries, loc="upper right", bbox_to_anchor=(0.905, 1.0), ncols=len(entries), handletextpad=0.4,
        columnspacing=1.0,
    )  # fmt: skip


def _entry(index: int, labels: IntArray) -> "Line2D":
    colour, symbol = series_style(index, labels.size)
    return legend_entry(linestyle="", marker=symbol, color=colour, markersize=4, label=f"repl. {labels[index]}")


def _by_attitude(sensor: SensorView, observations: Observations) -> Figure:
    """Draw the mean residual of every design point over the plane of attitudes: what repeats is lack of fit."""
    count = len(sensor.axes)
    figure = canvas(2.9)
    panels = figure.subplots(1, count, sharey=True, squeeze=False)[0]
    figure.subplots_adjust(left=0.085, right=0.88, top=0.91, bottom=0.15, wspace=0.2)
    means = [mean_residuals(axis.calibration, observations) for axis in sensor.axes]
    arcsec = [
        residual_v / axis.sensitivity_v_per_g * ARCSEC_PER_RAD
        for axis, (_, _, residual_v) in zip(sensor.axes, means, strict=True)
    ]
    limit = max(1e-6, *(float(np.abs(values).max()) for values in arcsec))
    for panel, axis, (pitch, roll, _), values in zip(panels, sensor.axes, means, arcsec, strict=True):
        plain_axes(panel)
        marks = panel.scatter(
            roll, pitch, c=values, cmap="PuOr", vmin=-limit, vmax=limit, s=_mark_size(pitch, roll, count),
            marker="s", edgecolors=FAINT, linewidths=0.2, clip_on=False, rasterized=pitch.size > RASTERISE_FROM,
        )  # fmt: skip
        panel.set_title(f"{axis.axis} axis", loc="left", pad=3.0, fontweight="bold")
        panel.set_xlabel("roll (°)")
        angle_ticks(panel, roll, most=12.5 / count + 1.0)
        pitch_ticks(panel, pitch)
    panels[0].set_ylabel("pitch (°)")
    bar = figure.colorbar(marks, cax=figure.add_axes((0.893, 0.15, 0.014, 0.76)))
    bar.set_label("mean residual (arc seconds)")
    bar.outline.set_linewidth(0.4)
    return Figure(
        f"{sensor.slug}-residuals-attitude",
        f"{sensor.name}: mean residual by attitude",
        "Mean over the replications at every design point, as an angle (residual / |S|). What forms a pattern here "
        "repeats from replication to replication: the table's index errors, or a term that the model does not have.",
        to_svg(figure),
    )


def _mark_size(pitch: FloatArray, roll: FloatArray, panels: int) -> float:
    """Return the area of a mark, points², that fills the plane of attitudes without overlap."""
    columns, rows = np.unique(np.round(roll, 3)).size, np.unique(np.round(pitch, 3)).size
    side = min(430.0 / panels / (columns + 1), 130.0 / (rows + 1))
    return float(np.clip(side, 2.0, 12.0) ** 2)


def _distribution(sensor: SensorView) -> Figure:
    """Draw the ordered residuals against normal quantiles: the intervals rest on this being a straight line."""
    count = len(sensor.axes)
    figure = canvas(2.5 if count > 1 else 3.2)
    panels = figure.subplots(1, count, squeeze=False)[0]
    figure.subplots_adjust(left=0.085, right=0.985, top=0.9, bottom=0.17, wspace=0.28)
    for panel, axis in zip(panels, sensor.axes, strict=True):
        ordered = np.sort(axis.calibration.residuals_v) * MICROVOLT
        quantiles = normal_quantile((np.arange(ordered.size) + 0.625) / (ordered.size + 0.25))
        plain_axes(panel)
        panel.plot(
            quantiles, ordered, "o", color=BLUE, markersize=2.4, markeredgewidth=0.0,
            rasterized=ordered.size > RASTERISE_FROM,
        )  # fmt: skip
        ends = np.array([quantiles[0], quantiles[-1]])
        panel.plot(ends, ends * axis.calibration.standard_error_v * MICROVOLT, color=INK, linewidth=0.8)
        panel.set_title(f"{axis.axis} axis", loc="left", pad=3.0, fontweight="bold")
        panel.set_xlabel("normal quantile")
    panels[0].set_ylabel("residual (µV)")
    return Figure(
        f"{sensor.slug}-distribution",
        f"{sensor.name}: distribution of the residuals",
        "Ordered residuals against the quantiles of a normal distribution. The line has the standard error as its "
        "slope; points along it support the intervals stated, which assume normal errors.",
        to_svg(figure),
    )
