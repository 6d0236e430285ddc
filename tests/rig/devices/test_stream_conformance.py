"""What every stream promises, by every driver and on every line: in memory, over TCP and over a pseudo-terminal."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ported_rig import LINES, rig_on
from wider_rig import wider_rig_file

from rig.assembly.open_rig import Rig
from rig.description.drivers import settings_classes
from rig.devices.abilities import Stream, StreamBlock

STREAMS = {"vn100": "imu", "csv-imu": "board"}
"""Driver to the stream of the wider rig that has it."""
FACTOR = 4.0
"""A terminal holds four kilobytes: what 200 Hz at this pace bring in the tenth of a second between two polls."""
LONGEST_S = 60.0
UNITS = {"g", "dps", "ut", "mps2", "v", "deg", "gauss", "radps", "degc", "kpa", "counts"}


def test_every_stream_is_held_to_these_laws() -> None:
    assert set(STREAMS) == set(settings_classes("streams"))


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def rig(line: str, tmp_path: Path) -> Iterator[Rig]:
    with rig_on(line, wider_rig_file(tmp_path), FACTOR) as opened:
        yield opened


def _taken(stream: Stream, rig: Rig, samples: int) -> list[StreamBlock]:
    """Polls until so many samples have come; a busy machine is late, but nothing is lost."""
    blocks: list[StreamBlock] = []
    ends_s = rig.clock.monotonic_s() + LONGEST_S
    while sum(block.samples for block in blocks) < samples and rig.clock.monotonic_s() < ends_s:
        rig.clock.sleep(0.1)
        blocks.append(stream.poll())
    return blocks


@pytest.mark.parametrize("driver", sorted(STREAMS))
def test_a_stream_keeps_its_promises(rig: Rig, driver: str) -> None:
    name = STREAMS[driver]
    stream = rig.streams[name]
    assert rig.description.streams[name].driver == driver
    assert stream.identify()
    assert set(stream.units) == set(stream.channels)
    assert set(stream.units.values()) <= UNITS
    assert all(channel.startswith(f"{name}.") for channel in stream.channels)
    stream.start()
    began_s = rig.clock.monotonic_s()
    blocks = _taken(stream, rig, round(2.0 * stream.rate_hz))
    assert [block.first for block in blocks] == list(np.cumsum([0, *(block.samples for block in blocks)])[:-1])
    for block in blocks:
        assert block.stream == name
        assert set(block.values) == set(stream.channels)
        assert {values.shape for values in block.values.values()} == {block.device_s.shape}
        assert (block.gaps, block.refused) == ((), 0)
    polled_s = [block.polled_s for block in blocks]
    assert polled_s == sorted(polled_s)
    assert sum(block.samples for block in blocks) >= 2.0 * stream.rate_hz
    assert polled_s[-1] - began_s >= 1.9  # and they did not come faster than they were taken
    stream.stop()


@pytest.mark.parametrize("driver", sorted(STREAMS))
def test_a_poll_never_waits_and_a_new_start_drops_what_was_under_way(tmp_path: Path, driver: str) -> None:
    with rig_on("memory", wider_rig_file(tmp_path)) as rig:
        stream = rig.streams[STREAMS[driver]]
        stream.start()
        rig.clock.sleep(1.0)
        before_s = rig.clock.monotonic_s()
        assert stream.poll().samples > 0
        assert stream.poll().samples == 0
        assert rig.clock.monotonic_s() == before_s
        rig.clock.sleep(30.0)
        stream.stop()
        stream.start()
        assert stream.poll().samples <= 1
        rig.clock.sleep(1.0)
        assert stream.poll().samples == pytest.approx(stream.rate_hz, abs=2)
