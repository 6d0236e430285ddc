"""The twin of a VN-100: registers, commands and one streamed output, by ASCII lines with checksum.

Source: VN-100 user manual UM001 (``*XX`` for any checksum, errors by VNERR); factory settings 115 200 baud, VNYMR at
40 Hz. The factory's filter (register 85) and reference vectors (21) are assumed, and do nothing here; the user's
compensation (23, 25, 84: C (x − b), p. 81) acts on every output but IMU, the rotation of the frame (26) on all. A reset
and a loss of power bring back what is in the flash (p. 54). Acceleration is what the unit's own axes feel: level it is
−g along z.
"""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from rig.errors import DeviceNonsense
from rig.twins.physics.imu import MotionSource
from rig.twins.physics.metronome import Metronome
from rig.wire import vn100 as wire

STANDARD_GRAVITY_MPS2 = 9.80665
RADPS_PER_DPS = 0.017453292519943295
GAUSS_PER_UT = 0.01
PRESSURE_KPA = 101.3
LONGEST_LINE = 256
IDENTITY: Mapping[int, str] = {wire.MODEL: "VN-100T-CR", 2: "7", wire.SERIAL: "100011981", wire.FIRMWARE: "2.1.0.0"}
FACTORY_SETUP: Mapping[int, tuple[float, ...]] = {
    **dict.fromkeys(wire.COMPENSATION, wire.NO_COMPENSATION),
    wire.REFERENCE_VECTORS: (1.0, 0.0, 1.8, 0.0, 0.0, -9.79375),
    wire.ROTATION: wire.NO_ROTATION,
    wire.HARD_SOFT_IRON: (0.0, 1.0, 5.0),
    wire.FILTERING: (0.0, 4.0, 4.0, 4.0, 0.0, 0.0, 3.0, 3.0, 3.0, 0.0),
}
NUMBERS = {number: name for name, (number, _) in wire.OUTPUTS.items()}
_MEMORY_COMMANDS = ("VNRST", "VNWNV", "VNRFS")
INVALID_CHECKSUM, INVALID_COMMAND, TOO_FEW, TOO_MANY, INVALID_PARAMETER, INVALID_REGISTER, UNAUTHORISED = range(3, 10)


BINARY_FRAME = bytes.fromhex("FA 01 01 00 00 00 20 41 1A 2B")
"""Sync byte, group, fields and some content."""


@dataclass
class Memory:
    """Registers: those in use, or those in the flash."""

    numbers: dict[int, int]
    setup: dict[int, tuple[float, ...]]
    binary: dict[int, list[str]]


def factory_memory() -> Memory:
    """Return what a unit is delivered with."""
    return Memory(
        {wire.BAUD_RATE: 115200, wire.OUTPUT: 14, wire.RATE: 40},
        dict(FACTORY_SETUP),
        {register: ["0", "1", "01", "0001"] for register in wire.BINARY_OUTPUTS},
    )


