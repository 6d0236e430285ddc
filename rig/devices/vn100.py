"""VectorNav VN-100 by its ASCII protocol: one of its outputs, streamed at one of its rates.

Commands are answered by lines that repeat command and register, so an answer is found among streamed lines and a
late one does no harm. A streamed line carries neither count nor time: a line that fails its checksum is a gap of
unknown length, and bytes that were lost whole show only in the number of samples.

The default output is IMU, "uncompensated": the factory's calibration is in it and cannot be taken out, the user's
compensation and the filter's bias estimate are not; a rotation of the frame (register 26) and a filter (85) are. YMR
is compensated by registers 23, 25, 44 and 84. The identity names what any of them does, with its content; a unit that
is reset in mid-run has what is in its flash, and streams on: they are asked before and behind every recording.

Source: VN-100 user manual UM001; see :mod:`rig.wire.vn100`. The baud rate as delivered (115 200) is a setting.
"""

from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from rig.abilities.abilities import StreamBlock
from rig.abilities.stream_reader import RowReader, refusal_gaps
from rig.clock import Clock
from rig.description.device_settings import StreamSettings
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent
from rig.link.byte_stream import ByteStream
from rig.link.exchange import shown
from rig.link.symptoms import remedy
from rig.wire import vn100 as wire
from rig.wire.stream_lines import LONGEST_LINE, Rows

TIMEOUT_S = 1.0
ATTEMPTS = 3
BITS_PER_BYTE = 10
"""8N1."""
_VOID = "what was recorded is void"
_ABSENT = "nothing"


class Vn100Settings(StreamSettings):
    """``driver = "vn100"``."""

    driver: Literal["vn100"]
    baud_rate: Annotated[int, Field()] = 115200
    output: Literal["YPR", "MAG", "ACC", "GYR", "MAR", "YMR", "IMU"] = "IMU"
    """What is calibrated must not carry a compensation: of these IMU alone, with MAG to YMR by the unit's registers."""
    rate_hz: Annotated[int, Field()] = 40

    @field_validator("rate_hz")
    @classmethod
    def _is_offered(cls, rate_hz: int) -> int:
        if rate_hz not in wire.RATES_HZ:
            raise ValueError(f"the unit has no rate of {rate_hz} Hz (allowed: {_listed(wire.RATES_HZ)} Hz)")
        return rate_hz

    @field_validator("baud_rate")
    @classmethod
    def _is_a_baud_rate(cls, baud_rate: int) -> int:
        if baud_rate not in wire.BAUD_RATES:
            raise ValueError(f"the unit has no such baud rate, got {baud_rate} (allowed: {_listed(wire.BAUD_RATES)})")
        return baud_rate

    @model_validator(mode="after")
    def _fits_the_line(self) -> "Vn100Settings":
        needed = wire.line_bytes(self.output) * BITS_PER_BYTE * self.rate_hz
        if needed > self.baud_rate:
            raise ValueError(
                f"output {self.output} at {self.rate_hz} Hz needs {needed} baud, baud_rate is {self.baud_rate};"
                " raise the unit's baud rate or lower rate_hz"
            )
        return self

    def channel_names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in wire.OUTPUTS[self.output][1])

    def channel_units(self) -> dict[str, str]:
        return dict(wire.OUTPUTS[self.output][1])

    def samples_hz(self) -> float:
        return float(self.rate_hz)


class _NoSuchRegister(DeviceRefused):
    """The firmware has no such register; any other refusal says nothing of a register."""


