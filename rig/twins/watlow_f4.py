"""Twin of a Watlow F4 chamber controller: Modbus RTU frames in and out, an environment of the world behind.

It answers functions 3, 6 and 16; what it does not know it refuses by exception, and a frame for another unit or with
a wrong checksum it does not answer at all, as on the line.
"""

import logging
from typing import Protocol

from pymodbus.framer import FramerRTU
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
PROCESS_VALUE, SETPOINT, LOW_LIMIT, HIGH_LIMIT, DECIMALS, UNITS = 100, 300, 602, 603, 606, 901
_LONGEST_FRAME = 256


class Chamber(Protocol):
    """What the twin needs of the world."""

    def read_temperature_degc(self, environment: str, now_s: float) -> float: ...

    def setpoint_degc(self, environment: str) -> float: ...

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None: ...


class WatlowF4Twin:
    """A :class:`rig.twins.twin.Twin`."""

    def __init__(
        self,
        environment: str,
        world: Chamber,
        *,
        unit: int = 1,
        decimals: int = 1,
        limits_degc: tuple[float, float] = (-70.0, 180.0),
        gap_s: float = 1.0,
    ) -> None:
        """``gap_s``: silence after which an unfinished frame is forgotten; long, since no line is this irregular."""
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it logs whole frames as errors
        self._environment = environment
        self._world = world
        self._unit = unit
        self._scale: int = 10**decimals
        self._decimals = decimals
        self._limits_degc = limits_degc
        self._gap_s = gap_s
        self._framer = FramerRTU(DecodePDU(True))
        self._received = b""
        self._last_s = float("-inf")
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        if now_s - self._last_s > self._gap_s:
            self._received = b""
        self._last_s = now_s
        self._received = (self._received + data)[-_LONGEST_FRAME:]
        used, unit, _, request = self._framer.decode(self._received)
        self._received = self._received[used:]
        if request and unit == self._unit:
            self._answer(request, now_s)

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def _answer(self, request: bytes, now_s: float) -> None:
        pdu = self._framer.decoder.decode(request)
        reply = ExceptionResponse(request[0], ILLEGAL_VALUE) if pdu is None else self._reply(pdu, now_s)
        reply.dev_id = self._unit
        self._due += self._framer.buildFrame(reply)

    def _reply(self, request: ModbusPDU, now_s: float) -> ModbusPDU:
        match request:
            case ReadHoldingRegistersRequest(function_code=3):
                return self._read(request, now_s)
            case WriteSingleRegisterRequest():
                wrong = self._write(request.address, list(request.registers), now_s)
                done: ModbusPDU = WriteSingleRegisterResponse(address=request.address, registers=request.registers)
            case WriteMultipleRegistersRequest():
                wrong = self._write(request.address, list(request.registers), now_s)
                done = WriteMultipleRegistersResponse(address=request.address, count=request.count)
            case _:
                wrong, done = ILLEGAL_FUNCTION, request
        return ExceptionResponse(request.function_code, wrong) if wrong else done

    def _read(self, request: ModbusPDU, now_s: float) -> ModbusPDU:
        addresses = range(request.address, request.address + request.count)
        values = [self._value(address, now_s) for address in addresses]
        known = [value for value in values if value is not None]
        if len(known) < len(values):
            return ExceptionResponse(request.function_code, ILLEGAL_ADDRESS)
        return ReadHoldingRegistersResponse(registers=known)

    def _value(self, address: int, now_s: float) -> int | None:
        if address == PROCESS_VALUE:
            return self._raw(self._world.read_temperature_degc(self._environment, now_s))
        constants = {
            SETPOINT: self._raw(self._world.setpoint_degc(self._environment)),
            LOW_LIMIT: self._raw(self._limits_degc[0]),
            HIGH_LIMIT: self._raw(self._limits_degc[1]),
            DECIMALS: self._decimals,
            UNITS: 1,
        }
        return constants.get(address)

    def _write(self, address: int, values: list[int], now_s: float) -> int:
        """The exception to answer with, 0 when written."""
        if address != SETPOINT or len(values) != 1:
            return ILLEGAL_ADDRESS
        degc = (values[0] - 65536 if values[0] >= 32768 else values[0]) / self._scale
        low_degc, high_degc = self._limits_degc
        if not low_degc <= degc <= high_degc:
            return ILLEGAL_VALUE
        self._world.hold(self._environment, degc, now_s)
        return 0

    def _raw(self, degc: float) -> int:
        raw: int = round(degc * self._scale) % 65536
        return raw
