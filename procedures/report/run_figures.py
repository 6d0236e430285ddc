"""Figures of the run itself: the design and its order, temperature, reference attitude, parameters by replication."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ams.calibration_result import Replication
from ams.rounding import two_digits
from ams.units import ARCSEC_PER_DEG
from procedures.numbers import as_drawn
from procedures.report.canvas import (
    FAINT,
    GRID,
    RED,
    SERIES,
    Figure,
    angle_ticks,
    canvas,
    legend_above,
    pitch_ticks,
    plain_axes,
    series_style,
    to_svg,
    widest_in,
)
from procedures.report.conclusions import by_replication
from procedures.report.design_figures import variance_map
from procedures.report.interruption_marks import (
    interruption_caption,
    mark_interruptions,
    mark_interruptions_between,
)
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


ROW_IN = 0.25
"""Height of one parameter's strip."""
STRIP = 0.42
"""Half a strip's share of its row."""
LABEL_MARGIN, WIDEST_LABELS = 0.025, 0.6
"""Beside the labels of rows, and where a serial number without end leaves room for the picture; shares of the width."""
MOST_LINES = 8
"""Lines that can be told apart in one panel."""


def run_figures(view: RunView) -> Iterator[Figure]:
    """Yield design map, temperature and reference attitude. Call inside ``canvas.style()``."""
    if view.design.points:
        yield _design_map(view.design)
        known = variance_map(view.design)
        if known is not None:
            yield known
    if view.temperature:
        yield _temperature(view)
    yield from reference_figures(view)


def drift_figure(sensor: SensorView) -> Figure | None:
    """Draw every parameter by replication, a strip each; None where there was one replication."""
    if not any(axis.tests for axis in sensor.axes) or not (labels := _determined(sensor)):
        return None
    height = 0.75 + ROW_IN * len(labels)
    figure = canvas(height)
    panels = figure.subplots(1, len(sensor.axes), squeeze=False, sharey=True)[0]
    figure.subplots_adjust(left=0.135, right=0.915, top=1 - 0.28 / height, bottom=0.42 / height, wspace=0.48)
    for panel, axis in zip(panels, sensor.axes, strict=True):
        _parameter_strips(panel, axis, tuple(labels))
    panels[0].set_yticks(range(len(labels)), list(labels.values()), fontsize=7.0)
    return Figure(
        f"{sensor.slug}-drift",
        f"{sensor.name}: parameters by replication",
        "Every replication solved alone, as the change from the mean of all, each parameter in a strip and on a scale "
        "of its own. Bars: ± one standard uncertainty of one replication, from the dwell-to-dwell precision; its size "
        "stands on the right (—: no replication alone determines it). Red marks a significant drift (after Holm).",
        to_svg(figure),
    )


def _determined(sensor: SensorView) -> dict[str, str]:
    """Return name and label of what a replication alone determines on some axis: a temperature term it does not."""
    return {
        parameter.name: parameter.label
        for axis in sensor.axes
        for parameter in axis.parameters
        if axis.calibration.replication is not None and _changes(axis.calibration.replication, parameter.name)
    }


def _parameter_strips(panel: "Axes", axis: AxisView, names: Sequence[str]) -> None:
    """Draw an axis' strips in one panel: a panel for each of sixty parameters takes seconds."""
    replication = axis.calibration.replication
    drifting = {test.parameter for test in axis.tests if test.is_significant}
    panel.hlines(range(len(names)), 0.0, 1.0, color=GRID, linewidth=0.5, transform=panel.get_yaxis_transform())
    quiet, marked, replications = _Strips(), _Strips(), set[int]()
    for parameter in axis.parameters:
        if parameter.name not in names:
            continue
        row = names.index(parameter.name)
        changes = {} if replication is None else _changes(replication, parameter.name)
        u = None if replication is None else _one_replication(axis, replication, parameter)
        (marked if parameter.name in drifting else quiet).add(row, changes, u)
        replications.update(changes)
        size = "—" if not changes else "" if u is None else _drawn_size(u, parameter.unit)
        panel.text(
            1.03, row, size, transform=panel.get_yaxis_transform(), va="center", fontsize=6.5,
            color=RED if parameter.name in drifting else FAINT,
        )  # fmt: skip
    for strips, colour in ((quiet, SERIES[0]), (marked, RED)):
        panel.errorbar(
            strips.replication, strips.height, yerr=strips.bar, fmt="o-", color=colour, markersize=2.4, linewidth=0.8,
            elinewidth=0.7,
        )  # fmt: skip
    panel.spines[["top", "right", "left"]].set_visible(False)
    panel.tick_params(length=2.5, width=0.6)
    panel.tick_params(axis="y", length=0.0)
    panel.set_ylim(len(names) - 0.5, -0.5)
    if replications:
        panel.set_xlim(min(replications) - 0.5, max(replications) + 0.5)
    if len(replications) <= 8:
        panel.set_xticks(sorted(replications))
    panel.set_title(f"{axis.axis} axis", loc="left", pad=3.0, fontweight="bold")
    panel.set_xlabel("replication")


