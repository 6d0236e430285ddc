"""The Maestro's ear: bytes in, commands and error bits out. All three forms may be mixed on one line.

A command byte in the middle of a packet ends it with a protocol error and starts the next; a packet for another
device is passed over; a wrong CRC is an error bit and no command.

Source: Pololu Maestro user's guide, sections 4.e, 5.c and 5.d (pages 39, 52, 53).
"""

from dataclasses import dataclass

from rig.wire import maestro as wire
from rig.wire.maestro import Errors, Request

_COMMAND_BIT = 0x80
_MINI_SSC_LENGTH = 3


@dataclass(frozen=True, slots=True)
class MiniSsc:
    """A target by the third form: one byte, 0 to 254."""

    servo: int
    target: int


Heard = Request | MiniSsc | Errors


class MaestroReader:
    """Takes bytes as they come."""

    def __init__(self, *, device: int = wire.DEFAULT_DEVICE, has_crc: bool = False, is_mini: bool = True) -> None:
        self._device = device
        self._has_crc = has_crc
        self._is_mini = is_mini
        self._packet = b""

    def take(self, data: bytes) -> list[Heard]:
        """Return what is complete with these bytes, in order."""
        heard: list[Heard] = []
        for byte in data:
            heard += self._take_byte(byte)
        return heard

    def _take_byte(self, byte: int) -> list[Heard]:
        heard: list[Heard] = []
        is_data = not byte & _COMMAND_BIT or self._packet[:1] == bytes([wire.MINI_SSC])
        if not is_data:
            heard += [Errors.PROTOCOL] if self._packet else []
            self._packet = bytes([byte])
        elif self._packet:
            self._packet += bytes([byte])
        else:
            return [Errors.PROTOCOL]
        return heard + self._finished()

    def _finished(self) -> list[Heard]:
        """Return the packet's command when nothing is missing; the packet is then over."""
        length = self._length()
        if length is None:
            self._packet = b""
            return [Errors.PROTOCOL]
        if len(self._packet) < length:
            return []
        packet, self._packet = self._packet, b""
        if packet[0] == wire.MINI_SSC:
            return [MiniSsc(packet[1], packet[2])]
        if packet[0] == wire.START and packet[1] != self._device:
            return []
        if self._has_crc:
            if wire.crc7(packet[:-1]) != packet[-1]:
                return [Errors.CRC]
            packet = packet[:-1]
        head = 1 if packet[0] != wire.START else 3
        return [Request(packet[head - 1] | _COMMAND_BIT, tuple(packet[head:]))]

    def _length(self) -> int | None:
        """Return the bytes of the whole packet as far as can be told; None for an unknown command."""
        if self._packet[0] == wire.MINI_SSC:
            return _MINI_SSC_LENGTH
        head = 3 if self._packet[0] == wire.START else 1
        if len(self._packet) < head:
            return head
        command = self._packet[head - 1] | _COMMAND_BIT
        if command in wire.MINI_ONLY and not self._is_mini:
            return None
        if command == wire.SET_MULTIPLE_TARGETS:
            count = self._packet[head] if len(self._packet) > head else 0
            return head + 2 + 2 * count + self._has_crc
        data = wire.DATA_BYTES.get(command)
        return None if data is None else head + data + self._has_crc
