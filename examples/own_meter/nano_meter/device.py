"""The meter as calrig uses it: its table in a rig file, and the members of a readout.

The meter is made up. Messages end with a line feed: ``*IDN?``, ``*RST``, ``INP 2`` and ``INP?`` choose an input,
``NPLC 10`` and ``NPLC?`` the integration time, ``READ?`` takes one reading of the fixed 10 V range.
"""

from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from rig.abilities.abilities import Burst, Readout, Wait
from rig.abilities.scpi_talk import require, require_no_error
from rig.clock import Clock
from rig.description.device_settings import Positive, ReadoutSettings
from rig.drivers.message_lines import message_line
from rig.errors import DeviceNonsense, RequestRefused
from rig.lines.open_lines import Lines
from rig.link.messages import TALK_TIMEOUT_S, MessageLine
from rig.wire import scpi

MAINS_HZ = 50.0
OVERHEAD_S = 0.01
MOST_SAMPLES = 10_000
RANGE_V = 10.0
"""The one that it has."""


class NanoSettings(ReadoutSettings):
    """What ``[readouts.NAME]`` may hold beside ``identity`` and ``standard``."""

    driver: Literal["nano-meter"]
    resource: str
    """``twin``, ``socket://host:port``, ``prologix+…#address``."""
    nplc: Positive = 10.0
    channels: dict[str, Annotated[int, Field(ge=1, le=3)]] = Field(min_length=1)
    """Name to input."""

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def range_of_channel_v(self, channel: str) -> float:  # noqa: ARG002  every input has the one range
        return RANGE_V

    @property
    def integrates_nplc(self) -> float:
        return self.nplc

    def reading_s(self, nplc: float | None = None) -> float:
        return (self.nplc if nplc is None else nplc) / MAINS_HZ + OVERHEAD_S


class NanoMeter:
    """A :class:`rig.abilities.abilities.Readout`."""

    def __init__(self, name: str, settings: NanoSettings, line: MessageLine, clock: Clock) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self._inputs = dict(zip(self.channels, settings.channels.values(), strict=True))
        self._settings, self._line, self._clock = settings, line, clock

    def identify(self) -> str:
        maker, model, serial, firmware = self._line.ask(b"*IDN?", scpi.parse_identity, idempotent=True)
        if model != "NANO-7":
            raise DeviceNonsense(f"{self.name}: *IDN? says model {model!r}, need 'NANO-7'; check the address")
        return f"{maker} {model} {serial} {firmware}"

    def prepare(self) -> None:
        self._line.clear()
        self.identify()
        self._line.tell(b"*RST")
        require_no_error(self._line, self.name, "reset", "nothing is measured")

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        if channel not in self._inputs or not 1 <= samples <= MOST_SAMPLES:
            allowed = f"1 to {MOST_SAMPLES} of {', '.join(self.channels)}"
            raise RequestRefused(f"{self.name}: {samples} readings of {channel}: allowed {allowed}; nothing was read")
        cycles = self._settings.nplc if nplc is None else nplc
        is_whole = False
        try:
            self._set_up(self._inputs[channel], cycles)
            started_s = self._clock.monotonic_s()
            values_v = np.array([self._reading_v(cycles, wait) for _ in range(samples)])
            require_no_error(self._line, self.name, "the burst", "it is dropped")
            is_whole = True
        finally:
            if not is_whole:
                self._line.clear()  # what it still owes is not the next answer
        overload = np.abs(values_v) > scpi.LARGEST_READING
        values_v[overload] = np.nan
        return Burst(channel, values_v, overload, started_s, self.reading_s(cycles))

    def reading_s(self, nplc: float | None = None) -> float:
        return self._settings.reading_s(nplc)

    def checks(self) -> Mapping[str, float]:
        return {}

    def _set_up(self, number: int, cycles: float) -> None:
        """Set input and integration time and read them back."""
        for header, value in ((b"INP", number), (b"NPLC", cycles)):
            self._line.tell(b"%s %g" % (header, value))
            require(self._line, self.name, header + b"?", value)

    def _reading_v(self, cycles: float, wait: Wait) -> float:
        """Time passes in ``wait``: that is how a stop reaches a reading that is being taken."""
        self._line.tell(b"READ?")
        wait(self.reading_s(cycles))
        (reading_v,) = self._line.hear(b"READ?", scpi.parse_readings, timeout_s=self.reading_s(cycles) + TALK_TIMEOUT_S)
        return reading_v


def connect(name: str, settings: NanoSettings, lines: Lines, clock: Clock) -> Readout:
    """Open the meter when a rig is opened; the adapter of a bus is shared with whoever hangs on it as well."""
    return NanoMeter(name, settings, message_line(f"readouts.{name}", settings.resource, lines, 5), clock)
