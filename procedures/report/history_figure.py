"""A sensor's control charts: every characteristic against its first value, as an angle, with what was to be expected.

One panel a characteristic, one row a kind. The band is the prediction interval of the calibration before, bars are
expanded uncertainties (k = 2), a finding is a ring and a dashed line, a withdrawn calibration a cross that no line
touches. Told apart without colour by their shapes.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ams.archive.histories import SensorHistory, WithdrawnCalibration
from ams.arrays import FloatArray
from ams.surveillance.check_chart import ComponentChart
from ams.surveillance.control_chart import Chart
from ams.units import ARCSEC_PER_DEG
from procedures.report import canvas
from procedures.report.canvas import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROW_IN = 1.75
HEAD_IN = 0.65
NAMES = {"offset_v": "offset", "angle_deg": "angle between axes"}
SIGNS = {"step": "step", "drift": "drift", "mix-up": "mix-up"}
CAPTION = (
    "Change of each characteristic against the first calibration, as an angle at full sensitivity. Bars: expanded "
    "uncertainty of the calibration (k = 2). Band: prediction interval of the calibration before. Dashed: mean "
    "since the last step. Ring: a finding. Of a check sensor also what its axes did alike (meter) and how it turned "
    "(table): band about the mean of the runs before, dotted: exponentially weighted mean."
)
WITHDRAWN = " Cross: a calibration that was withdrawn; it is in no mean and no band, and before no other."


def history_figure(found: SensorHistory) -> Figure:
    """Draw all charts of a sensor on one page; those of a check sensor with its components."""
    history = found.history
    rows = [
        [chart for chart in history.charts if _kind(chart.name) == kind]
        for kind in list(dict.fromkeys(_kind(chart.name) for chart in history.charts))
    ]
    components: list[list[ComponentChart]] = [] if found.check is None else _shared(found.check.charts)
    count = len(rows) + len(components)
    width = max(*(len(row) for row in rows), *(len(row) for row in components), 1)
    when = np.array([label.created_utc.replace(tzinfo=None) for label in history.labels], dtype="datetime64[s]")
    with canvas.style():
        figure = canvas.canvas(HEAD_IN + ROW_IN * count)
        grid = figure.subplots(count, width, squeeze=False, sharex=True)
        for panels, row in zip(grid, rows, strict=False):
            for axes, chart in zip(panels, row, strict=False):
                _draw_chart(axes, when, chart)
                _mark(axes, when, found, chart)
                _strike(axes, found.withdrawn, chart)
        for panels, part in zip(grid[len(rows) :], components, strict=True):
            for axes, component in zip(panels, part, strict=False):
                _draw_component(axes, when, component)
        for axes in grid.ravel():
            if not axes.has_data():
                axes.set_axis_off()
                continue
            canvas.date_axis(axes)
        for panels in grid:
            panels[0].set_ylabel("change, arc seconds")
        figure.suptitle(_title(found), fontsize=9.5, x=0.01, ha="left")
        figure.tight_layout(rect=(0.0, 0.0, 1.0, 0.985))
        svg = canvas.to_svg(figure)
    caption = CAPTION + (WITHDRAWN if found.withdrawn else "")
    return Figure(f"history-{history.sensor}", f"History of {history.sensor}", caption, svg)


def _draw_chart(axes: "Axes", when: Any, chart: Chart) -> None:
    """Values with their uncertainty, and the band each was to lie in."""
    value, scale = _as_arcsec(chart, chart.value), chart.deg_per_unit * ARCSEC_PER_DEG
    bounds = (chart.prediction_low, chart.prediction_high, chart.centre)
    low, high, centre = (_as_arcsec(chart, part) for part in bounds)
    canvas.plain_axes(axes)
    axes.fill_between(when, low, high, step=None, color=canvas.SKY, alpha=0.25, linewidth=0.0)
    axes.plot(when, centre, color=canvas.FAINT, linewidth=0.8, linestyle=(0, (4, 2)))
    expanded = 2.0 * chart.standard_uncertainty * scale
    axes.errorbar(when, value, expanded, color=canvas.BLUE, fmt="o", markersize=2.8, elinewidth=0.7, linewidth=0.0)
    axes.plot(when, value, color=canvas.BLUE, linewidth=0.5, alpha=0.6)
    kind, _, axis = chart.name.partition(".")
    axes.set_title(f"{NAMES.get(kind, 'sensitivity')} {axis}", loc="left")


def _draw_component(axes: "Axes", when: Any, chart: ComponentChart) -> None:
    value, low, high = (part * ARCSEC_PER_DEG for part in (chart.value_deg, chart.low_deg, chart.high_deg))
    canvas.plain_axes(axes)
    axes.fill_between(when, low, high, color=canvas.SKY, alpha=0.25, linewidth=0.0)
    axes.plot(when, chart.centre_deg * ARCSEC_PER_DEG, color=canvas.FAINT, linewidth=0.8, linestyle=(0, (4, 2)))
    axes.plot(when, chart.ewma_deg * ARCSEC_PER_DEG, color=canvas.RED, linewidth=0.8, linestyle=(0, (1, 1)))
    axes.plot(when, value, color=canvas.PURPLE, marker="s", markersize=2.6, linewidth=0.5)
    _ring(axes, when[chart.is_alarm], value[chart.is_alarm])
    axes.set_title(chart.name, loc="left")


def _mark(axes: "Axes", when: Any, found: SensorHistory, chart: Chart) -> None:
    """Mark every finding in the panels that told it."""
    value = _as_arcsec(chart, chart.value)
    index_of = {label.sha256: index for index, label in enumerate(found.history.labels)}
    for finding in found.history.findings:
        if chart.name not in finding.characteristics:
            continue
        index = index_of[finding.at.sha256]
        _ring(axes, when[[index]], value[[index]])
        axes.axvline(when[index], color=canvas.RED, linewidth=0.7, linestyle=(0, (2, 2)))
        axes.annotate(
            SIGNS[finding.kind], (when[index], 1.0), xycoords=("data", "axes fraction"), xytext=(2, -8),
            textcoords="offset points", fontsize=7.0, color=canvas.RED,
            ha="left" if index < 0.75 * len(when) else "right",
        )  # fmt: skip


def _strike(axes: "Axes", withdrawn: Sequence[WithdrawnCalibration], chart: Chart) -> None:
    """Draw a cross for each withdrawn calibration; one far outside what counts stands at the edge, with its value."""
    low, high = axes.get_ylim()
    room = high - low
    for gone in withdrawn:
        if chart.name not in gone.value:
            continue
        (value,) = _as_arcsec(chart, np.array([gone.value[chart.name]]))
        moment = np.datetime64(gone.created_utc.replace(tzinfo=None), "s")
        if low - room <= value <= high + room:
            axes.plot(moment, value, color=canvas.INK, marker="x", markersize=5.0, linestyle="none")
            continue
        edge = 0.93 if value > high else 0.07
        across = axes.get_xaxis_transform()
        axes.plot(moment, edge, color=canvas.INK, marker="x", markersize=5.0, linestyle="none", transform=across)
        axes.annotate(
            f"{value:+.4g}″", (moment, edge), xycoords=("data", "axes fraction"), xytext=(4, -2),
            textcoords="offset points", fontsize=6.5, color=canvas.INK,
        )  # fmt: skip


def _ring(axes: "Axes", when: Any, value: FloatArray) -> None:
    axes.plot(when, value, linestyle="none", marker="o", markersize=7.5, markerfacecolor="none", color=canvas.RED)


def _as_arcsec(chart: Chart, values: FloatArray) -> FloatArray:
    return np.asarray((values - chart.value[0]) * chart.deg_per_unit * ARCSEC_PER_DEG)


def _kind(name: str) -> str:
    return name.partition(".")[0]


def _shared(charts: Sequence[ComponentChart]) -> list[list[ComponentChart]]:
    """Return the components that the charts of the sensor do not show already: the meter's, then the table's."""
    rows = ([chart for chart in charts if chart.name.startswith(word)] for word in ("meter", "table"))
    return [row for row in rows if row]


def _title(found: SensorHistory) -> str:
    history = found.history
    found_signs = [SIGNS[finding.kind] for finding in history.findings]
    shared = [] if found.check is None else [finding.component for finding in found.check.findings]
    unjudged = found.check is not None and not found.check.is_judged
    signs = ", ".join(dict.fromkeys([*found_signs, *shared])) or ("cannot judge yet" if unjudged else "nothing found")
    struck = f", {len(found.withdrawn)} withdrawn" if found.withdrawn else ""
    return f"{history.sensor}: {len(history.labels)} calibrations{struck} on {history.labels[-1].rig}: {signs}"
