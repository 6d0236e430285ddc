"""Modbus TCP over any byte stream: frames by pymodbus, the conversation by ourselves.

TCP has what RTU lacks, a transaction number: a reply that carries another one belongs to a question that was given
up, and is passed over while the right one is waited for. Unit and function must match as well, and the length that
the header names must be the one that the question asks for. A connection on which a header is none is given up.
"""

import logging
from collections.abc import Callable, Sequence
from typing import TypeVar

from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest, WriteMultipleRegistersRequest

from rig.errors import DeviceNonsense, DeviceSilent, LinkLost
from rig.link.byte_stream import ByteStream
from rig.link.counts import counts_of
from rig.link.exchange import Patience
from rig.link.modbus_replies import granted, in_words

_Answer = TypeVar("_Answer")

_HEADER = 6
"""Transaction, protocol and length: two bytes each; the length counts what follows."""
_LENGTHS = range(3, 255)
_TRANSACTIONS = 65536


class ModbusTcp:
    """The client of one unit. Values are raw registers, 0 to 65535."""

    def __init__(self, stream: ByteStream, unit: int, *, patience: Patience | None = None) -> None:
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it logs whole frames as errors
        self.stream = stream
        self.counts = counts_of(stream, f"unit {unit}")
        self._unit = unit
        self._patience = patience or Patience()
        self._framer = FramerSocket(DecodePDU(False))
        self._transaction = 0
        self._received = b""
        self._misframed = ""

    def read_holding(self, address: int, count: int = 1) -> tuple[int, ...]:
        """Read ``count`` holding registers from ``address`` (function 3).

        Raises: DeviceSilent, DeviceNonsense, DeviceRefused, DeviceFault, LinkLost.
        """
        return self._repeated(lambda: self._read(address, count))

    def write_registers(self, address: int, values: Sequence[int]) -> None:
        """Write registers from ``address`` on (function 16), acknowledged.

        Raises as :meth:`read_holding`.
        """
        self._repeated(lambda: self._write(address, list(values)))

    def _read(self, address: int, count: int) -> tuple[int, ...]:
        request = ReadHoldingRegistersRequest(dev_id=self._unit, address=address, count=count)
        registers = tuple(granted(self._exchange, request, self.stream).registers)
        if len(registers) != count:
            raise self._nonsense(request, f"it holds {len(registers)} registers, asked for {count}")
        return registers

    def _write(self, address: int, values: list[int]) -> None:
        request = WriteMultipleRegistersRequest(dev_id=self._unit, address=address, registers=values)
        reply = granted(self._exchange, request, self.stream)
        if (reply.address, reply.count) != (address, len(values)):
            raise self._nonsense(request, f"it acknowledges register {reply.address}, {reply.count} of them")

    def _repeated(self, question: Callable[[], _Answer]) -> _Answer:
        """Ask again after silence or nonsense: registers may be read twice, and absolute values written twice."""
        for attempt in range(1, self._patience.attempts + 1):
            try:
                return question()
            except (DeviceSilent, DeviceNonsense) as error:
                self.counts.silent += isinstance(error, DeviceSilent)
                self.counts.nonsense += isinstance(error, DeviceNonsense)
                if attempt == self._patience.attempts:
                    raise
                self.counts.repeated += 1
        raise AssertionError("a question is asked at least once")

    def _exchange(self, request: ModbusPDU) -> ModbusPDU:
        """Ask one question and take the reply with its number."""
        if self._misframed:
            raise self._without_frames(request)
        self.counts.questions += 1
        self._transaction = (self._transaction + 1) % _TRANSACTIONS
        request.transaction_id = self._transaction
        self.stream.write(self._framer.buildFrame(request))
        deadline_s = self.stream.clock.monotonic_s() + self._patience.timeout_s
        while True:
            frame = self._next_frame(request, deadline_s)
            if int.from_bytes(frame[:2], "big") == self._transaction:
                return self._decode(request, frame)
            self.counts.stale_bytes += len(frame)

    def _next_frame(self, request: ModbusPDU, deadline_s: float) -> bytes:
        while (length := self._frame_length(request)) is None or len(self._received) < length:
            more = self.stream.read(deadline_s)
            if not more:
                raise DeviceSilent(
                    f"{self.stream.name}: no whole reply to {in_words(request)} within {self._patience.timeout_s:g} s:"
                    f" got {self._received.hex(' ') or 'nothing'}; nothing was taken from it; check power, address"
                    " and unit"
                )
            self._received += more
        frame, self._received = self._received[:length], self._received[length:]
        return frame

    def _frame_length(self, request: ModbusPDU) -> int | None:
        """Return the length of the frame that is arriving; None while its header is not whole."""
        if len(self._received) < _HEADER:
            return None
        protocol, following = (int.from_bytes(self._received[start : start + 2], "big") for start in (2, 4))
        if protocol or following not in _LENGTHS:
            raise self._lost(request)
        return _HEADER + following

    def _lost(self, request: ModbusPDU) -> LinkLost:
        """Give the connection up: TCP loses no bytes, so one without frames stays wrong, however quiet it becomes.

        Waiting for silence is not enough: the rest of a frame that was dropped may arrive behind the next header.
        """
        self._misframed = self._received[:_HEADER].hex(" ")
        self.counts.stale_bytes += len(self._received)
        self._received = b""
        return self._without_frames(request)

    def _without_frames(self, request: ModbusPDU) -> LinkLost:
        return LinkLost(
            f"{self.stream.name}: no answer to {in_words(request)}: {self._misframed} is no Modbus TCP header; nothing"
            " was taken from it; the connection must be opened again; check that this is a Modbus TCP device or gateway"
        )

    def _decode(self, request: ModbusPDU, frame: bytes) -> ModbusPDU:
        unit, function = frame[6], frame[7]
        if unit != self._unit or function & 0x7F != request.function_code:
            raise self._nonsense(request, f"unit {unit}, function {function & 0x7F} answered")
        is_exception, is_read = function & 0x80, function == 3
        wanted = 9 if is_exception else 9 + 2 * request.count if is_read else 12
        if len(frame) != wanted or (is_read and frame[8] != 2 * request.count):
            raise self._nonsense(request, f"got {frame.hex(' ')}, need {wanted} bytes")
        reply = self._framer.decoder.decode(frame[7:])
        if reply is None:
            raise self._nonsense(request, f"got {frame.hex(' ')}: not decodable")
        return reply

    def _nonsense(self, request: ModbusPDU, why: str) -> DeviceNonsense:
        return DeviceNonsense(
            f"{self.stream.name}: no answer to {in_words(request)}: {why}; nothing was taken from it;"
            " check the address, the unit number and that this is a Modbus TCP device"
        )
