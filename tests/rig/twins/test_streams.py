"""Laws of the streaming twins: registers as in the manual, samples in their beat, on real ports as in memory."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from stream_rig import Swing, csv_rig, vn100_settings

from rig.clock import SystemClock
from rig.devices.vn100 import connect
from rig.link.ports import open_stream
from rig.twins.physics.metronome import BACKLOG_S, Metronome
from rig.twins.serving.servers import serve_pty, serve_tcp
from rig.twins.vn100 import Vn100Twin


def _quiet() -> Vn100Twin:
    twin = Vn100Twin("imu", Swing())
    twin.receive(b"$VNASY,0*4F\r\n", 0.0)
    twin.transmit(0.0)
    return twin


def _said(twin: Vn100Twin, line: bytes) -> bytes:
    twin.receive(line, 1.0)
    return twin.transmit(1.0)


@pytest.mark.parametrize(
    ("question", "answered"),
    [
        (b"$VNRRG,1*42\r\n", b"$VNRRG,01,VN-100T-CR*32\r\n"),
        (b"$VNRRG,1*XX\r\n", b"$VNRRG,01,VN-100T-CR*32\r\n"),
        (b"$VNRRG,07*74\r\n", b"$VNRRG,07,40*5C\r\n"),
        (b"$VNWRG,07,40*59\r\n", b"$VNWRG,07,40*59\r\n"),
        (b"$VNASY,0*4F\r\n", b"$VNASY,0*4F\r\n"),
    ],
)
def test_registers_answer_with_lines_seen_on_real_units(question: bytes, answered: bytes) -> None:
    assert _said(_quiet(), question) == answered


@pytest.mark.parametrize(
    ("question", "code"),
    [
        (b"$VNRRG,1*43\r\n", b"03"),
        (b"$VNXXX,1*XX\r\n", b"04"),
        (b"$VNWRG,6*XX\r\n", b"05"),
        (b"$VNWRG,6,1,2*XX\r\n", b"06"),
        (b"$VNWRG,6,77*XX\r\n", b"07"),
        (b"$VNRRG,199*XX\r\n", b"08"),
        (b"$VNWRG,1,5*XX\r\n", b"09"),
    ],
)
def test_errors_have_the_codes_of_the_manual(question: bytes, code: bytes) -> None:
    assert _said(_quiet(), question).startswith(b"$VNERR," + code)


def test_it_streams_from_the_first_moment_as_delivered() -> None:
    twin = Vn100Twin("imu", Swing())
    twin.transmit(0.0)
    assert twin.transmit(1.0).count(b"$VNYMR,") == 40
    assert twin.next_event_s() == pytest.approx(41 / 40)


@given(st.lists(st.binary(max_size=80), max_size=5))
def test_rubbish_never_breaks_it(pieces: list[bytes]) -> None:
    twin = _quiet()
    for piece in pieces:
        _said(twin, piece)
    _said(twin, b"\n")
    assert _said(twin, b"$VNRRG,1*42\r\n").endswith(b"$VNRRG,01,VN-100T-CR*32\r\n")


@given(st.lists(st.floats(0.0, 5.0), min_size=1, max_size=30), st.sampled_from([1.0, 40.0, 200.0]))
def test_the_beat_misses_none_and_repeats_none_however_it_is_asked(pauses_s: list[float], rate_hz: float) -> None:
    beat, now_s, numbers = Metronome(), 0.0, []
    beat.start(0.0, rate_hz)
    for pause_s in pauses_s:
        now_s += pause_s
        numbers += [number for number, _ in beat.due(now_s)]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) == int(now_s * rate_hz + 1e-9) + 1


def test_what_nobody_takes_is_lost_as_in_a_buffer() -> None:
    beat = Metronome()
    beat.start(0.0, 10.0)
    numbers = [number for number, _ in beat.due(10.0 * BACKLOG_S)]
    assert (numbers[0], numbers[-1]) == (9 * BACKLOG_S * 10, 10 * BACKLOG_S * 10)


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty])
def test_the_driver_meets_the_twin_on_a_real_port(serve: type) -> None:
    clock = SystemClock()
    with serve(Vn100Twin("imu", Swing()), clock) as server:
        stream = open_stream(server.address, clock=clock, baud_rate=460800)
        imu = connect("imu", vn100_settings(rate_hz=200), stream, clock)
        assert imu.identify().startswith("VectorNav VN-100T-CR")
        imu.start()
        samples, ends_s = 0, clock.monotonic_s() + 5.0
        while samples < 40 and clock.monotonic_s() < ends_s:
            stream_block = imu.poll()
            assert stream_block.refused == 0
            samples += stream_block.samples
        imu.stop()
        stream.close()
    assert samples >= 40


def test_the_board_talks_in_its_columns() -> None:
    twin = csv_rig(banner=b"n,t,ax,ay,az,gz,mx,x\r\n").twin
    assert twin.transmit(0.0) == b"n,t,ax,ay,az,gz,mx,x\r\n0,0,0,0,-1333,0,625,0\r\n"
    assert twin.transmit(0.011) == b"1,10,0,0,-1333,3,625,0\r\n"
