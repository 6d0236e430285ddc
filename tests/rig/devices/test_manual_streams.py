"""What manuals and maintainers say of streaming devices: docs/devices/vn100.md, docs/devices/csv-imu.md."""

import os

import pytest
import serial
from stream_rig import Swing, csv_rig, vn100_rig, vn100_settings

from rig.clock import SystemClock
from rig.errors import DeviceNonsense
from rig.link.ports import open_stream
from rig.twins.serving.ports import PtyPort
from rig.twins.vn100 import Vn100Twin
from rig.wire import vn100 as wire

# docs/devices/vn100.md: seen on a real unit (RW, log), and in a log.
ERRORS = {b"$VNERR,0C*02\r\n": "baud rate is too low", b"$VNERR,03*72\r\n": "invalid checksum"}


@pytest.mark.parametrize(("line", "text"), ERRORS.items())
def test_an_error_has_two_hexadecimal_digits(line: bytes, text: str) -> None:
    # "A parser of decimals reads 0C as 0 or fails, and 10 would be 16."
    assert text in (wire.parse_error(wire.parse_message(line)) or "")


def test_ten_in_hexadecimal_is_sixteen() -> None:
    assert wire.parse_error(["VNERR", "10"]) == "error 16"
    assert wire.parse_error(["VNERR", "0A"]) == "watchdog reset"


def test_the_twin_writes_two_digits() -> None:
    twin = Vn100Twin("imu", Swing())
    twin.receive(b"$VNASY,0*4F\r\n", 0.0)
    twin.transmit(0.0)
    twin.receive(wire.message(b"VNRRG,240"), 0.0)
    assert twin.transmit(0.0) == wire.message(b"VNERR,08")


def test_a_binary_output_that_was_left_on_is_switched_off_before_the_lines_begin() -> None:
    # docs/devices/vn100.md: "$VNWRG,75,1,4,01,0101*70"; a binary output mixes FAh frames into the text, and
    # "setting the ASCII type to 0 does not stop them".
    rig = vn100_rig()
    twin: Vn100Twin = rig.twin  # type: ignore[assignment]
    twin.receive(b"$VNWRG,75,1,4,01,0101*70\r\n", 0.0)
    assert twin.binary[75] == ["1", "4", "01", "0101"]
    rig.stream.discard_input()
    imu = rig.vn100()
    imu.start()
    assert twin.binary[75] == ["0", "4", "01", "0101"]
    rig.clock.sleep(1.0)
    block = imu.poll()
    assert block.refused == 0
    assert block.samples > 10
    assert wire.BINARY_OUTPUTS == (75, 76, 77)


def test_what_is_calibrated_is_the_uncompensated_output() -> None:
    # UM p. 79: register 54, header VNIMU, "Uncompensated"; p. 94: VNYMR is compensated.
    assert vn100_settings().output == "IMU"
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    rig.clock.sleep(1.0)
    assert imu.poll().values["imu.az"] == pytest.approx(-9.807, abs=0.001)
    assert rig.twin.registers[wire.OUTPUT] == 19  # type: ignore[attr-defined]


def test_register_54_is_answered_with_eleven_fields() -> None:
    # UM p. 79: `$VNRRG,54*72` → `$VNRRG,54,` and mag, accel, gyro, temperature, pressure.
    rig = vn100_rig()
    rig.stream.write(b"$VNASY,0*4F\r\n")
    rig.stream.discard_input()
    rig.stream.write(b"$VNRRG,54*72\r\n")
    found = wire.parse_message(rig.stream.discard_input())
    assert found[:2] == ["VNRRG", "54"]
    assert len(found) == 2 + 11


def test_a_users_compensation_is_recorded() -> None:
    # Register 25 acts on YMR; the record says so.
    rig = vn100_rig()
    assert rig.vn100().identify().split(", ")[3] == "no user compensation"
    rig.twin.setup[25] = (1.01, *wire.NO_COMPENSATION[1:])  # type: ignore[attr-defined]
    assert rig.vn100().identify().split(", ")[3] == "user compensation (register 25: 1.01 0 0 0 1 0 0 0 1 0 0 0)"


def test_a_terminal_that_nobody_reads_drops_the_stream() -> None:
    # docs/devices/csv-imu.md: "A UART that nobody reads drops bytes in the host's driver". Five minutes, then a client.
    port = PtyPort(Vn100Twin("imu", Swing()))
    now_s = 0.0
    for _ in range(3000):
        port.flush(now_s, 2.0)
        now_s += 0.1
    slave = os.open(port.address, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    waiting = b""
    try:
        for _ in range(200):
            try:
                waiting += os.read(slave, 65536)
            except BlockingIOError:
                break
            port.flush(now_s, 2.0)
    finally:
        os.close(slave)
        port.close()
    # Of 12 000 lines (1.6 MB) those of two seconds, and what a terminal of Linux holds: at most 64 KiB of buffers and
    # the 4 KiB of its line discipline. How much of that is full goes with the kernel's own worker.
    assert len(waiting) < 68 * 1024 + 80 * len(waiting.splitlines()[-2])


@pytest.mark.parametrize("lines", [5, 25, 49])
def test_a_board_may_tell_of_itself_before_it_sends(lines: int) -> None:
    # "10 to 25 lines, e.g. `rst:0x1 (POWERON_RESET)` … wait for lines of the right form": 5 were refused.
    rig = csv_rig()
    board = rig.csv()
    board.start()  # drops what waits; the board was reset by the opening and tells of itself only now
    rig.twin._due += b"\nrst:0x1 (POWERON_RESET)" * lines + b"\n"  # type: ignore[attr-defined]
    found = board.poll()
    assert (found.samples, found.refused) == (0, lines)
    rig.clock.sleep(1.0)
    block = board.poll()
    assert block.samples >= 99
    assert block.refused == 0


def test_a_board_that_only_tells_of_itself_is_told_after_the_limit() -> None:
    rig = csv_rig()
    board = rig.csv(columns=["n", "t", "ax", "ay", "az", "gz", "mx"], banner_lines=10)
    board.start()
    rig.clock.sleep(0.1)
    assert board.poll().samples == 0
    rig.clock.sleep(0.1)
    with pytest.raises(DeviceNonsense, match="none of its lines is a sample"):
        board.poll()


class Port:
    """What pyserial opens, as far as it is set before."""

    def __init__(self) -> None:
        self.dtr = self.rts = True
        self.at_opening: tuple[bool, bool] | None = None

    def open(self) -> None:
        self.at_opening = self.dtr, self.rts

    def close(self) -> None: ...


@pytest.mark.parametrize(("dtr_low", "rts_low"), [(False, False), (True, False), (True, True)])
def test_dtr_and_rts_are_low_before_the_port_opens(
    monkeypatch: pytest.MonkeyPatch, dtr_low: bool, rts_low: bool
) -> None:
    # PCM: "Using linux, the arduino will always reset."; ESP32 boards: "DTR and RTS together choose boot mode".
    port = Port()

    def serial_for_url(url: str, *, do_not_open: bool, **line: object) -> Port:
        assert do_not_open
        return port

    monkeypatch.setattr(serial, "serial_for_url", serial_for_url)
    open_stream("/dev/ttyACM0", clock=SystemClock(), dtr_low=dtr_low, rts_low=rts_low).close()
    assert port.at_opening == (not dtr_low, not rts_low)
