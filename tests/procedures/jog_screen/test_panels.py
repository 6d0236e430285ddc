"""Laws of the jog screen's text: what is not known is not shown as a number."""

import math
from dataclasses import replace

import pytest
from rich.console import Console, RenderableType

from procedures.jog_screen import panels
from procedures.jog_screen.values import AttitudeView, AxisView, BenchView, ChannelView, ShownMessage
from rig.abilities.abilities import AxisState

AXIS = AxisView("pitch", (-180.0, 180.0), (1.0, 5.0), 0.0)


def _drawn(thing: RenderableType, width: int = 100) -> str:
    console = Console(width=width, color_system=None)
    with console.capture() as capture:
        console.print(thing)
    return capture.get()


def _state(**changes: object) -> AxisState:
    return replace(AxisState(12.0, False, True, True, ""), **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (_state(), "at rest"),
        (_state(is_homed=False), "not homed"),
        (_state(is_moving=True), "moving"),
        (_state(is_seated=False), "not seated"),
        (_state(fault="limit switch"), "limit switch"),
        (_state(awaits_operator=True, is_moving=True), "your turn"),
    ],
)
def test_the_state_of_an_axis_is_in_words(state: AxisState, words: str) -> None:
    view = BenchView((replace(AXIS, state=state),), (), ())
    assert words in _drawn(panels.axes_panel(view, "pitch", 1.0, 100))


@pytest.mark.parametrize(("wound_turns", "words"), [(2.274, "cables +2.27 turns"), (math.nan, "cables unknown")])
def test_cables_are_told_as_wound_as_they_are_known_to_be(wound_turns: float, words: str) -> None:
    view = BenchView((replace(AXIS, state=_state(), wound_turns=wound_turns),), (), ())
    drawn = _drawn(panels.axes_panel(view, "pitch", 1.0, 100))
    assert words in drawn
    assert "nan" not in drawn


def test_a_silent_axis_has_no_position() -> None:
    text = _drawn(panels.axes_panel(BenchView((replace(AXIS, silence="no reply"),), (), ()), "pitch", 1.0, 100))
    assert "no answer" in text
    assert "no reply" in text
    assert "0.0000" not in text


@pytest.mark.parametrize(("degrees", "index"), [(-180.0, 0), (0.0, 10), (180.0, 20), (90.0, 15), (400.0, 20)])
def test_the_gauge_shows_where_the_axis_stands(degrees: float, index: int) -> None:
    drawn = panels.gauge(replace(AXIS, state=_state(position_deg=degrees)), 21).plain
    assert len(drawn) == 21
    assert drawn.index("●") == index


@pytest.mark.parametrize(
    ("value_v", "text"), [(1.5, "1.5 V"), (2.34e-3, "2.34 mV"), (21.4e-6, "21.4 µV"), (3e-9, "3 nV"), (math.nan, "—")]
)
def test_a_spread_is_told_in_the_unit_that_leaves_digits(value_v: float, text: str) -> None:
    assert panels.spread(value_v) == text


def test_a_sparkline_spans_its_values() -> None:
    assert panels.sparkline([0.0, 7.0, 3.5]) == "▁█▅"
    assert panels.sparkline([2.0, 2.0]) == "▄▄"
    assert panels.sparkline([]) == ""
    assert len(panels.sparkline([float(n) for n in range(500)], 24)) == 24


def test_an_angle_that_the_outputs_do_not_tell_is_a_dash_with_its_reason() -> None:
    attitude = AttitudeView("SN1", (("pitch", 89.9, 1e-4), ("roll", math.nan, math.nan)), "roll undetermined")
    text = _drawn(panels.surroundings_panel(BenchView((), (), (), attitude)))
    assert "roll  —  roll undetermined" in text
    assert "+89.9000° ± 0.36″" in text


@pytest.mark.parametrize(("unknown", "is_compared"), [("", True), ("no pulse is sent, position not known", False)])
def test_an_attitude_is_compared_with_no_table_of_which_nobody_knows_where_it_stands(
    unknown: str, *, is_compared: bool
) -> None:
    attitude = AttitudeView("SN1", (("pitch", 10.0, 1e-4),), "")
    axis = replace(AXIS, state=_state(unknown=unknown))
    text = _drawn(panels.surroundings_panel(BenchView((axis,), (), (), attitude)))
    assert ("to the table" in text) is is_compared


def test_overloads_are_told() -> None:
    view = BenchView((), (ChannelView("dmm.x", count=3, mean=1.0, standard_deviation=0.1, overloads=2),), ())
    assert "2 overloads" in _drawn(panels.channels_panel(view.channels, 100))


def test_a_channel_in_degrees_is_not_in_volts() -> None:
    view = BenchView((), (ChannelView("level.tilt", 3, unit="deg", mean=12.25, standard_deviation=0.001),), ())
    text = _drawn(panels.channels_panel(view.channels, 100))
    assert "+12.2500000 °" in text
    assert "3.6 ″" in text


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_a_key_stands_beside_its_meaning_at_any_width(width: int) -> None:
    lines = panels.keys_lines((("g", "go to"), ("h", "home"), ("c", "chamber")) * 3, width).plain.splitlines()
    assert all(len(line) <= width for line in lines)
    assert sum(line.count("g go to") + line.count("c chamber") for line in lines) == 6


def _channels(count: int, read: int) -> tuple[ChannelView, ...]:
    return tuple(ChannelView(f"daq.{index}", count=index < read) for index in range(count))


def test_every_channel_stands_on_one_page_and_no_page_is_empty() -> None:
    channels = _channels(24, 24)
    pages = [panels.page_of(channels, 5, number) for number in range(5)]
    assert [channel.name for page in pages for channel in page.channels] == [channel.name for channel in channels]
    assert [page.label for page in pages][-1] == "page 5 of 5"
    assert panels.page_of(channels, 5, 99) == pages[-1]
    assert panels.page_of(channels, 24, 0).label == ""


def test_the_first_sweep_is_told_until_every_channel_was_read_or_is_silent() -> None:
    assert panels.sweep_text(_channels(24, 7)) == "first sweep: 7 of 24 channels read"
    assert panels.sweep_text((*_channels(2, 2), ChannelView("z", silence="no reply"))) == ""


@pytest.mark.parametrize("lines", range(1, 5))
@pytest.mark.parametrize("width", [20, 60])
def test_the_newest_message_is_seen_whatever_fits(lines: int, width: int) -> None:
    said = [ShownMessage("12:00:00", "note", f"message {index} " + "long " * index) for index in range(8)]
    text = panels.messages_panel(said, lines, width).plain
    assert "message 7" in text
    assert sum(-(-len(line) // width) for line in text.splitlines()) <= lines


@pytest.mark.parametrize("width", [40, 58, 78, 198])
def test_the_stop_stands_first_among_the_keys_however_few_lines_there_are(width: int) -> None:
    lines = panels.keys_lines((("g", "go to"), ("h", "home")) * 12, width, 2).plain.splitlines()
    assert len(lines) <= 2
    assert lines[0].startswith(" SPACE  stops everything")
    assert all(len(line) <= width for line in lines)


def test_a_rig_without_a_readout_says_so_where_its_readings_would_be() -> None:
    assert _drawn(panels.channels_panel((), 80)).strip() == "no channel of a readout in this rig"
