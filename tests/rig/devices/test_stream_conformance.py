"""What every stream promises, by every driver and on every line: in memory, over TCP and over a pseudo-terminal."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from instrument_rigs import daq_and_f4t_rig_file

from rig.assembly.open_rig import Rig
from rig.description.drivers import settings_classes
from rig.testing import LINES, keep_promises, rig_on

STREAMS = {"vn100": "imu", "csv-imu": "board"}
"""Driver to the stream of the wider rig that has it."""
FACTOR = 4.0
"""A terminal holds four kilobytes: what 200 Hz at this pace bring in the tenth of a second between two polls."""


def test_every_stream_is_held_to_these_laws() -> None:
    assert set(STREAMS) == set(settings_classes("streams"))


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def rig(line: str, tmp_path: Path) -> Iterator[Rig]:
    with rig_on(line, daq_and_f4t_rig_file(tmp_path), FACTOR) as opened:
        yield opened


@pytest.mark.parametrize("driver", sorted(STREAMS))
def test_a_stream_keeps_its_promises(rig: Rig, driver: str) -> None:
    name = STREAMS[driver]
    assert rig.description.streams[name].driver == driver
    keep_promises(rig, f"streams.{name}")


@pytest.mark.parametrize("driver", sorted(STREAMS))
def test_a_poll_never_waits_and_a_new_start_drops_what_was_under_way(tmp_path: Path, driver: str) -> None:
    with rig_on("memory", daq_and_f4t_rig_file(tmp_path)) as rig:
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