class Vn100Twin:
    """A :class:`rig.twins.twin.Twin`. It streams from the first moment on, as a unit does that was switched on."""

    def __init__(self, stream: str, source: MotionSource) -> None:
        self.flash = factory_memory()
        self._load()
        self._stream = stream
        self._source = source
        self._received = b""
        self._due = b""
        self._beat = Metronome()
        self._is_paused = False
        self._is_on = False

    def receive(self, data: bytes, now_s: float) -> None:
        self._emit(now_s)
        *lines, self._received = (self._received + data).split(b"\n")
        for line in lines:
            if line.strip():
                self._due += self._answer(line + b"\n", now_s)
        if len(self._received) > LONGEST_LINE:
            self._received = b""
            self._due += wire.message(b"VNERR,02")

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back, or be reset: the registers are those of the flash, and it streams."""
        self._load()
        self._is_paused = False
        self._restart(now_s)

    def _load(self) -> None:
        copied = deepcopy(self.flash)
        self.registers, self.setup, self.binary = copied.numbers, copied.setup, copied.binary

    def transmit(self, now_s: float) -> bytes:
        self._emit(now_s)
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return self._beat.next_s()

    def _emit(self, now_s: float) -> None:
        if not self._is_on:
            self._is_on = True
            self._restart(now_s)
        output = NUMBERS.get(self.registers[wire.OUTPUT])
        if output is not None:
            rows = (wire.format_row(output, self._fields(output, at_s)) for _, at_s in self._beat.due(now_s))
            self._due += b"".join(self._binary_frames() + row for row in rows)

    def _binary_frames(self) -> bytes:
        """Return what a binary output sends between two lines: a frame without a line end."""
        return b"".join(BINARY_FRAME for words in self.binary.values() if words[0] != "0")

    def _restart(self, now_s: float) -> None:
        if self._is_paused or self.registers[wire.OUTPUT] == wire.OFF:
            self._beat.stop()
        else:
            self._beat.start(now_s, self.registers[wire.RATE])

    def _fields(self, output: str, at_s: float) -> tuple[float, ...]:
        motion = self._source.motion(self._stream, at_s)
        sensed = (
            (("mx", "my", "mz"), 23, np.multiply(motion.field_ut, GAUSS_PER_UT)),
            (("ax", "ay", "az"), 25, np.multiply(motion.force_g, STANDARD_GRAVITY_MPS2)),
            (("gx", "gy", "gz"), 84, np.multiply(motion.rate_dps, RADPS_PER_DPS)),
        )
        fields = dict(zip(("yaw", "pitch", "roll"), motion.attitude_deg, strict=True))
        for names, register, vector in sensed:
            turned = np.reshape(self.setup.get(wire.ROTATION, wire.NO_ROTATION), (3, 3)) @ vector
            if output != "IMU":
                compensation = self.setup.get(register, wire.NO_COMPENSATION)
                turned = np.reshape(compensation[:9], (3, 3)) @ (turned - compensation[9:])
            fields |= dict(zip(names, turned.tolist(), strict=True))
        by_name = fields | {"t": motion.temperature_degc, "p": PRESSURE_KPA}
        return tuple(by_name[name] for name, _ in wire.OUTPUTS[output][1])

    def _answer(self, line: bytes, now_s: float) -> bytes:
        try:
            name, *words = wire.parse_message(line, accept_bypass=True)
        except DeviceNonsense:
            return _error(INVALID_CHECKSUM)
        if name in _MEMORY_COMMANDS and not words:
            return self._remember(name, now_s)
        if name not in ("VNRRG", "VNWRG", "VNASY"):
            return _error(INVALID_COMMAND)
        if name == "VNWRG" and words and words[0].isdecimal() and int(words[0]) in self.setup:
            return self._set_up(int(words[0]), words[1:])
        if words and words[0].isdecimal() and int(words[0]) in self.binary:
            register = int(words[0])
            if name == "VNWRG":
                self.binary[register] = words[1:]
            content = ",".join(self.binary[register]).encode("ascii")
            return wire.message(b"%s,%02d,%s" % (name.encode("ascii"), register, content))
        numbers = [int(word) for word in words if word.isdecimal()]
        if len(numbers) != len(words):
            return _error(INVALID_PARAMETER)
        if len(numbers) < (2 if name == "VNWRG" else 1):
            return _error(TOO_FEW)
        if name == "VNRRG":
            return self._read(numbers[0], now_s)
        if len(numbers) > (2 if name == "VNWRG" else 1):
            return _error(TOO_MANY)
        return self._pause(numbers[0], now_s) if name == "VNASY" else self._write(numbers[0], numbers[1], now_s)

    def _remember(self, name: str, now_s: float) -> bytes:
        """Write the registers into the flash, restore the factory's, or reset; it is answered before (p. 54)."""
        answer = wire.message(name.encode("ascii"))
        if name == "VNWNV":
            self.flash = deepcopy(Memory(self.registers, self.setup, self.binary))
            return answer
        if name == "VNRFS":
            self.flash = factory_memory()
        self.power_cycle(now_s)
        return answer

    def _set_up(self, register: int, words: list[str]) -> bytes:
        try:
            values = tuple(map(float, words))
        except ValueError:
            return _error(INVALID_PARAMETER)
        if len(values) != len(self.setup[register]):
            return _error(TOO_FEW if len(values) < len(self.setup[register]) else TOO_MANY)
        self.setup[register] = values
        return wire.message(b"VNWRG,%02d,%s" % (register, b",".join(b"%.9g" % value for value in values)))

    def _read(self, register: int, now_s: float) -> bytes:
        if register in self.setup:
            values = b",".join(b"%.9g" % value for value in self.setup[register])
            return wire.message(b"VNRRG,%02d,%s" % (register, values))
        if register == wire.IMU_REGISTER:
            row = wire.format_row("IMU", self._fields("IMU", now_s))
            return wire.message(b"VNRRG,%02d%s" % (register, row[len(b"$VNIMU") : row.index(b"*")]))
        found = IDENTITY.get(register) or self.registers.get(register)
        return (
            _error(INVALID_REGISTER)
            if found is None
            else wire.message(b"VNRRG,%02d,%s" % (register, str(found).encode("ascii")))
        )

    def _write(self, register: int, value: int, now_s: float) -> bytes:
        if register in IDENTITY:
            return _error(UNAUTHORISED)
        if register not in self.registers:
            return _error(INVALID_REGISTER)
        allowed = {
            wire.BAUD_RATE: wire.BAUD_RATES,
            wire.OUTPUT: (wire.OFF, *NUMBERS),
            wire.RATE: wire.RATES_HZ,
        }
        if value not in allowed[register]:
            return _error(INVALID_PARAMETER)
        self.registers[register] = value
        self._restart(now_s)
        return wire.message(b"VNWRG,%02d,%d" % (register, value))

    def _pause(self, resumes: int, now_s: float) -> bytes:
        if resumes not in (0, 1):
            return _error(INVALID_PARAMETER)
        self._is_paused = resumes == 0
        self._restart(now_s)
        return wire.message(b"VNASY,%d" % resumes)


def _error(code: int) -> bytes:
    return wire.message(b"VNERR,%02X" % code)
