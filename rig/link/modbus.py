"""Modbus RTU over any byte stream: frames and checksums by pymodbus, the conversation by ourselves.

RTU has no transaction number. pymodbus' own client takes a reply that comes after its time-out for the answer to the
next question and says nothing (seen with 3.16.1). So here a reply must have exactly the length, unit, function and
echo that its question asks for; after any doubt the line must fall silent, and then a register whose value is known
(the sentinel) must answer before the next question is asked. One case remains that RTU cannot tell: a reply that was
doubled on the line and arrives the second time just when the next question's own reply is lost.

Only the Modbus links and the twins import pymodbus.
"""

import logging
from collections.abc import Callable, Sequence
from typing import TypeVar

from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    WriteMultipleRegistersRequest,
    WriteSingleRegisterRequest,
)

from rig.errors import DeviceNonsense, DeviceSilent, LineNotQuiet
from rig.link.byte_stream import ByteStream
from rig.link.counts import counts_of
from rig.link.exchange import LONGEST_REPLY, Patience, not_quiet
from rig.link.modbus_replies import granted, in_words
from rig.link.symptoms import remedy

_Answer = TypeVar("_Answer")

_READ = 3
_EXCEPTION_LENGTH = 5
_WRITE_LENGTH = 8


class ModbusRtu:
    """The master of one slave. Values are raw registers, 0 to 65535."""

    def __init__(
        self,
        stream: ByteStream,
        unit: int,
        *,
        baud_rate: int = 9600,
        patience: Patience | None = None,
        gap_s: float | None = None,
    ) -> None:
        """Take the line.

        ``gap_s``: silence before each question, None for the 3.5 characters of the rule.
        """
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it logs whole frames as errors
        self.stream = stream
        self.counts = counts_of(stream, f"unit {unit}")
        self._unit = unit
        self._patience = patience or Patience()
        self._framer = FramerRTU(DecodePDU(False))
        self._gap_s = max(3.5 * 11.0 / baud_rate, 0.00175) if gap_s is None else gap_s
        self._sentinel: tuple[int, int] | None = None
        self._is_in_doubt = True

    def set_sentinel(self, address: int, value: int) -> None:
        """Name a register whose value never changes.

        After a doubt it must answer so before anything else is believed.
        """
        self._sentinel = (address, value)

    def read_holding(self, address: int, count: int = 1) -> tuple[int, ...]:
        """Read ``count`` holding registers from ``address`` (function 3).

        Raises: DeviceSilent, DeviceNonsense, DeviceRefused, DeviceFault, LinkLost.
        """
        return self._repeated(lambda: self._read(address, count))

    def write_register(self, address: int, value: int) -> None:
        """Write one register (function 6), whose echo must repeat address and value.

        Raises as :meth:`read_holding`.
        """
        self._repeated(lambda: self._write(address, value))

    def write_registers(self, address: int, values: Sequence[int], *, idempotent: bool = True) -> None:
        """Write registers from ``address`` on (function 16), acknowledged.

        Where that starts something (``idempotent`` false), it is sent once only. Raises as :meth:`read_holding`.
        """
        attempts = self._patience.attempts if idempotent else 1
        self._repeated(lambda: self._write_many(address, list(values)), attempts)

    def write_in_doubt(self, *frames: bytes) -> None:
        """Write the frames of a stop on a line in doubt before it is quiet; nothing where they go at once.

        Raises: LinkLost, LinkClosed.
        """
        if self._is_in_doubt:
            for frame in frames:
                self.stream.write(frame)
                self.stream.clock.sleep(self._gap_s)

    def write_frame(self, address: int, values: Sequence[int]) -> bytes:
        """Return the frame that :meth:`write_registers` would send."""
        return self._framer.buildFrame(
            WriteMultipleRegistersRequest(dev_id=self._unit, address=address, registers=list(values))
        )

    def _read(self, address: int, count: int) -> tuple[int, ...]:
        request = ReadHoldingRegistersRequest(dev_id=self._unit, address=address, count=count)
        return tuple(self._transact(request).registers)

    def _write(self, address: int, value: int) -> None:
        request = WriteSingleRegisterRequest(dev_id=self._unit, address=address, registers=[value])
        reply = self._transact(request)
        if (reply.address, *reply.registers) != (address, value):
            values = " and ".join(map(str, reply.registers)) or "none"
            raise self._nonsense(request, f"the echo names register {reply.address}, value {values}")

    def _write_many(self, address: int, values: list[int]) -> None:
        request = WriteMultipleRegistersRequest(dev_id=self._unit, address=address, registers=values)
        reply = self._transact(request)
        if (reply.address, reply.count) != (address, len(values)):
            raise self._nonsense(request, f"it acknowledges register {reply.address}, {reply.count} of them")

    def _repeated(self, question: Callable[[], _Answer], attempts: int | None = None) -> _Answer:
        """Ask again after silence or nonsense: registers may be read twice, and absolute values written twice."""
        attempts = attempts or self._patience.attempts
        for attempt in range(1, attempts + 1):
            try:
                self._clear_the_line()
                return question()
            except (DeviceSilent, DeviceNonsense) as error:
                self._is_in_doubt = True
                self.counts.silent += isinstance(error, DeviceSilent)
                self.counts.nonsense += isinstance(error, DeviceNonsense)
                if attempt == attempts or isinstance(error, LineNotQuiet):
                    raise
                self.counts.repeated += 1
        raise AssertionError("a question is asked at least once")

    def _clear_the_line(self) -> None:
        """Clear the line: bytes that wait before a question are nobody's answer and put it in doubt."""
        waiting = self.stream.discard_input()
        self.counts.stale_bytes += len(waiting)
        if not (waiting or self._is_in_doubt):
            return
        self._wait_for_quiet()
        if self._sentinel is not None:
            self._ask_the_sentinel(*self._sentinel)
        self._is_in_doubt = False

    def _ask_the_sentinel(self, address: int, value: int) -> None:
        (answered,) = self._read(address, 1)
        if answered != value:
            raise DeviceNonsense(
                f"{self.stream.name}: register {address} is {value} and cannot be {answered}: replies are shifted or"
                " another device answers; nothing was taken from it; check the line and its other masters"
            )
        # That may have been the late answer to an earlier sentinel: then this one's own is still on its way.
        if self._wait_for_quiet():
            raise DeviceNonsense(
                f"{self.stream.name}: more replies than questions: they come late; nothing was taken from them;"
                " check the load and the length of the line"
            )

    def _wait_for_quiet(self) -> int:
        """Take what still arrives until the line has been silent for a while; how many bytes that was."""
        clock = self.stream.clock
        limit_s = clock.monotonic_s() + self._patience.quiet_limit_s
        taken = 0
        while stale := self.stream.read(clock.monotonic_s() + self._patience.quiet_s):
            taken += len(stale)
            self.counts.stale_bytes += len(stale)
            if clock.monotonic_s() >= limit_s or taken > LONGEST_REPLY:
                raise not_quiet(self.stream, self._patience, taken, stale)
        return taken

    def _transact(self, request: ModbusPDU) -> ModbusPDU:
        """Ask one question and take its whole reply; a busy slave is asked again for a while."""
        return granted(lambda question: self._decode(question, self._exchange(question)), request, self.stream)

    def _exchange(self, request: ModbusPDU) -> bytes:
        clock = self.stream.clock
        self.counts.questions += 1
        clock.sleep(self._gap_s)
        question = self._framer.buildFrame(request)
        self.stream.write(question)
        deadline_s = clock.monotonic_s() + self._patience.timeout_s
        frame = b""
        while len(frame) < (_EXCEPTION_LENGTH if len(frame) > 1 and frame[1] & 0x80 else _reply_length(request)):
            more = self.stream.read(deadline_s)
            if not more:
                raise DeviceSilent(
                    f"{self.stream.name}: no whole reply to {in_words(request)}: got {frame.hex(' ') or 'nothing'}"
                    f" within {self._patience.timeout_s:g} s; nothing was taken from it;"
                    f" {remedy(question, frame, 'check power, unit number, baud rate, parity and line')}"
                )
            frame += more
        return frame

    def _decode(self, request: ModbusPDU, frame: bytes) -> ModbusPDU:
        is_exception = frame[1] == request.function_code | 0x80
        wrong = [
            (frame[0] != self._unit, f"unit {frame[0]} answered"),
            (frame[1] & 0x7F != request.function_code, f"function {frame[1]} answered"),
            (is_exception and len(frame) != _EXCEPTION_LENGTH, "more bytes than one reply"),
            (not is_exception and len(frame) != _reply_length(request), "more bytes than one reply"),
            (frame[1] == _READ and frame[2] != 2 * request.count, f"it holds {frame[2]} bytes"),
            (self._framer.compute_CRC(frame[:-2]).to_bytes(2, "big") != frame[-2:], "the checksum is wrong"),
        ]
        reasons = [reason for is_wrong, reason in wrong if is_wrong]
        reply = None if reasons else self._framer.decoder.decode(frame[1:-2])
        if reply is None:
            raise self._nonsense(request, f"got {frame.hex(' ')}: {(reasons or ['not decodable'])[0]}", frame)
        return reply

    def _nonsense(self, request: ModbusPDU, why: str, frame: bytes = b"?") -> DeviceNonsense:
        look = "check baud rate, parity, the unit number and other masters on this line"
        return DeviceNonsense(
            f"{self.stream.name}: no answer to {in_words(request)}: {why}; nothing was taken from it;"
            f" {remedy(self._framer.buildFrame(request), frame, look)}"
        )


def _reply_length(request: ModbusPDU) -> int:
    return 5 + 2 * request.count if request.function_code == _READ else _WRITE_LENGTH
