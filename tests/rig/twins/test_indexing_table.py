"""Laws of the table's twin, by its lines. Literal frames: the design's worked dialect (chapter 5)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from table_bench import table_bench

from rig.twins.indexing_table import IndexingTableTwin


def _said(twin: IndexingTableTwin, line: bytes, now_s: float) -> bytes:
    twin.receive(line, now_s)
    return twin.transmit(now_s)


def _homed() -> IndexingTableTwin:
    twin = table_bench().twin
    for axis in (b"1", b"2"):
        assert _said(twin, axis + b" HOME\r\n", 0.0) == axis + b" OK\r\n"
    return twin


def test_the_worked_dialect() -> None:
    twin = _homed()
    assert _said(twin, b"1 MOVE +010.0000\r\n", 100.0) == b"1 OK\r\n"
    assert _said(twin, b"1 POS?\r\n", 200.0) == b"1 POS +010.0000\r\n"
    assert _said(twin, b"1 STAT?\r\n", 200.0) == b"1 STAT IDLE SEATED LOCKED HOMED\r\n"
    assert _said(twin, b"1 STOP\r\n", 200.0) == b"1 OK\r\n"
    assert _said(twin, b"ID?\r\n", 200.0).startswith(b"ID ")


def test_it_lifts_turns_seats_and_locks_in_time() -> None:
    twin = _homed()
    _said(twin, b"1 MOVE +010.0000\r\n", 100.0)
    states = {at_s: _said(twin, b"1 STAT?\r\n", 100.0 + at_s) for at_s in (0.1, 1.0, 2.6, 3.4)}
    moving, resting = b"1 STAT MOVING LIFTED UNLOCKED HOMED\r\n", b"1 STAT IDLE SEATED LOCKED HOMED\r\n"
    # 0.5 s to lift, 10° at 5 °/s, 0.8 s to seat and lock: 3.3 s.
    assert states == {0.1: moving, 1.0: moving, 2.6: moving, 3.4: resting}
    twin = _homed()
    _said(twin, b"1 MOVE +010.0000\r\n", 100.0)
    assert _said(twin, b"1 POS?\r\n", 100.4) == b"1 POS +000.0000\r\n"
    assert _said(twin, b"1 POS?\r\n", 101.5) == b"1 POS +005.0000\r\n"


def test_axes_are_moved_apart() -> None:
    twin = _homed()
    _said(twin, b"2 MOVE -030.0000\r\n", 100.0)
    assert _said(twin, b"1 POS?\r\n2 POS?\r\n", 200.0) == b"1 POS +000.0000\r\n2 POS -030.0000\r\n"


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"1 MOVE +010.5000\r\n", b"1 ERR OFF INCREMENT\r\n"),
        (b"1 MOVE +361.0000\r\n", b"1 ERR OUTSIDE TRAVEL\r\n"),
        (b"3 MOVE +010.0000\r\n", b"3 ERR NO SUCH AXIS\r\n"),
        (b"1 MOVE 10\r\n", b"1 ERR SYNTAX\r\n"),
        (b"\xff\xfe\r\n", b"0 ERR SYNTAX\r\n"),
    ],
)
def test_it_says_no_by_name(line: bytes, reply: bytes) -> None:
    assert _said(_homed(), line, 100.0) == reply


def test_it_comes_up_without_a_home_and_does_not_move_without() -> None:
    twin = table_bench().twin
    assert _said(twin, b"1 STAT?\r\n", 0.0) == b"1 STAT IDLE SEATED LOCKED UNHOMED\r\n"
    assert _said(twin, b"1 MOVE +010.0000\r\n", 0.0) == b"1 ERR NOT HOMED\r\n"


def test_it_takes_no_second_move_while_moving() -> None:
    twin = _homed()
    _said(twin, b"1 MOVE +010.0000\r\n", 100.0)
    assert _said(twin, b"1 MOVE +020.0000\r\n", 101.0) == b"1 ERR MOVING\r\n"
    assert _said(twin, b"1 HOME\r\n", 101.0) == b"1 ERR MOVING\r\n"


def test_a_stop_seats_at_the_next_tooth() -> None:
    twin = _homed()
    _said(twin, b"1 MOVE +100.0000\r\n", 100.0)
    _said(twin, b"1 STOP\r\n", 101.3)  # at 4.0° + a little
    assert _said(twin, b"1 STAT?\r\n", 103.0) == b"1 STAT IDLE SEATED LOCKED HOMED\r\n"
    assert _said(twin, b"1 POS?\r\n", 103.0) == b"1 POS +004.0000\r\n"


def test_a_power_cycle_loses_the_home_and_lies_about_the_position() -> None:
    bench = table_bench()
    bench.home_all()
    _said(bench.twin, b"1 MOVE +030.0000\r\n", 1000.0)
    bench.twin.axes[1].power_cycle(1100.0)
    assert _said(bench.twin, b"1 POS?\r\n1 STAT?\r\n", 1100.0) == (
        b"1 POS +000.0000\r\n1 STAT IDLE SEATED LOCKED UNHOMED\r\n"
    )
    assert bench.world.axes["pitch"].table_deg(1100.0) == 30.0
    _said(bench.twin, b"1 HOME\r\n", 1100.0)
    assert bench.world.axes["pitch"].table_deg(1200.0) == 0.0
    assert _said(bench.twin, b"1 STAT?\r\n", 1200.0) == b"1 STAT IDLE SEATED LOCKED HOMED\r\n"


def test_a_home_that_was_stopped_is_none() -> None:
    bench = table_bench()
    bench.home_all()
    _said(bench.twin, b"1 MOVE +030.0000\r\n", 1000.0)
    bench.twin.axes[1].power_cycle(1100.0)
    _said(bench.twin, b"1 HOME\r\n", 1200.0)
    _said(bench.twin, b"1 STOP\r\n", 1201.0)
    assert _said(bench.twin, b"1 STAT?\r\n", 1300.0) == b"1 STAT IDLE SEATED LOCKED UNHOMED\r\n"


def test_commands_may_come_byte_by_byte() -> None:
    twin = _homed()
    said = b"".join(_said(twin, bytes([byte]), 100.0) for byte in b"1 MOVE +010.0000\r\n1 POS?\r\n")
    assert said == b"1 OK\r\n1 POS +000.0000\r\n"


@given(st.lists(st.binary(max_size=30), max_size=8))
def test_rubbish_moves_nothing_and_ends_with_the_line(rubbish: list[bytes]) -> None:
    twin = _homed()
    for piece in rubbish:
        _said(twin, piece, 100.0)
    _said(twin, b"\r\n", 100.0)
    assert _said(twin, b"1 POS?\r\n", 300.0) == b"1 POS +000.0000\r\n"
