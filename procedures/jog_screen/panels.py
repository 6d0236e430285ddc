"""The parts of the jog screen as text: pure functions of a view."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from rich.console import Group
from rich.table import Table
from rich.text import Text

from ams.units import ARCSEC_PER_DEG, printed, small_unit
from procedures.jog_screen.heading import Heading
from procedures.jog_screen.values import AttitudeView, AxisView, BenchView, ChamberView, ChannelView, ShownMessage

ACCENT, GOOD, WARM, BAD, QUIET, FAINT = "#5fd7d7", "#87d787", "#ffd75f", "#ff5f5f", "#9aa5b1", "#5b6672"
TONES = {"done": GOOD, "refused": WARM, "failed": BAD, "stopped": BAD, "note": QUIET}
_BLOCKS = "▁▂▃▄▅▆▇█"
_GAUGE, _SMALL_GAUGE, _WIDE, _NARROW = 25, 11, 100, 80
_SPARK, _SMALL_SPARK = 24, 12
TALL = 30
"""Lines from which the panels need not be sparing."""
MOST_KEY_LINES = 4
_HEAD, _BORDER, _PROMPT, _FEWEST_MESSAGES = 2, 2, 3, 1


@dataclass(frozen=True, slots=True)
class Room:
    """What fits on a screen of some height beside what must always be seen."""

    channels: int
    """Lines of readings."""
    has_surroundings: bool


@dataclass(frozen=True, slots=True)
class Page:
    """Some of the channels."""

    channels: tuple[ChannelView, ...]
    number: int
    label: str
    """Which page of how many; empty where one holds them all."""


def room_of(view: BenchView, height: int, key_lines: int, *, has_question: bool) -> Room:
    """Return the room for readings: head, axes, last message, prompt and keys come first."""
    kept = _HEAD + len(view.axes) + _BORDER + _FEWEST_MESSAGES + _BORDER + key_lines + _PROMPT * has_question
    around = len(view.chambers) + (view.attitude is not None) or 1
    left = height - kept - _BORDER - 1  # the line of headings
    has_surroundings = left - around - _BORDER >= min(len(view.channels), 4)
    return Room(max(left - (around + _BORDER) * has_surroundings, 1), has_surroundings)


def page_of(channels: Sequence[ChannelView], lines: int, number: int) -> Page:
    """Return a page of so many lines; the last one where there are fewer pages."""
    pages = max(-(-len(channels) // lines), 1)
    number = min(number, pages - 1)
    shown = tuple(channels[number * lines : (number + 1) * lines])
    return Page(shown, number, f"page {number + 1} of {pages}" if pages > 1 else "")


def sweep_text(channels: Sequence[ChannelView]) -> str:
    """Tell how far the first sweep over all channels is; empty once each was read."""
    seen = sum(channel.count > 0 or bool(channel.silence) for channel in channels)
    return "" if seen == len(channels) else f"first sweep: {seen} of {len(channels)} channels read"


def head(heading: Heading, view: BenchView) -> Group:
    title = Text.assemble(("calrig jog", f"bold {ACCENT}"), "   ", (heading.rig, "bold white"))
    below = Text(f"{heading.time}   {heading.owner}", QUIET, no_wrap=True, overflow="ellipsis")
    if view.waits_for:
        below = Text(view.waits_for, WARM, no_wrap=True, overflow="ellipsis")
    return Group(_apart(title, _activity(view)), below)


def _apart(left: Text, right: Text) -> Table:
    """Return one line with its two texts at its two ends."""
    table = Table.grid(expand=True, padding=(0, 1))
    table.add_column(ratio=1, no_wrap=True, overflow="ellipsis")
    table.add_column(justify="right", no_wrap=True)
    table.add_row(left, right)
    return table


def keys_lines(keys: Sequence[tuple[str, str]], width: int, lines: int = MOST_KEY_LINES) -> Text:
    """Keys and what they do in at most so many lines, a key never apart from its meaning; the stop comes first."""
    text = Text.assemble((" SPACE ", "bold white on #d70000"), (" stops everything", f"bold {BAD}"))
    used = len(text)
    for key, meaning in keys:
        length = len(key) + len(meaning) + 3
        is_full = used + length > width
        lines -= is_full
        if lines < 1:
            break
        used = length if is_full else used + length
        text.append("\n " if is_full else "  ").append(key, f"bold {ACCENT}").append(f" {meaning}", QUIET)
    return text


def prompt_line(typed: str) -> Text:
    hint = Text("   enter: do it   esc: back   space: stop everything", FAINT)
    return Text(typed, "bold white") + Text("█", WARM) + hint


def _activity(view: BenchView) -> Text:
    if view.is_stopping:
        return Text.assemble(("\u00a0STOPPING\u00a0", "bold white on #d70000"))
    if view.doing:
        return Text.assemble((f"\u00a0{view.doing}\u00a0", f"bold black on {WARM}"))
    return Text.assemble(("\u00a0at rest\u00a0", f"black on {GOOD}"))


def axes_panel(view: BenchView, selected: str, step_deg: float, width: int) -> Table:
    table = Table.grid(expand=True, padding=(0, 1))
    gauge_width = _GAUGE if width >= _WIDE else _SMALL_GAUGE
    has_gauge = width >= _NARROW
    for column, justify in ((9, "left"), (12, "right"), (12, "left"), (gauge_width + 10, "left"))[: 3 + has_gauge]:
        table.add_column(width=column, justify=justify)  # type: ignore[arg-type]
    table.add_column(ratio=1, no_wrap=True, overflow="ellipsis")
    for axis in view.axes:
        is_selected = axis.name == selected
        mark = Text("▌" if is_selected else " ", ACCENT) + Text(axis.name, f"bold {ACCENT}" if is_selected else "bold")
        table.add_row(
            mark,
            _position(axis),
            _state(axis),
            *([_between_limits(axis, gauge_width)] if has_gauge else []),
            _detail(axis, is_selected, step_deg),
        )
    return table


def gauge(axis: AxisView, width: int) -> Text:
    """Draw where the axis stands between its limits: ● itself, ◇ its target, ┼ zero."""
    low_deg, high_deg = axis.limits_deg
    cells = ["├", *"─" * (width - 2), "┤"]
    styles = [FAINT] * width

    def put(degrees: float, sign: str, style: str) -> None:
        column = round((min(max(degrees, low_deg), high_deg) - low_deg) / (high_deg - low_deg) * (width - 1))
        cells[column], styles[column] = sign, style

    if low_deg < 0.0 < high_deg:
        put(0.0, "┼", FAINT)
    if axis.target_deg is not None:
        put(axis.target_deg, "◇", WARM)
    if axis.state is not None and not axis.state.unknown:
        put(axis.state.position_deg, "●", GOOD if axis.state.is_homed else WARM)
    return Text.assemble(*zip(cells, styles, strict=True))


def sparkline(values: Sequence[float], width: int = 24) -> str:
    """Draw the last values as blocks between their own least and greatest."""
    shown = values[-width:]
    if not shown:
        return ""
    low, high = min(shown), max(shown)
    if high == low:
        return _BLOCKS[3] * len(shown)
    return "".join(_BLOCKS[min(int((value - low) / (high - low) * 8.0), 7)] for value in shown)


def channels_panel(channels: Sequence[ChannelView], width: int) -> Table | Text:
    """Return a row a channel; a narrow screen has no line of the last readings."""
    if not channels:
        return Text("no channel of a readout in this rig", FAINT)
    table = Table.grid(expand=True, padding=(0, 1))
    columns = [("channel", 14, "left"), ("mean", 13, "right"), ("deviation", 9, "right"), ("n", 6, "right")]
    if width >= _NARROW:
        columns.append(("recent", _SPARK if width >= _WIDE else _SMALL_SPARK, "left"))
    for _, wide, justify in columns:
        table.add_column(width=wide, justify=justify, no_wrap=True)  # type: ignore[arg-type]
    table.add_column(ratio=1, no_wrap=True, overflow="ellipsis")
    table.add_row(*(Text(name, FAINT) for name, _, _ in columns), Text(""))
    for channel in channels:
        cells = _channel(channel, _SPARK if width >= _WIDE else _SMALL_SPARK)
        table.add_row(*cells[: len(columns)], cells[-1])
    return table


def surroundings_panel(view: BenchView) -> Text:
    """Return the chambers, and what the set makes of the readings."""
    lines = [_chamber(chamber) for chamber in view.chambers]
    if view.attitude is not None:
        lines.append(_attitude(view.attitude, view.axes))
    return Text("\n").join(lines) if lines else Text("no chamber in this rig", FAINT)


def messages_panel(messages: Sequence[ShownMessage], lines: int, width: int) -> Text:
    """Return the newest messages that fit, folded to the width; of one that alone does not fit, its beginning."""
    text = Text(overflow="fold")
    shown: list[ShownMessage] = []
    left = lines
    for line in reversed(messages):
        needed = max(-(-(len(line.clock) + 1 + len(line.text)) // max(width, 1)), 1)
        if needed > left:
            if not shown and left > 0:
                room = left * width - len(line.clock) - 2
                shown.append(replace(line, text=f"{line.text[: max(room, 0)]}…"))
            break
        shown.append(line)
        left -= needed
    for line in reversed(shown):
        text.append(f"{line.clock} ", FAINT)
        text.append(f"{line.text}\n", TONES[line.tone])
    text.right_crop(1)
    return text


def reading_text(value: float, unit: str) -> str:
    """Return a reading, its unit as it is written in a key."""
    return "—" if math.isnan(value) else f"{value:+.7f} {printed(unit)}"


def spread(value_v: float, unit: str = "v") -> str:
    """Return a standard deviation in the unit that leaves it three digits."""
    if math.isnan(value_v):
        return "—"
    if unit != "v":
        small, factor = small_unit(printed(unit))
        return f"{value_v * factor:.3g} {small}"
    for factor, unit in ((1.0, "V"), (1e3, "mV"), (1e6, "µV"), (1e9, "nV")):
        if value_v * factor >= 1.0:
            return f"{value_v * factor:.3g} {unit}"
    return f"{value_v * 1e9:.2g} nV"


def _between_limits(axis: AxisView, width: int) -> Text:
    low_deg, high_deg = axis.limits_deg
    return Text.assemble((f"{low_deg:>4g} ", FAINT), gauge(axis, width), (f" {high_deg:<+4g}", FAINT))


def _position(axis: AxisView) -> Text:
    if axis.state is None:
        return Text("—", FAINT)
    if axis.state.unknown:
        return Text("not known", f"bold {WARM}")
    trusted = axis.state.is_homed
    return Text(f"{axis.state.position_deg:+.4f}°", f"bold {'white' if trusted else WARM}")


def _state(axis: AxisView) -> Text:
    state = axis.state
    if state is None:
        return Text("no answer" if axis.silence else "asking …", BAD if axis.silence else QUIET)
    if state.fault:
        return Text("◼ fault", f"bold {BAD}")
    if axis.set_rate_dps is not None:
        return Text("↻ turning", f"bold {WARM}")
    if state.awaits_operator:
        return Text("… your turn", WARM)
    if state.is_moving:
        return Text("▶ moving", f"bold {WARM}")
    if not state.is_homed:
        return Text("○ not homed", WARM)
    return Text("● at rest", GOOD) if state.is_seated else Text("◌ not seated", BAD)


def _detail(axis: AxisView, is_selected: bool, step_deg: float) -> Text:
    if axis.silence or (axis.state is not None and axis.state.fault):
        return Text(axis.silence or (axis.state.fault if axis.state else ""), BAD)
    parts = []
    if is_selected:
        parts.append(Text(f"step\u00a0{step_deg:g}°", f"bold {ACCENT}"))
    if axis.target_deg is not None:
        parts.append(Text(f"◇ {axis.target_deg:+g}°", WARM))
    if axis.measured is not None:
        parts.append(Text(f"measured {axis.measured.rate_dps:+.4f} °/s", GOOD))
    elif axis.set_rate_dps is not None:
        parts.append(Text(f"asked {axis.set_rate_dps:+g} °/s", WARM))
    if axis.wound_turns is not None and math.isnan(axis.wound_turns):
        parts.append(Text("cables unknown", WARM))
    elif axis.wound_turns is not None:
        parts.append(Text(f"cables {axis.wound_turns:+.2f} turns", QUIET))
    if axis.pulse_us is not None:
        parts.append(Text(f"{axis.pulse_us:.2f} µs", QUIET))
    return Text("  ").join(parts)


def _channel(channel: ChannelView, spark_width: int) -> tuple[Text, ...]:
    note = Text(f"{channel.overloads} overloads" if channel.overloads else "", BAD)
    if channel.silence:
        note = Text(channel.silence, BAD)
    return (
        Text(channel.name, "bold"),
        Text(reading_text(channel.mean, channel.unit), "bold white"),
        Text(spread(channel.standard_deviation, channel.unit), QUIET),
        Text(str(channel.count), QUIET),
        Text(sparkline(channel.recent, spark_width), ACCENT),
        note,
    )


def _chamber(chamber: ChamberView) -> Text:
    text = Text.assemble((f"{chamber.name:<10}", "bold"))
    if chamber.silence:
        return text.append(chamber.silence, BAD)
    if chamber.temperature_degc is None:
        return text.append("asking …", QUIET)
    text.append(f"{chamber.temperature_degc:+.2f} °C", "bold white")
    return text.append(f"   setpoint {chamber.setpoint_degc:g} °C", QUIET)


def _attitude(attitude: AttitudeView, axes: Sequence[AxisView]) -> Text:
    text = Text.assemble((f"{attitude.sensor:<8}", f"bold {ACCENT}"))
    states = {axis.name: axis.state for axis in axes if axis.state is not None}
    table_deg = {name: state.position_deg for name, state in states.items() if not state.unknown}
    for name, degrees, sd_deg in attitude.angles:
        text.append(f"  {name}  ", QUIET)
        if math.isnan(degrees):
            text.append("—", FAINT)
            continue
        text.append(f"{degrees:+.4f}°", "bold white")
        text.append(f" ± {sd_deg * ARCSEC_PER_DEG:.2g}″", QUIET)
        if name in table_deg:
            away_arcsec = round((degrees - table_deg[name]) * ARCSEC_PER_DEG, 1) + 0.0
            text.append(f" ({away_arcsec:+.1f}″ to the table)" if away_arcsec else " (as the table)", FAINT)
    return text.append(f"  {attitude.flag}" if attitude.flag else "", WARM)
