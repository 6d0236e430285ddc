"""Laws of the Zaber stages' twin, by its lines and by the maker's own library."""

from collections.abc import Callable

import pytest
import zaber_motion
from hypothesis import given
from hypothesis import strategies as st
from motion_bench import motion_bench
from zaber_motion.ascii import Connection

from rig.clock import Clock, ScaledClock
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp
from rig.twins.zaber import ZaberTwin


def _said(twin: ZaberTwin, line: bytes, now_s: float) -> bytes:
    twin.receive(line, now_s)
    return twin.transmit(now_s)


def _plain() -> ZaberTwin:
    """Replies without checksum, homed."""
    twin: ZaberTwin = motion_bench("zaber").twin
    for stage in twin.stages.values():
        stage.settings["comm.checksum"] = 0
    _said(twin, b"/home\n", 0.0)
    return twin


def test_it_answers_the_captured_lines() -> None:
    twin: ZaberTwin = motion_bench("zaber").twin
    assert _said(twin, b"/1 0 00 get pos:2D\n", 0.0).startswith(b"@01 0 00 OK IDLE WR 0:")
    assert _said(twin, b"/1 1 01 move abs 5000:EB\n", 0.0).startswith(b"@01 1 01 OK BUSY WR 0:")
    assert _said(twin, b"/1 0 00 get pos:2E\n", 0.0) == b""  # a wrong checksum


def test_a_stage_goes_where_it_is_sent() -> None:
    twin = _plain()
    assert _said(twin, b"/1 1 move abs 42667\r\n", 100.0) == b"@01 1 OK BUSY -- 0\r\n"
    assert _said(twin, b"/1 1\n", 101.0) == b"@01 1 OK BUSY -- 0\r\n"
    assert _said(twin, b"/1 1 get pos\n", 110.0) == b"@01 1 OK IDLE -- 42667\r\n"  # 10 deg
    assert _said(twin, b"/1 1 move rel -42667\n", 110.0).startswith(b"@01 1 OK BUSY")
    assert _said(twin, b"/1 1 get pos\n", 120.0) == b"@01 1 OK IDLE -- 0\r\n"


def test_a_search_of_a_stage_that_has_a_zero_counts_from_it_whatever_was_lost_before() -> None:
    """A power cycle at 10 degrees long ago made the next searches leap by 10 degrees: a zero that moved, by nobody."""
    twin = _plain()
    _said(twin, b"/1 1 move abs 42667\n", 100.0)
    twin.stages[1].power_cycle(110.0)
    _said(twin, b"/1 1 home\n", 120.0)
    _said(twin, b"/1 1 move abs 85334\n", 140.0)
    before = int(_said(twin, b"/1 1 get pos\n", 160.0).split()[-1])
    _said(twin, b"/1 1 home\n", 160.0)
    assert before == 85334
    assert int(_said(twin, b"/1 1 get pos\n", 160.0).split()[-1]) == before


def test_a_stage_turns_at_its_rate_and_is_stopped() -> None:
    twin = _plain()
    # 10 deg/s: 42666.67 microsteps/s, times 1.6384.
    _said(twin, b"/1 1 move vel 69905\n", 100.0)
    start, end = (int(_said(twin, b"/1 1 get pos\n", now_s).split()[-1]) for now_s in (110.0, 146.0))
    assert (end - start) * 0.000234375 == pytest.approx(360.0, abs=0.01)
    _said(twin, b"/1 1 stop\n", 150.0)
    assert _said(twin, b"/1 1\n", 151.0) == b"@01 1 OK IDLE NI 0\r\n"
    assert _said(twin, b"/1 1 warnings clear\n", 151.0) == b"@01 1 OK IDLE -- 01 NI\r\n"


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"/1 1 fly\n", b"@01 1 RJ IDLE -- BADCOMMAND\r\n"),
        (b"/1 1 move abs x\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/1 2 get pos\n", b"@01 2 RJ IDLE -- BADAXIS\r\n"),
        (b"/1 1 set maxspeed 0\n", b"@01 1 RJ IDLE -- BADDATA\r\n"),
        (b"/3 1 get pos\n", b""),
        (b"get pos\n", b""),
    ],
)
def test_it_rejects_by_name(line: bytes, reply: bytes) -> None:
    assert _said(_plain(), line, 100.0) == reply


def test_every_device_answers_a_broadcast() -> None:
    assert _said(_plain(), b"/\n", 100.0) == b"@01 0 OK IDLE -- 0\r\n@02 0 OK IDLE -- 0\r\n"


@given(st.lists(st.binary(max_size=30), max_size=8))
def test_rubbish_never_breaks_it(rubbish: list[bytes]) -> None:
    twin = _plain()
    for piece in rubbish:
        _said(twin, piece, 100.0)
    _said(twin, b"\n", 100.0)
    assert _said(twin, b"/1 1 get deviceid\n", 300.0).endswith(b" 50952\r\n")


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty], ids=["tcp", "pty"])
def test_the_makers_library_drives_it(serve: Callable[[ZaberTwin, Clock], TwinServer]) -> None:
    """zaber-motion's generic commands: ids and checksums are its own."""
    twin: ZaberTwin = motion_bench("zaber").twin
    with serve(twin, ScaledClock(100.0)) as server, _open(Connection, server.address) as connection:
        stage = connection.get_device(1)
        assert stage.generic_command("get deviceid").data == "50952"
        axis = stage.get_axis(1)
        assert axis.generic_command("").warning_flag == "WR"
        axis.generic_command("home")
        axis.wait_until_idle()
        axis.generic_command("move abs 5000")
        axis.wait_until_idle()
        assert axis.generic_command("get pos").data == "5000"
        with pytest.raises(zaber_motion.exceptions.BadCommandException):
            axis.generic_command("fly")
        with pytest.raises(zaber_motion.exceptions.BadDataException):
            axis.generic_command("move abs x")


def _open(connections: type, address: str) -> object:
    if address.startswith("socket://"):
        host, port = address.removeprefix("socket://").split(":")
        return connections.open_tcp(host, int(port))  # type: ignore[attr-defined]
    return connections.open_serial_port(address)  # type: ignore[attr-defined]
