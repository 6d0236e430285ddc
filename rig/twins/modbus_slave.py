"""The outside of a Modbus device's twin: frames in, frames out, by RTU or TCP. What registers mean stands behind it.

It answers functions 3, 6 and 16; what it does not know it refuses by exception, and a frame for another unit or with
a wrong checksum it does not answer at all, as on the line.
"""

import logging
from collections.abc import Sequence
from typing import Literal, Protocol

from pymodbus.framer import FramerRTU, FramerSocket
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadHoldingRegistersResponse,
    WriteMultipleRegistersRequest,
    WriteMultipleRegistersResponse,
    WriteSingleRegisterRequest,
    WriteSingleRegisterResponse,
)

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
_LONGEST_FRAME = 260
_MBAP = 8


class Registers(Protocol):
    """The device behind the frames. Values are raw, 0 to 65535."""

    def read(self, address: int, count: int, now_s: float) -> Sequence[int] | None:
        """Return ``count`` registers as they are at one instant; None where one of them does not exist."""

    def write(self, address: int, values: Sequence[int], now_s: float) -> int:
        """Write the values; return the code of the exception to answer with, 0 when written."""


class ModbusSlave:
    """A :class:`rig.twins.twin.Twin` that answers for ``registers`` as ``unit``."""

    def __init__(
        self, registers: Registers, *, unit: int = 1, framing: Literal["rtu", "tcp"] = "rtu", gap_s: float = 1.0
    ) -> None:
        """Take the registers.

        ``gap_s``: silence after which an unfinished frame is forgotten; long, since no line is this irregular.
        """
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it logs whole frames as errors
        self._registers = registers
        self.refusals: dict[int, int] = {}
        """Registers whose reading is answered by an exception, such as 6 (busy), and by which."""
        self._unit = unit
        self._framing = framing
        self._gap_s = gap_s
        self._framer = (FramerRTU if framing == "rtu" else FramerSocket)(DecodePDU(True))
        self._received = b""
        self._last_s = float("-inf")
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        if now_s - self._last_s > self._gap_s:
            self._received = b""
        self._last_s = now_s
        self._received += data
        while request := self._next_request():
            unit, transaction, pdu = request
            if unit == self._unit:
                self._answer(transaction, pdu, now_s)
        self._received = self._received[-_LONGEST_FRAME:]

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def _next_request(self) -> tuple[int, int, bytes] | None:
        """Return unit, transaction number and request of the next whole frame."""
        if self._framing == "tcp" and _is_no_header(self._received):
            self._received = b""  # a server closes such a connection
        used, unit, transaction, request = self._framer.decode(self._received)
        self._received = self._received[used:]
        return (unit, transaction, request) if request else None

    def _answer(self, transaction: int, request: bytes, now_s: float) -> None:
        pdu = self._framer.decoder.decode(request)
        reply = ExceptionResponse(request[0], ILLEGAL_VALUE) if pdu is None else self._reply(pdu, now_s)
        reply.dev_id = self._unit
        reply.transaction_id = transaction
        self._due += self._framer.buildFrame(reply)

    def _reply(self, request: ModbusPDU, now_s: float) -> ModbusPDU:
        match request:
            case ReadHoldingRegistersRequest(function_code=3):
                values = self._registers.read(request.address, request.count, now_s)
                wrong = self.refusals.get(request.address, ILLEGAL_ADDRESS if values is None else 0)
                done: ModbusPDU = ReadHoldingRegistersResponse(registers=list(values or ()))
            case WriteSingleRegisterRequest():
                wrong = self._registers.write(request.address, request.registers, now_s)
                done = WriteSingleRegisterResponse(address=request.address, registers=request.registers)
            case WriteMultipleRegistersRequest():
                wrong = self._registers.write(request.address, request.registers, now_s)
                done = WriteMultipleRegistersResponse(address=request.address, count=request.count)
            case _:
                wrong, done = ILLEGAL_FUNCTION, request
        return ExceptionResponse(request.function_code, wrong) if wrong else done


def _is_no_header(data: bytes) -> bool:
    return len(data) >= _MBAP and (data[2:4] != b"\x00\x00" or not 2 <= int.from_bytes(data[4:6], "big") <= 254)
