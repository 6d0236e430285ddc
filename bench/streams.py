"""What streams cost: the share of one processor that a driver takes to keep up, from bytes to blocks.

A tape hands out one second of lines a poll, so what is measured is reading, checking, parsing and looking for gaps;
the port itself is not.
"""

from collections.abc import Iterator
from datetime import UTC, datetime

from bench.figure import Effort, Figure
from rig.abilities.abilities import Stream
from rig.clock import VirtualClock
from rig.devices.csv_imu import CsvImuSettings
from rig.devices.csv_imu import connect as connect_csv
from rig.devices.vn100 import Vn100Settings
from rig.devices.vn100 import connect as connect_vn100
from rig.link.memory import MemoryStream
from rig.wire import vn100 as wire
from rig.wire.csv_rows import RowShape, format_row


class Tape:
    """A peer that acknowledges every command and sends the same second again and again."""

    def __init__(self, second: bytes) -> None:
        self._second = second
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 it takes no time
        self._due = data

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it takes no time
        due, self._due = self._due or self._second, b""
        return due

    def next_event_s(self) -> float | None:
        return None


def figures(effort: Effort) -> Iterator[Figure]:
    """Per cent of one processor."""
    clock = VirtualClock(datetime(2024, 3, 1, tzinfo=UTC))
    values = (100.949, -7.33, 0.715, -0.0049, -0.2449, 0.5397, -1.258, -0.1, -9.701, -0.000018, 0.001122, -0.000551)
    settings = Vn100Settings(driver="vn100", port="tape", baud_rate=460800, rate_hz=200, output="YMR")
    tape = MemoryStream(Tape(wire.format_row("YMR", values) * 200), clock, "tape")
    yield _share(effort, "VN-100, 200 Hz × 12 fields", connect_vn100("imu", settings, tape, clock), 200, 1.0)

    channels = {name: {"preset": "SCA3000"} for name in ("a", "b", "c", "d")}
    text = {"driver": "csv-imu", "port": "tape", "rate_hz": 10_000.0, "columns": list(channels), "channels": channels}
    lines = b"".join(format_row([b"%d" % (row % 2000 - 1000)] * 4, RowShape(4)) for row in range(10_000))
    tape = MemoryStream(Tape(lines), clock, "tape")
    board = connect_csv("imu", CsvImuSettings.model_validate(text), tape, clock)
    yield _share(effort, "text stream, 10 kHz × 4 channels", board, 10_000, 10.0)


def _share(effort: Effort, what: str, stream: Stream, samples: int, target: float) -> Figure:
    stream.start()
    stream.poll()

    def poll() -> None:
        block = stream.poll()
        assert (block.samples, block.refused) == (samples, 0)

    return Figure(f"{what}, of one processor", 100.0 * effort.best_s(poll), "%", target, at_most=True)
