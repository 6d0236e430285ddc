"""The twin of a Prologix adapter with instruments on its bus.

It works through the host's lines one after the other, as the adapter does: while it reads from an instrument, or an
instrument holds the bus, the next line waits. Reading ends at EOI or when no character came for ``read_tmo_ms``.

Source: Prologix GPIB-USB controller manual 6.107; "Unrecognized command" for a refused setting as users report it.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from rig.wire import prologix as wire

VERSION = wire.PROLOGIX
REAL_CLONE = "AR488 GPIB controller, ver. 0.53.04, 13/04/2025"
INTERRUPTING = (b"ifc", b"rst")
"""What ends a reading that does not end by itself."""
RESET_S = 5.0
"""``++rst``: the adapter ignores its input for this long."""

TERMINATORS: Mapping[int, bytes] = {0: b"\r\n", 1: b"\r", 2: b"\n", 3: b""}
"""``++eos``: what is added to a message."""

RANGES: Mapping[str, range] = {
    "mode": range(2),
    "auto": range(2),
    "eoi": range(2),
    "eos": range(4),
    "eot_enable": range(2),
    "eot_char": range(256),
    "read_tmo_ms": range(wire.TIMEOUT_RANGE_MS[0], wire.TIMEOUT_RANGE_MS[1] + 1),
    "savecfg": range(2),
    "addr": range(31),
}
SAVED = frozenset(RANGES) - {"savecfg"}
WITHOUT_EFFECT = frozenset({"ifc", "llo", "loc", "trg", "lon", "status"})
"""Known to the adapter, of no consequence to the instruments here."""


class GpibInstrument(Protocol):
    """A device on the bus, as the bus sees it. Time is an argument, rig seconds, and never steps back."""

    def listen(self, message: bytes, now_s: float, /) -> float:
        """Take a message; returns until when the instrument holds the bus (``now_s`` when it does not)."""

    def talk(self, now_s: float, /) -> tuple[bytes, bool]:
        """Return what it says when addressed to talk at ``now_s``, and whether EOI came with the last byte."""

    def next_talk_s(self) -> float | None:
        """Return when :meth:`talk` will have something, None when nothing is on its way."""

    def serial_poll(self, now_s: float, /) -> int: ...

    def clear(self, now_s: float, /) -> None:
        """Obey a selected device clear."""

    def advance(self, now_s: float, /) -> None:
        """Let everything happen that is due by ``now_s``."""


@runtime_checkable
class PoweredInstrument(Protocol):
    """An instrument that forgets something when its power fails."""

    def power_cycle(self, now_s: float, /) -> None: ...


@dataclass(slots=True)
class _Reading:
    """An unfinished ``++read``: its instrument, its end, and when the last character came."""

    address: int
    to_eoi: bool
    stop: bytes
    last_s: float


class PrologixTwin:
    """A :class:`rig.twins.twin.Twin` with ``instruments`` by primary address."""

    def __init__(
        self,
        instruments: Mapping[int, GpibInstrument],
        *,
        saved: Mapping[str, int] | None = None,
        clone_named: str | None = None,
    ) -> None:
        """``clone_named``: it is an AR488, and what it calls itself."""
        self._clone_name = clone_named
        self.instruments = dict(instruments)
        self.settings = {"mode": 1, "auto": 1, "eoi": 1, "eos": 0, "eot_enable": 0, "eot_char": 0, "read_tmo_ms": 200}
        self.settings |= {"savecfg": 1, "addr": 0, **(saved or {})}
        self.eeprom_writes = 0
        self._partial = b""
        self._lines: deque[wire.HostLine] = deque()
        self._output: list[bytes] = []
        self._reading: _Reading | None = None
        self._free_s = float("-inf")
        self._deaf_until_s = float("-inf")

    def receive(self, data: bytes, now_s: float) -> None:
        self._advance(now_s)
        if now_s < self._deaf_until_s:
            return
        lines, self._partial = wire.split_host_lines(self._partial + data)
        if any(line.for_adapter and line.text in INTERRUPTING for line in lines):
            self._reading = None
        self._lines.extend(lines)
        self._advance(now_s)

    def transmit(self, now_s: float) -> bytes:
        if self._reading is not None or self._lines:
            self._advance(now_s)
        if not self._output:
            return b""
        data = b"".join(self._output)
        self._output.clear()
        return data

    def next_event_s(self) -> float | None:
        reading = self._reading
        if reading is None:
            return self._free_s if self._lines else None
        instrument = self.instruments.get(reading.address)
        talk_s = instrument.next_talk_s() if instrument else None
        limit_s = reading.last_s + self.settings["read_tmo_ms"] / 1000.0
        return limit_s if talk_s is None else min(talk_s, limit_s)

    def power_cycle(self, now_s: float) -> None:
        """Lose power in the whole rack: adapter and instruments."""
        self._lines.clear()
        self._output.clear()
        self._reading = None
        for instrument in self.instruments.values():
            if isinstance(instrument, PoweredInstrument):
                instrument.power_cycle(now_s)

    def _advance(self, now_s: float) -> None:
        while True:
            if self._reading is not None:
                if not self._read_on(self._reading, now_s):
                    return
            elif self._lines and now_s >= self._free_s:
                self._execute(self._lines.popleft(), now_s)
            else:
                return

    def _execute(self, line: wire.HostLine, now_s: float) -> None:
        for instrument in self.instruments.values():
            instrument.advance(now_s)
        if not line.for_adapter:
            self._send_on(line.text, now_s)
        elif line.text == b"read eoi":
            self._start_reading(now_s, to_eoi=True)
        else:
            name, _, argument = line.text.decode("latin-1").partition(" ")
            self._command(name, argument.strip(), now_s)

    def _send_on(self, text: bytes, now_s: float) -> None:
        instrument = self.instruments.get(self.settings["addr"])
        if instrument is not None:
            self._free_s = instrument.listen(text + TERMINATORS[self.settings["eos"]], now_s)
        if self.settings["auto"]:
            self._start_reading(now_s, to_eoi=True)

    def _start_reading(self, now_s: float, *, to_eoi: bool, stop: bytes = b"") -> None:
        self._reading = _Reading(self.settings["addr"], to_eoi, stop, now_s)

    def _read_on(self, reading: _Reading, now_s: float) -> bool:
        """Take what the instrument says; whether anything changed."""
        instrument = self.instruments.get(reading.address)
        data, has_eoi = instrument.talk(now_s) if instrument else (b"", False)
        if data:
            reading.last_s = now_s
            self._output.append(data)
            if has_eoi and self.settings["eot_enable"]:
                self._output.append(bytes([self.settings["eot_char"]]))
        is_whole = (has_eoi and reading.to_eoi) or (reading.stop and data.endswith(reading.stop))
        if is_whole or now_s >= reading.last_s + self.settings["read_tmo_ms"] / 1000.0:
            self._reading = None
        return bool(data) or self._reading is None

    def _command(self, name: str, argument: str, now_s: float) -> None:
        if name == "read":
            if argument and _number(argument) not in range(256):
                self._refuse()
            else:
                self._start_reading(now_s, to_eoi=False, stop=bytes([int(argument)]) if argument else b"")
        elif name == "savecfg" and self._clone_name is not None:
            self.eeprom_writes += 1
        elif name in RANGES:
            self._setting(name, argument)
        elif name == "ver":
            if argument and (argument != "real" or self._clone_name is None):
                self._refuse()
            else:
                self._reply(REAL_CLONE if argument else self._clone_name or VERSION)
        elif name == "clr":
            if instrument := self.instruments.get(self.settings["addr"]):
                instrument.clear(now_s)
        elif name == "spoll":
            self._serial_poll(argument, now_s)
        elif name == "srq":
            self._reply(
                "1" if any(instrument.serial_poll(now_s) & 64 for instrument in self.instruments.values()) else "0"
            )
        elif name == "rst":
            self._deaf_until_s = now_s + RESET_S
            self._lines.clear()
        elif name not in WITHOUT_EFFECT:
            self._refuse()

    def _setting(self, name: str, argument: str) -> None:
        if not argument:
            self._reply(str(self.settings[name]))
        elif (value := _number(argument)) in RANGES[name]:
            is_saved = (name in SAVED and self.settings["savecfg"]) or (name == "savecfg" and value)
            self.eeprom_writes += bool(is_saved) and self._clone_name is None
            self.settings[name] = value
        else:
            self._refuse()

    def _serial_poll(self, argument: str, now_s: float) -> None:
        address = _number(argument.split()[0]) if argument else self.settings["addr"]
        if instrument := self.instruments.get(address):
            self._reply(str(instrument.serial_poll(now_s)))
        else:
            self._free_s = now_s + self.settings["read_tmo_ms"] / 1000.0

    def _refuse(self) -> None:
        self._reply(wire.UNRECOGNIZED.decode("ascii"))

    def _reply(self, text: str) -> None:
        self._output.append(text.encode("ascii") + b"\r\n")


def _number(text: str) -> int:
    """Return a number, -1 where it is none: outside every range."""
    return int(text) if text.isascii() and text.isdigit() else -1