class _Strips:
    """Points and bars of several strips as one line, broken between them."""

    def __init__(self) -> None:
        self.replication: list[float] = []
        self.height: list[float] = []
        self.bar: list[float] = []

    def add(self, row: int, changes: Mapping[int, float], u: float | None) -> None:
        whole = max((*map(abs, changes.values()), 2.0 * (u or 0.0)), default=0.0) or 1.0
        self.replication += [*changes, np.nan]
        self.height += [*(row - STRIP * change / whole for change in changes.values()), np.nan]
        self.bar += [0.0 if u is None else STRIP * u / whole] * (len(changes) + 1)


def _drawn_size(standard_uncertainty: float, unit: str) -> str:
    factor, drawn = DRAWN_SCALE.get(unit, (1.0, unit))
    return f"± {two_digits(standard_uncertainty * factor)} {drawn}"


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
    for index, symbol, name in ((0, "o", "first"), (-1, "s", "last")):
        axes.plot(
            design.roll_deg[index], design.pitch_deg[index], symbol, markersize=9, markerfacecolor="none",
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
        f"Design {design.kind}, {design.attitudes_in_words}, in the order “{design.order}”, as the first replication "
        "visited them.",
        to_svg(figure),
    )


def _temperature(view: RunView) -> Figure:
    figure = canvas(2.2)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.985, top=0.9, bottom=0.2)
    plain_axes(axes)
    for index, trace in enumerate(view.temperature):
        colour, _ = series_style(index, len(view.temperature))
        axes.plot(trace.hours, trace.temperature_degc, color=colour, linewidth=0.8, label=trace.name)
    mark_interruptions(axes, view)
    axes.set(xlabel="time since the first dwell (h)", ylabel="temperature (°C)")
    legend_above(figure, axes)
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
    for index, (unit, traces) in enumerate(by_unit.items()):
        yield _reference(view, traces, unit, "reference" if index == 0 else f"reference-{index + 1}")


def _reference(view: RunView, traces: Sequence[tuple[ReferenceTrace, float]], unit: str, name: str) -> Figure:
    is_angle = unit == "″"
    if len(traces) > MOST_LINES:
        return _reference_map(view, traces, unit, name)
    figure = canvas(2.5)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.985, top=0.88, bottom=0.18)
    plain_axes(axes, zero_line=True)
    for index, (trace, factor) in enumerate(traces):
        colour, symbol = series_style(index, len(traces))
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
    legend_above(figure, axes)
    return Figure(
        name,
        "Reference attitude over the run",
        f"Output at the reference attitude less that of its first visit{', as an angle (change / |S|)' * is_angle}."
        + interruption_caption(view),
        to_svg(figure),
    )


def _reference_map(view: RunView, traces: Sequence[tuple[ReferenceTrace, float]], unit: str, name: str) -> Figure:
    """Draw a row a channel, a column a visit: what many lines hide shows as a stripe or a row."""
    hours = max((trace.hours for trace, _ in traces), key=len)  # a sensor that was dropped has fewer
    visits = hours.size
    values = np.full((len(traces), visits), np.nan)
    for row, (trace, factor) in enumerate(traces):
        values[row, : trace.change.size] = trace.change * factor
    most = float(np.nanmax(np.abs(values))) or 1.0
    row_in = min(0.16, 9.0 / len(traces))
    height = 0.8 + row_in * len(traces)
    figure = canvas(height)
    axes = figure.subplots()
    figure.subplots_adjust(right=0.88, top=1 - 0.12 / height, bottom=0.5 / height)
    image = axes.imshow(values, aspect="auto", interpolation="nearest", cmap="RdBu_r", vmin=-most, vmax=most)
    labelled = range(0, len(traces), max(1, -(-len(traces) // 60)))
    axes.set_yticks(list(labelled), [traces[row][0].label for row in labelled], fontsize=min(7.5, 62.0 * row_in))
    figure.subplots_adjust(
        left=min(widest_in(axes.get_yticklabels()) / figure.get_figwidth() + LABEL_MARGIN, WIDEST_LABELS)
    )
    axes.set_xticks([0, visits - 1] if visits > 1 else [0])
    axes.set_xticklabels([f"{hours[index]:.1f} h" for index in ((0, visits - 1) if visits > 1 else (0,))])
    mark_interruptions_between(axes, view, hours)
    axes.set_xlim(-0.5, visits - 0.5)
    axes.tick_params(length=0)
    axes.set_xlabel(f"{visits} visits, in their order")
    bar = figure.colorbar(image, cax=figure.add_axes((0.9, 0.5 / height, 0.014, 1 - 0.62 / height)))
    bar.set_label(f"change ({'arc seconds' if unit == '″' else unit})")
    bar.outline.set_linewidth(0.4)
    return Figure(
        name,
        "Reference attitude over the run",
        "Output at the reference attitude less that of its first visit, a row a channel"
        f"{', as an angle (change / |S|)' * (unit == '″')}. The same stripe in every row is the table’s."
        + interruption_caption(view),
        to_svg(figure),
    )