class Vn100:
    """A :class:`rig.abilities.abilities.Stream`. ``clock`` is the rig's; the line has its own for time-outs."""

    def __init__(self, name: str, settings: Vn100Settings, stream: ByteStream, clock: Clock) -> None:
        self.name = name
        self.rate_hz = float(settings.rate_hz)
        fields = wire.OUTPUTS[settings.output][1]
        self.channels = tuple(f"{name}.{field}" for field, _ in fields)
        self.units: Mapping[str, str] = {f"{name}.{field}": unit for field, unit in fields}
        self._settings = settings
        self._stream = stream
        self._clock = clock
        self._pattern = wire.row_pattern(settings.output)
        self._reader = RowReader(stream, name, self._parse)
        self._received = b""
        """Behind the last answer: the beginning of the stream."""
        self._setup: Mapping[int, str] | None = None
        """What the registers held when they were first asked."""

    def identify(self) -> str:
        """Return model, serial number, firmware and what is set that changes measurements; streaming pauses."""
        self._command(wire.PAUSE)
        model, serial, firmware = (self._read(number) for number in (wire.MODEL, wire.SERIAL, wire.FIRMWARE))
        self._setup = self._read_setup()
        try:
            words = wire.setup_words(self._setup)
        except DeviceNonsense as error:
            raise DeviceNonsense(f"{self.name}: {error}") from error
        return ", ".join((f"VectorNav {model}", f"serial {serial}", f"firmware {firmware}", *words))

    def start(self) -> None:
        self._command(wire.PAUSE)
        self._silence_binary_outputs()
        number, _ = wire.OUTPUTS[self._settings.output]
        self._write(wire.OUTPUT, number)
        self._write(wire.RATE, self._settings.rate_hz)
        self._require_setup("nothing was recorded")
        self._command(wire.RESUME)
        self._reader.begin(self._received)

    def poll(self) -> StreamBlock:
        first = self._reader.rows
        rows = self._reader.take()
        for refusal in rows.refused:
            if refusal.line.startswith(b"$VNERR"):
                raise DeviceFault(
                    f"{self.name}: the unit reports: {_trouble(refusal.line)}; the stream is not to be trusted;"
                    " start it again"
                )
        return StreamBlock(
            stream=self.name,
            first=first,
            values=dict(zip(self.channels, rows.values.T, strict=True)),
            device_s=np.full(len(rows.values), np.nan),
            polled_s=self._clock.monotonic_s(),
            gaps=refusal_gaps(rows.refused),
            refused=len(rows.refused),
        )

    def stop(self) -> None:
        """As of every stream. Raises also: DeviceFault where what was recorded means something else than before."""
        self._command(wire.PAUSE)
        number, _ = wire.OUTPUTS[self._settings.output]
        for register, need in ((wire.OUTPUT, number), (wire.RATE, self._settings.rate_hz)):
            found = self._read(register).partition(",")[0]
            if found != str(need):
                raise self._changed(register, found, str(need), _VOID)
        self._require_setup(_VOID)

    def _read_setup(self) -> Mapping[int, str]:
        return {number: reply for number in wire.SETUP if (reply := self._read_if_there(number)) is not None}

    def _require_setup(self, so_far: str) -> None:
        """Compare what changes measurements with what it was when it was first asked. Raises: DeviceFault."""
        found = self._read_setup()
        held = self._setup = found if self._setup is None else self._setup
        for register in wire.SETUP:
            if found.get(register) != held.get(register):
                raise self._changed(register, found.get(register, _ABSENT), held.get(register, _ABSENT), so_far)

    def _changed(self, register: int, found: str, held: str, so_far: str) -> DeviceFault:
        return DeviceFault(
            f"{self.name}: register {register} holds {found}, it held {held} before: the unit was reset, or another"
            f" program wrote to it; {so_far}; see what happened to its power and who has its port, bring the registers"
            " back (and save them in the unit), then resume"
        )

    def _parse(self, piece: bytes) -> Rows:
        return wire.parse_rows(piece, self._settings.output, self._pattern)

    def _read(self, register: int) -> str:
        return ",".join(self._command(b"VNRRG,%d" % register)[2:])

    def _read_if_there(self, register: int) -> str | None:
        """Return a register's fields, None where the firmware has no such register. Raises: DeviceRefused otherwise."""
        try:
            return self._read(register)
        except _NoSuchRegister:
            return None

    def _silence_binary_outputs(self) -> None:
        """Switch off what would send frames between the lines: the type of the text output does not stop them.

        It is back when the unit is switched on again. Raises: DeviceRefused.
        """
        for register in wire.BINARY_OUTPUTS:
            try:
                ports, *rest = self._command(b"VNRRG,%d" % register)[2:] or ["0"]
            except _NoSuchRegister:
                continue  # a firmware without this register has no such output
            if ports == "0":
                continue
            words = ",".join(["0", *rest]).encode("ascii")
            reply = self._command(b"VNWRG,%d,%s" % (register, words))[2:]
            if reply[:1] != ["0"]:
                raise DeviceRefused(
                    f"{self.name}: register {register}: a binary output stays on ({','.join(reply) or 'nothing'});"
                    " it does not stream; switch it off with the maker's program"
                )

    def _write(self, register: int, value: int) -> None:
        reply = self._command(b"VNWRG,%d,%d" % (register, value))[2:]
        if not reply or reply[0] != str(value):
            raise DeviceRefused(
                f"{self.name}: register {register}: the unit tells {','.join(reply) or 'nothing'}, it was set to"
                f" {value}; it does not stream; check that its firmware offers this output and rate"
            )

    def _command(self, payload: bytes) -> list[str]:
        """Send and find the answer; all commands here may be sent twice.

        Raises: DeviceSilent, DeviceRefused, LinkLost.
        """
        for attempt in range(1, ATTEMPTS + 1):
            self._stream.discard_input()
            self._stream.write(wire.message(payload))
            try:
                return self._answer(payload)
            except DeviceSilent:
                if attempt == ATTEMPTS:
                    raise
        raise AssertionError("a command is sent at least once")

    def _answer(self, payload: bytes) -> list[str]:
        """Return the line that repeats command and register; streamed lines and damaged ones are passed over."""
        deadline_s = self._stream.clock.monotonic_s() + TIMEOUT_S
        received = heard = b""
        while more := self._stream.read(deadline_s):
            received += more
            heard = received
            *lines, received = received.split(b"\n")
            received = received[-LONGEST_LINE:]
            for index, line in enumerate(lines):
                parts = self._parts(line + b"\n")
                if parts and _is_answer(parts, payload.decode("ascii").split(",")):
                    self._received = b"\n".join([*lines[index + 1 :], received])
                    return parts
            if self._stream.clock.monotonic_s() >= deadline_s:
                break
        raise DeviceSilent(
            f"{self.name}: {self._stream.name}: no answer to {shown(payload)} within {TIMEOUT_S:g} s, the last bytes"
            f" were {shown(heard)}; nothing was set; {self._remedy(payload, heard)}"
        )

    def _remedy(self, payload: bytes, heard: bytes) -> str:
        """Return what to look at, from what came instead of an answer."""
        baud_rate = f"baud_rate ({self._settings.baud_rate})"
        if not heard:
            return f"check power, cable and {baud_rate}, and that no two cables changed places"
        if wire.HEAD in heard:
            return f"a VectorNav sends, and does not hear: check the wire to it, and {baud_rate}"
        foreign = f"no VectorNav sends this: check that no two cables changed places, and {baud_rate}"
        return remedy(wire.message(payload), heard, foreign)

    def _parts(self, line: bytes) -> list[str]:
        try:
            parts = wire.parse_message(line)
        except DeviceNonsense:
            return []
        trouble = wire.parse_error(parts)
        if trouble is not None:
            kind = _NoSuchRegister if trouble == wire.ERRORS[wire.NO_SUCH_REGISTER] else DeviceRefused
            raise kind(f"{self.name}: the unit refuses: {trouble}; it is as it was; check its firmware")
        return parts


def _is_answer(parts: list[str], question: list[str]) -> bool:
    """Return whether command and register are the same: ``VNRRG,01`` answers ``VNRRG,1``."""
    return parts[0] == question[0] and len(parts) > 1 and parts[1].isdecimal() and int(parts[1]) == int(question[1])


def _trouble(line: bytes) -> str:
    try:
        return wire.parse_error(wire.parse_message(line)) or "nothing"
    except DeviceNonsense as error:
        return f"a damaged error message ({error})"


def _listed(numbers: tuple[int, ...]) -> str:
    return ", ".join(map(str, numbers))


def connect(name: str, settings: Vn100Settings, stream: ByteStream, clock: Clock) -> Vn100:
    """Return the unit behind a stream."""
    return Vn100(name, settings, stream, clock)
