"""Laws of the data-acquisition twin. Literal lines: 34970A user's guide; pyvisa-py as the other side."""

import warnings
from typing import Any

import pytest
import pyvisa
from daq_rig import daq_rig
from hypothesis import given
from hypothesis import strategies as st

from rig.clock import ScaledClock
from rig.twins.prologix import PrologixTwin
from rig.twins.scpi_port import ScpiPort
from rig.twins.serving.servers import serve_tcp


def _said(port: ScpiPort, message: bytes, now_s: float = 0.0) -> bytes:
    port.receive(message + b"\n", now_s)
    return port.transmit(now_s)


def _port(model: str = "34970A", number: int = 101) -> ScpiPort:
    return daq_rig(model, {number: "daq.x"}).port


def test_the_scan_list_of_the_guide() -> None:
    port = _port()
    assert _said(port, b"ROUT:SCAN (@101:103);:ROUT:SCAN?") == b"#214(@101,102,103)\n"
    assert _said(port, b"ROUTE:SCAN:SIZE?") == b"+3\n"
    assert _said(port, b"rout:scan (@)\r\nROUT:SCAN?") == b"#13(@)\n"


def test_short_and_long_headers_are_one() -> None:
    port = _port()
    for message in (b"SENSe:VOLTage:DC:NPLCycles 20,(@101)", b":VOLT:DC:NPLC 20, (@101)"):
        _said(port, b"*RST")
        _said(port, message)
        assert _said(port, b"volt:dc:nplc? (@101)") == b"+2.00000000E+01\n"
    assert _said(port, b"SYSTem:ERRor?") == b'+0,"No error"\n'


def test_configure_starts_the_channels_anew_and_lists_them() -> None:
    # 34970A user's guide: "it redefines the scan list"; the previous configuration of the channel is lost.
    port = _port()
    _said(port, b"VOLT:DC:NPLC 20,(@101)")
    _said(port, b"CONF:VOLT:DC 10,0.003,(@101)")
    assert _said(port, b"ROUT:SCAN?;:VOLT:DC:NPLC? (@101);RANG? (@101)") == (
        b"#16(@101);+1.00000000E+00;+1.00000000E+01\n"
    )


def test_readings_wait_for_their_time_and_may_be_fetched_again() -> None:
    port = _port()
    _said(port, b"CONF:VOLT:DC 10,(@101);:TRIG:COUN 2;:INIT")
    assert _said(port, b"FETC?") == b""
    due_s = port.next_event_s()
    assert due_s is not None
    assert port.transmit(due_s) == b"+1.00000100E+00,+1.00000200E+00\n"
    assert _said(port, b"FETC?", due_s) == b"+1.00000100E+00,+1.00000200E+00\n"
    assert _said(port, b"INIT;:DATA:POIN?", due_s) == b"+0\n"  # a new scan clears the memory


def test_read_is_initiate_and_fetch() -> None:
    port = _port()
    _said(port, b"CONF:VOLT:DC 10,(@101);:FORM:READ:CHAN ON;:READ?")
    assert port.transmit(10.0) == b"+1.00000100E+00,101\n"


@pytest.mark.parametrize(
    ("message", "error"),
    [
        (b"BEEP", b'-113,"Undefined header"\n'),
        (b"VOLT:DC:NPLC 3,(@101)", b'-222,"Data out of range"\n'),
        (b"ROUT:SCAN (@201)", b'-222,"Data out of range"\n'),
        (b"ROUT:SCAN 101", b'-224,"Illegal parameter value"\n'),
        (b"INIT", b'-221,"Settings conflict"\n'),
        (b"FETC?", b'-230,"Data corrupt or stale"\n'),
    ],
)
def test_what_it_does_not_do_stands_in_the_queue_once(message: bytes, error: bytes) -> None:
    port = _port()
    assert _said(port, message) == b""
    assert _said(port, b"SYST:ERR?") == error
    assert _said(port, b"SYST:ERR?") == b'+0,"No error"\n'


