"""What every readout promises, by every driver and on every line: in memory, over TCP and over a pseudo-terminal."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from example_files import EXAMPLE_RIG
from ported_rig import LINES, rig_on
from wider_rig import meters_rig_file, wider_rig_file

from rig.assembly.open_rig import Rig
from rig.description.drivers import settings_classes
from rig.devices.abilities import Readout
from rig.errors import RequestRefused, WaitEnded


def _example(folder: Path) -> Path:
    path = folder / "rig.toml"
    path.write_text(EXAMPLE_RIG.read_text(encoding="utf-8"), encoding="utf-8")
    return path


RIGS: dict[str, Callable[[Path], Path]] = {
    "hp3458a": _example,
    "scpi-daq": lambda folder: wider_rig_file(folder, streams=False),
    "scpi-meter": meters_rig_file,
}
"""Driver to a rig file whose readout ``dmm`` has it."""


def test_every_readout_is_held_to_these_laws() -> None:
    assert set(RIGS) == set(settings_classes("readouts"))


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=sorted(RIGS))
def rig(request: pytest.FixtureRequest, line: str, tmp_path: Path) -> Iterator[Rig]:
    with rig_on(line, RIGS[request.param](tmp_path)) as opened:
        assert opened.description.readouts["dmm"].driver == request.param
        yield opened


def _prepared(rig: Rig) -> Readout:
    readout = rig.readouts["dmm"]
    readout.prepare()
    return readout


def test_a_readout_keeps_its_promises(rig: Rig) -> None:
    readout = _prepared(rig)
    assert readout.identify()
    assert readout.identify() == readout.identify()
    assert readout.channels == tuple(f"dmm.{name}" for name in rig.description.readouts["dmm"].channel_names())
    assert all(isinstance(value, float) for value in readout.checks().values())
    rig.chance.announce(0, "read", 1, 0.0)
    began_s = rig.clock.monotonic_s()
    burst = readout.read(readout.channels[0], 4, rig.clock.sleep, nplc=1.0)
    ended_s = rig.clock.monotonic_s()
    assert burst.channel == readout.channels[0]
    assert burst.samples.shape == burst.overload.shape == (4,)
    assert np.isfinite(burst.samples).all()
    assert not burst.overload.any()
    assert began_s <= burst.started_s <= ended_s
    assert burst.interval_s == pytest.approx(readout.reading_s(1.0), rel=0.5)
    assert ended_s - burst.started_s >= 3.0 * burst.interval_s
    assert readout.reading_s(10.0) > readout.reading_s(1.0)


def test_neither_a_refusal_nor_a_stop_harms_the_next_burst(rig: Rig) -> None:
    readout = _prepared(rig)
    first, last = readout.channels[0], readout.channels[-1]
    for channel, samples in (("dmm.none", 3), ("x", 3), (first, 0)):
        with pytest.raises(RequestRefused, match="dmm"):
            readout.read(channel, samples, rig.clock.sleep)
    assert readout.read(first, 1, rig.clock.sleep, nplc=1.0).samples.size == 1

    def wait(duration_s: float) -> None:
        raise WaitEnded(f"stop, {duration_s:g} s early")

    with pytest.raises(WaitEnded):
        readout.read(first, 5, wait, nplc=10.0)
    burst = readout.read(last, 2, rig.clock.sleep, nplc=1.0)
    assert np.isfinite(burst.samples).all()


@pytest.mark.parametrize("driver", sorted(RIGS))
def test_every_line_brings_the_same_readings(driver: str, tmp_path: Path) -> None:
    """The twins' chance is drawn from counters: what was announced equally reads equally, however it travelled."""
    told = []
    for line in LINES:
        (tmp_path / line).mkdir()
        with rig_on(line, RIGS[driver](tmp_path / line)) as rig:
            readout = _prepared(rig)
            rig.chance.announce(7, "read", 2, 0.0)
            told.append(readout.read(readout.channels[-1], 5, rig.clock.sleep, nplc=1.0).samples)
    assert told[0].std() > 0.0
    for other in told[1:]:
        np.testing.assert_array_equal(other, told[0])
