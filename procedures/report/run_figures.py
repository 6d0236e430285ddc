"""Figures of the run itself: the design and its order, temperature, reference attitude, parameters by replication."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ams.calibration_result import Replication
from ams.units import ARCSEC_PER_DEG
from procedures.numbers import as_drawn
from procedures.report.canvas import (
    FAINT,
    INK,
    RED,
    SERIES,
    Figure,
    angle_ticks,
    canvas,
    pitch_ticks,
    plain_axes,
    series_style,
    to_svg,
)
from procedures.report.conclusions import by_replication
from procedures.report.design_figures import variance_map
from procedures.report.interruption_marks import interruption_caption, mark_interruptions
from procedures.report.view import AxisView, DesignView, ParameterRow, ReferenceTrace, RunView, SensorView

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DRAWN_SCALE = {
    "V": (1e6, "µV"),
    "V/g": (1e6, "µV/g"),
    "°": (ARCSEC_PER_DEG, "″"),
    "V/°C": (1e6, "µV/°C"),
    "V/g²": (1e6, "µV/g²"),
    "V/g³": (1e6, "µV/g³"),
    "V/(g·°C)": (1e6, "µV/(g·°C)"),
}
"""A parameter's unit to the factor and the unit in which its small changes are drawn."""


MOST_PANELS_ABREAST = 5
"""Wider, and the titles of small panels stand in one another."""
MOST_LINES = 8
"""Lines that can be told apart in one panel."""


def run_figures(view: RunView) -> Iterator[Figure]:
    """Design map, temperature and reference attitude. Call inside ``canvas.style()``."""
    if view.design.points:
        yield _design_map(view.design)
        known = variance_map(view.design)
        if known is not None:
            yield known
    if view.temperature:
        yield _temperature(view)
    yield from reference_figures(view)


def drift_figure(sensor: SensorView) -> Figure | None:
    """Draw every parameter by replication; None where there was one replication."""
    if not any(axis.tests for axis in sensor.axes):
        return None
    columns = min(max(len(axis.parameters) for axis in sensor.axes), MOST_PANELS_ABREAST)
    rows = [(axis, start) for axis in sensor.axes for start in range(0, len(axis.parameters), columns)]
    height = 0.75 + 1.3 * len(rows)
    figure = canvas(height)
    panels = figure.subplots(len(rows), columns, squeeze=False)
    figure.subplots_adjust(left=0.075, right=0.99, top=1 - 0.3 / height, bottom=0.45 / height, hspace=0.55, wspace=0.42)
    for row, (axis, start) in zip(panels, rows, strict=True):
        parameters = axis.parameters[start : start + columns]
        for panel in row[len(parameters) :]:
            panel.set_axis_off()
        for panel, parameter in zip(row, parameters, strict=False):
            _parameter_panel(panel, axis, parameter)
    for panel in panels[-1]:
        panel.set_xlabel("replication")
    return Figure(
        f"{sensor.slug}-drift",
        f"{sensor.name}: parameters by replication",
        "Every replication solved alone, as the change from the mean of all. Bars: ± one standard uncertainty of one "
        "replication, from the dwell-to-dwell precision. A red title marks a significant drift (after Holm).",
        to_svg(figure),
    )


def _parameter_panel(panel: "Axes", axis: AxisView, parameter: ParameterRow) -> None:
    replication = axis.calibration.replication
    factor, unit = DRAWN_SCALE.get(parameter.unit, (1.0, parameter.unit))
    changes = {} if replication is None else _changes(replication, parameter.name)
    plain_axes(panel, zero_line=True)
    marked = any(test.is_significant for test in axis.tests if test.parameter == parameter.name)
    panel.set_title(
        f"{axis.axis}: {parameter.label} ({unit})", loc="left", pad=3.0, fontsize=7.5, color=RED if marked else INK,
        fontweight="bold" if marked else "normal",
    )  # fmt: skip
    if not changes:
        panel.text(0.5, 0.5, "not determined", transform=panel.transAxes, ha="center", va="center", color=FAINT)
        panel.set(xticks=[], yticks=[])
        return
    error = None if replication is None else _one_replication(axis, replication, parameter)
    panel.errorbar(
        list(changes), [change * factor for change in changes.values()],
        yerr=None if error is None else error * factor, fmt="o-", color=SERIES[0], markersize=3, linewidth=0.8,
        elinewidth=0.7, capsize=1.5,
    )  # fmt: skip
    panel.set_xlim(min(changes) - 0.5, max(changes) + 0.5)
    if len(changes) <= 8:
        panel.set_xticks(list(changes))


def _changes(replication: Replication, name: str) -> dict[int, float]:
    values = by_replication(replication, name)
    mean = sum(values.values()) / len(values) if values else 0.0
    return {label: value - mean for label, value in values.items()}


def _one_replication(axis: AxisView, replication: Replication, parameter: ParameterRow) -> float | None:
    """Return the standard uncertainty of one replication's estimate, or None.

    The pooled one, at the precision alone, times √n.
    """
    pooled = parameter.tp_standard_uncertainty
    if pooled is None or not axis.calibration.standard_error_v > 0.0:
        return None
    return (
        pooled * replication.precision_v / axis.calibration.standard_error_v * float(np.sqrt(replication.replications))
    )


