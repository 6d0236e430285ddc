"""The board as calrig uses it: its table in a rig file, and the members of a stream."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from pulse_imu.codec import COUNT_WRAPS, take_samples
from rig.abilities.abilities import Stream, StreamBlock, StreamGap
from rig.clock import Clock
from rig.description.device_settings import StreamSettings
from rig.errors import DeviceNonsense
from rig.lines.open_lines import Lines
from rig.link.byte_stream import ByteStream

CHANNELS = ("ax", "ay", "az")
MOST_REFUSED = 1000
"""So many bytes without a packet are another device or another baud rate."""


class PulseSettings(StreamSettings):
    """What ``[streams.NAME]`` may hold beside the keys of every stream."""

    driver: Literal["pulse-imu"]
    rate_hz: Annotated[float, Field(gt=0.0, le=1000.0)] = 100.0
    baud_rate: Literal[57600, 115200] = 115200

    def channel_names(self) -> tuple[str, ...]:
        return CHANNELS

    def channel_units(self) -> dict[str, str]:
        return dict.fromkeys(CHANNELS, "g")

    def samples_hz(self) -> float:
        return self.rate_hz


class Pulse:
    """A :class:`rig.abilities.abilities.Stream`."""

    def __init__(self, name: str, settings: PulseSettings, line: ByteStream, clock: Clock) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in CHANNELS)
        self.units = {f"{name}.{channel}": unit for channel, unit in settings.channel_units().items()}
        self.rate_hz = settings.rate_hz
        self._line, self._clock = line, clock
        self._rest = b""
        self._first = self._silent_bytes = 0
        self._next_count: int | None = None

    def identify(self) -> str:
        return "PULSE board, not asked who it is"

    def start(self) -> None:
        """Drop what came before: it cannot be told to begin, and a first packet that is not whole is none."""
        self._line.discard_input()
        self._rest, self._first, self._silent_bytes, self._next_count = b"", 0, 0, None

    def poll(self) -> StreamBlock:
        """Return what came; nothing is waited for."""
        samples, self._rest, refused = take_samples(self._rest + self._line.discard_input())
        self._silent_bytes = 0 if samples else self._silent_bytes + refused
        if self._silent_bytes > MOST_REFUSED:
            raise DeviceNonsense(
                f"{self.name}: {self._silent_bytes} bytes and no packet; check baud rate and that this is the board"
            )
        gaps = []
        for index, sample in enumerate(samples):
            if self._next_count is not None and sample.count != self._next_count:
                missing = (sample.count - self._next_count) % COUNT_WRAPS
                gaps.append(StreamGap(index, missing, f"its count jumps by {missing}"))
            self._next_count = (sample.count + 1) % COUNT_WRAPS
        values = np.array([sample.force_g for sample in samples]).reshape(-1, len(CHANNELS))
        block = StreamBlock(
            stream=self.name,
            first=self._first,
            values={channel: values[:, column] for column, channel in enumerate(self.channels)},
            device_s=np.full(len(samples), np.nan),
            polled_s=self._clock.monotonic_s(),
            gaps=tuple(gaps),
            refused=refused if self._first else 0,
        )
        self._first += len(samples)
        return block

    def stop(self) -> None:
        """Do nothing: it cannot be told to be quiet."""


def connect(name: str, settings: PulseSettings, lines: Lines, clock: Clock) -> Stream:
    """Open the board when a rig is opened."""
    return Pulse(name, settings, lines.stream(f"streams.{name}", settings.port, settings.baud_rate), clock)
