"""The run's outcome for the terminal: coefficients with their intervals, beside the twin's truth when simulated."""

from collections.abc import Sequence
from textwrap import fill
from typing import Literal

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ams.models.rate_terms import LOW_ORDER_NAMES
from ams.rounding import with_uncertainty
from procedures.kinds.section import TextTable
from procedures.report.overview import overview_rows
from procedures.report.view import ParameterRow, RunView, SensorView

VERDICT_COLOURS = {"sound": "green", "reserved": "yellow", "unusable": "red"}


def print_summary(view: RunView, console: Console) -> None:
    """Coefficients of one or two sensors, a row for each of more, and what a reader should know before using them.

    The verdict is :func:`print_verdict`'s, to be told last.
    """
    if view.stamps:
        console.print(Text(" · ".join(view.stamps), style="bold red"))
    is_listed = len(view.sensors) > MOST_IN_FULL
    if is_listed:
        console.print(overview_table(view), width=max(console.width, NARROWEST), crop=False)
    for sensor in () if is_listed else view.sensors:
        if sensor.axes:
            console.print(sensor_table(view, sensor), width=max(console.width, NARROWEST), crop=False)
        for table in sensor.section.tables[:1] if sensor.section is not None else ():
            console.print(text_table(sensor.name, table), width=max(console.width, NARROWEST), crop=False)
    for ground in view.verdict.grounds:
        bullet = Table.grid(padding=(0, 1))
        bullet.add_row("  •", Text(ground))
        console.print(bullet, highlight=False)


def print_verdict(view: RunView, console: Console) -> None:
    """Print what stands last in the terminal."""
    console.print(Text(view.verdict.sentence, style=f"bold {VERDICT_COLOURS[view.verdict.trust]}"))


def overview_table(view: RunView) -> Table:
    """Return a row a sensor."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, title="95 % of the fitted angle, errors as found and as left")
    for heading in ("sensor", "verdict", "angle", "as found", "as left", "findings"):
        table.add_column(heading, overflow="fold")
    for row in overview_rows(view):
        cells = (row.sensor, row.verdict, row.angle, row.as_found, row.as_left, row.findings)
        table.add_row(*(Text(cell) for cell in cells))
    return table


def worst_uncertainty(view: RunView) -> str:
    """Name the offset that is known worst, as an angle or in parts; empty where no offset has an interval."""
    offsets = [
        (
            row.expanded_uncertainty / abs(sensitivity),
            f"{sensor.name} {axis.axis}: offset ± {row.in_other_terms} (95 %)",
        )
        for sensor in view.sensors
        for axis in sensor.axes
        for sensitivity in (_value(axis.parameters, "sensitivity"),)
        for row in axis.parameters
        if row.name == "offset_v" and row.expanded_uncertainty is not None and sensitivity
    ]
    return f"worst: {max(offsets)[1]}" if offsets else ""


def _value(rows: Sequence[ParameterRow], name: str) -> float | None:
    return next((row.value for row in rows if row.name.startswith(name)), None)


MOST_IN_FULL = 2
"""Sensors whose coefficients are printed; those of more stand in the report."""
NARROWEST = 80
"""Tables are never made narrower: a terminal that is breaks their lines itself, and every digit is there."""
LABEL = 21
"""Characters of a line of a parameter's name: with it all columns go into a terminal of eighty."""
WHOLE = 14
"""Cells up to so many characters are never broken: a number whose last digits are missing is another number."""


def text_table(name: str, content: TextTable) -> Table:
    """Return the first table of a section: what was turned, stood in a field or rested."""
    table = Table(
        box=SIMPLE_HEAD,
        title=Text(name),
        title_justify="left",
        title_style="bold",
        pad_edge=False,
        collapse_padding=True,
    )
    for index, heading in enumerate(content.headings):
        whole = [cell for row in content.rows for cell in row[index : index + 1] if len(cell) <= WHOLE]
        table.add_column(heading, min_width=max(map(len, (*whole, *heading.split())), default=0), overflow="fold")
    for row in content.rows:
        table.add_row(*(Text(cell) for cell in row))
    return table


def sensor_table(view: RunView, sensor: SensorView) -> Table:
    """Return the coefficients of one sensor; names of the laboratory are text, never markup."""
    table = Table(box=SIMPLE_HEAD, title=Text(sensor.name), title_justify="left", title_style="bold", pad_edge=False)
    table.add_column("axis", no_wrap=True, min_width=4)
    # What stands in the report only is not among them.
    shown = [[row for row in axis.parameters if row.name not in LOW_ORDER_NAMES] for axis in sensor.axes]
    cells = [[_cells(row, is_simulated=view.is_simulated) for row in rows] for rows in shown]
    labels = [[fill(row.label, LABEL) for row in rows] for rows in shown]
    lines = [line for several in labels for label in several for line in label.splitlines()]
    table.add_column("parameter", no_wrap=True, min_width=max(map(len, ("parameter", *lines))))
    headings = ("value", "± 95 %", "unit") + (("truth", "inside") if view.is_simulated else ())
    for index, heading in enumerate(headings):
        longest = max((len(row[index]) for rows in cells for row in rows), default=0)
        justify: Literal["left", "right"] = "left" if heading == "unit" else "right"
        table.add_column(heading, justify=justify, no_wrap=True, min_width=max(longest, len(heading)))
    for axis, names, rows in zip(sensor.axes, labels, cells, strict=True):
        for index, (label, row) in enumerate(zip(names, rows, strict=True)):
            table.add_row(axis.axis if index == 0 else "", label, *row, end_section=index == len(rows) - 1)
    return table


def _cells(row: ParameterRow, *, is_simulated: bool) -> tuple[str, ...]:
    if row.value is None:
        known: tuple[str, ...] = ("not determined", "—", row.unit)
    else:
        value, expanded = with_uncertainty(row.value, row.expanded_uncertainty)
        known = (value, expanded, row.unit)
    if not is_simulated:
        return known
    if row.truth is None:
        return (*known, "—", "—")
    truth = with_uncertainty(row.truth, row.expanded_uncertainty)[0]
    return (*known, truth, {True: "yes", False: "no", None: "—"}[row.holds_truth])