def _design_map(design: DesignView) -> Figure:
    figure = canvas(3.3)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.9, top=0.92, bottom=0.14)
    plain_axes(axes)
    axes.plot(design.roll_deg, design.pitch_deg, color=FAINT, linewidth=0.7, zorder=1)
    marks = axes.scatter(
        design.roll_deg, design.pitch_deg, c=np.arange(1, design.points + 1), cmap="cividis", s=16, zorder=2,
        edgecolors="white", linewidths=0.3,
    )  # fmt: skip
    for place, symbol, name in ((0, "o", "first"), (-1, "s", "last")):
        axes.plot(
            design.roll_deg[place], design.pitch_deg[place], symbol, markersize=9, markerfacecolor="none",
            markeredgecolor=RED, markeredgewidth=1.3, linestyle="", label=name, clip_on=False,
        )  # fmt: skip
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)
    angle_ticks(axes, design.roll_deg)
    pitch_ticks(axes, design.pitch_deg)
    axes.set(xlabel="roll (°)", ylabel="pitch (°)")
    bar = figure.colorbar(marks, cax=figure.add_axes((0.915, 0.14, 0.014, 0.78)))
    bar.set_label("order of visit")
    bar.outline.set_linewidth(0.4)
    return Figure(
        "design",
        "Design and order of visits",
        f"The {design.points} attitudes of design {design.kind} in the order “{design.order}”, as the first "
        "replication visited them.",
        to_svg(figure),
    )


def _temperature(view: RunView) -> Figure:
    figure = canvas(2.2)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.985, top=0.9, bottom=0.2)
    plain_axes(axes)
    for place, trace in enumerate(view.temperature):
        colour, _ = series_style(place, len(view.temperature))
        axes.plot(trace.hours, trace.temperature_degc, color=colour, linewidth=0.8, label=trace.name)
    mark_interruptions(axes, view)
    axes.set(xlabel="time since the first dwell (h)", ylabel="temperature (°C)")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=6, borderaxespad=0.0)
    return Figure(
        "temperature",
        "Temperature",
        "Mean of the readings before and after every dwell." + interruption_caption(view),
        to_svg(figure),
    )


def reference_figures(view: RunView) -> Iterator[Figure]:
    """Yield one figure a unit: angles where there are any, and what is no voltage of gravity as it was read."""
    by_unit: dict[str, list[tuple[ReferenceTrace, float]]] = {}
    for trace in view.reference:
        factor, unit = as_drawn(trace.sensitivity_v_per_g, trace.unit)
        by_unit.setdefault(unit, []).append((trace, factor))
    for place, (unit, traces) in enumerate(by_unit.items()):
        yield _reference(view, traces, unit, "reference" if place == 0 else f"reference-{place + 1}")


def _reference(view: RunView, traces: Sequence[tuple[ReferenceTrace, float]], unit: str, name: str) -> Figure:
    is_angle = unit == "″"
    if len(traces) > MOST_LINES:
        return _reference_map(traces, unit, name, interruption_caption(view))
    figure = canvas(2.5)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.985, top=0.88, bottom=0.18)
    plain_axes(axes, zero_line=True)
    for place, (trace, factor) in enumerate(traces):
        colour, symbol = series_style(place, len(traces))
        axes.plot(
            trace.hours,
            trace.change * factor,
            marker=symbol,
            color=colour,
            markersize=3,
            linewidth=0.7,
            label=trace.label,
        )
    mark_interruptions(axes, view)
    axes.set(xlabel="time since the first dwell (h)", ylabel=f"change ({'arc seconds' if is_angle else unit})")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=6, borderaxespad=0.0)
    return Figure(
        name,
        "Reference attitude over the run",
        f"Output at the reference attitude less that of its first visit{', as an angle (change / |S|)' * is_angle}."
        + interruption_caption(view),
        to_svg(figure),
    )


def _reference_map(traces: Sequence[tuple[ReferenceTrace, float]], unit: str, name: str, caption: str) -> Figure:
    """Draw a row a channel, a column a visit: what many lines hide shows as a stripe or a row."""
    visits = max(trace.hours.size for trace, _ in traces)
    values = np.full((len(traces), visits), np.nan)
    for row, (trace, factor) in enumerate(traces):
        values[row, : trace.change.size] = trace.change * factor
    most = float(np.nanmax(np.abs(values))) or 1.0
    row_in = min(0.16, 9.0 / len(traces))
    height = 0.8 + row_in * len(traces)
    figure = canvas(height)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.17, right=0.88, top=1 - 0.12 / height, bottom=0.5 / height)
    image = axes.imshow(values, aspect="auto", interpolation="nearest", cmap="RdBu_r", vmin=-most, vmax=most)
    labelled = range(0, len(traces), max(1, -(-len(traces) // 60)))
    axes.set_yticks(list(labelled), [traces[row][0].label for row in labelled], fontsize=min(7.5, 62.0 * row_in))
    axes.set_xticks([0, visits - 1] if visits > 1 else [0])
    axes.set_xticklabels([f"{traces[0][0].hours[place]:.1f} h" for place in ((0, visits - 1) if visits > 1 else (0,))])
    axes.tick_params(length=0)
    axes.set_xlabel(f"{visits} visits, in their order")
    bar = figure.colorbar(image, cax=figure.add_axes((0.9, 0.5 / height, 0.014, 1 - 0.62 / height)))
    bar.set_label(f"change ({'arc seconds' if unit == '″' else unit})")
    bar.outline.set_linewidth(0.4)
    return Figure(
        name,
        "Reference attitude over the run",
        "Output at the reference attitude less that of its first visit, a row a channel"
        f"{', as an angle (change / |S|)' * (unit == '″')}. The same stripe in every row is the table’s.{caption}",
        to_svg(figure),
    )