def test_the_queue_is_first_in_first_out_and_tells_when_it_is_full() -> None:
    port = _port()
    for _ in range(12):
        _said(port, b"BEEP")
    text = [_said(port, b"SYST:ERR?") for _ in range(11)]
    assert text[0] == b'-113,"Undefined header"\n'
    assert text[9] == b'-350,"Too many errors"\n'
    assert text[10] == b'+0,"No error"\n'


def test_cards_by_slot() -> None:
    assert _said(_port(), b"SYST:CTYP? 100") == b"HEWLETT-PACKARD,34901A,0,1.0\n"
    assert _said(_port(), b"SYST:CTYP? 300") == b"HEWLETT-PACKARD,0,0,0\n"
    assert _said(_port("34980A", 1001), b"SYST:CTYP? 1").startswith(b"Agilent Technologies,34921A,")


@given(st.lists(st.binary(max_size=60), max_size=6))
def test_rubbish_never_breaks_it_and_measures_nothing(pieces: list[bytes]) -> None:
    rig = daq_rig()
    for piece in pieces:
        rig.port.receive(piece, 0.0)
        rig.port.transmit(0.0)
    rig.port.receive(b"\n*CLS\n", 0.0)
    rig.port.transmit(0.0)
    assert _said(rig.port, b"SYST:ERR?") == b'+0,"No error"\n'


@given(st.data())
def test_a_message_may_come_in_pieces(data: st.DataObject) -> None:
    message = b"ROUT:SCAN (@101:103)\nROUT:SCAN?\n"
    cut = data.draw(st.integers(0, len(message)))
    port = _port()
    port.receive(message[:cut], 0.0)
    port.receive(message[cut:], 0.0)
    assert port.transmit(0.0) == b"#214(@101,102,103)\n"


def _visa() -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # pyvisa-py tells of transports that are not installed
        return pyvisa.ResourceManager("@py")


def test_pyvisa_py_takes_it_for_the_unit() -> None:
    rig, manager = daq_rig(), _visa()
    with serve_tcp(rig.port, ScaledClock(50.0)) as server:
        port = server.address.rpartition(":")[2]
        unit = manager.open_resource(f"TCPIP::127.0.0.1::{port}::SOCKET", read_termination="\n", write_termination="\n")
        try:
            assert unit.query("*IDN?") == "HEWLETT-PACKARD,34970A,0,13-2-2"
            unit.write("CONF:VOLT:DC 10,(@101:102);:TRIG:COUN 2")
            assert unit.query("ROUT:SCAN?") == "#210(@101,102)"
            values = unit.query_ascii_values("READ?")
            assert values == pytest.approx([1.0, -2.0, 1.0, -2.0], abs=1e-4)
            assert unit.query("SYST:ERR?") == '+0,"No error"'
        finally:
            unit.close()
            manager.close()


def test_pyvisa_py_takes_it_for_the_unit_behind_a_prologix_adapter() -> None:
    rig, manager = daq_rig(), _visa()
    with serve_tcp(PrologixTwin({9: rig.port}), ScaledClock(1.0)) as server:
        port = server.address.rpartition(":")[2]
        adapter = manager.open_resource(f"PRLGX-TCPIP0::127.0.0.1::{port}::INTFC")
        unit = manager.open_resource("GPIB0::9::INSTR")
        try:
            adapter.write("++read_tmo_ms 3000")
            assert unit.query("*IDN?").strip() == "HEWLETT-PACKARD,34970A,0,13-2-2"
            unit.write("CONF:VOLT:DC 10,(@101:102)")
            assert unit.query("ROUT:SCAN?").strip() == "#210(@101,102)"
            assert [float(text) for text in unit.query("READ?").split(",")] == pytest.approx([1.0, -2.0], abs=1e-4)
        finally:
            unit.close()
            adapter.close()
            manager.close()
