"""Debian's mbpoll, a program in C over libmodbus, reads and writes the Modbus twins: RTU on a pty, TCP on a port."""

import re
import subprocess
from collections.abc import Callable

import pytest
from motion_bench import motion_bench
from programs import require_program

from rig.clock import ScaledClock, SystemClock
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.oriental_az import OrientalAzTwin
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp
from rig.twins.twin import Twin
from rig.twins.watlow_f4 import WatlowF4Twin
from rig.twins.watlow_f4t import WatlowF4TTwin


class Room:
    """What the chambers' twins ask of the world."""

    def __init__(self) -> None:
        self.held_degc: list[float] = []

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 25.3

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.held_degc.append(setpoint_degc)

    def setpoint_degc(self, environment: str) -> float:
        return 20.0


def _mbpoll(server: TwinServer, *arguments: str) -> str:
    """What it prints; registers are counted from 0, once."""
    program = require_program("mbpoll")
    if server.address.startswith("socket://"):
        host, port = server.address.removeprefix("socket://").split(":")
        line = ["-m", "tcp", "-p", port, host]
    else:
        line = ["-m", "rtu", "-b", "9600", "-P", "none", server.address]
    ran = subprocess.run(
        [program, "-0", "-1", "-o", "3", *line, *arguments], capture_output=True, text=True, timeout=30.0
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


def _values(printed: str) -> dict[int, float]:
    return {
        int(location): float(value)
        for location, value in re.findall(r"^\[(\d+)\]:\s+(-?[\d.]+)", printed, re.MULTILINE)
    }


def test_it_reads_and_writes_a_watlow_f4() -> None:
    room = Room()
    with serve_pty(WatlowF4Twin("air", room), SystemClock()) as server:
        assert _values(_mbpoll(server, "-r", "100")) == {100: 253.0}
        assert _values(_mbpoll(server, "-r", "606")) == {606: 1.0}
        assert "Written 1 references" in _mbpoll(server, "-r", "300", "65331")  # FF33 is −205
    assert room.held_degc == [-20.5]


@pytest.mark.parametrize("framing", ["tcp", "rtu"])
def test_it_reads_and_writes_a_watlow_f4t(framing: str) -> None:
    serve: Callable[[Twin, SystemClock], TwinServer] = serve_tcp if framing == "tcp" else serve_pty
    room = Room()
    twin = ModbusSlave(WatlowF4TTwin("air", room), framing=framing)  # type: ignore[arg-type]
    with serve(twin, SystemClock()) as server:
        assert _values(_mbpoll(server, "-t", "4:float", "-r", "2820")) == {2820: pytest.approx(25.3)}
        assert "Written 1 references" in _mbpoll(server, "-t", "4:float", "-r", "2782", "--", "-40.25")
    assert room.held_degc == [-40.25]


def test_it_drives_an_oriental_az() -> None:
    """Direct data operation: absolute, 4500 steps, 3 kHz, trigger all; then the feedback position."""
    clock = ScaledClock(100.0)
    twin: OrientalAzTwin = motion_bench("oriental-az").twin
    for unit in twin.units.values():
        unit.servo.home(clock.monotonic_s())
    operation = ["0", "0", "0", "1", "0", "4500", "0", "3000", "0", "3000", "0", "3000", "0", "1000", "0", "1"]
    with serve_pty(twin, clock) as server:
        assert "Written 16 references" in _mbpoll(server, "-r", "88", "--", *operation)
        while int(_values(_mbpoll(server, "-r", "127"))[127]) & 1 << 13:
            clock.sleep(10.0)
        assert _values(_mbpoll(server, "-B", "-t", "4:int", "-r", "204")) == {204: 4500.0}
