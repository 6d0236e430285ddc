"""What every readout promises, by every driver and on every line: in memory, over TCP and over a pseudo-terminal."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from example_files import EXAMPLE_RIG
from instrument_rigs import angle_meter_rig_file, daq_and_f4t_rig_file, meters_rig_file

from rig.abilities.abilities import Readout
from rig.assembly.open_rig import Rig
from rig.description.drivers import settings_classes
from rig.testing import LINES, keep_promises, rig_on


def _example(folder: Path) -> Path:
    path = folder / "rig.toml"
    path.write_text(EXAMPLE_RIG.read_text(encoding="utf-8"), encoding="utf-8")
    return path


READOUTS = {"angle-meter": "level"}
"""Driver to the name of its readout, where that is not ``dmm``."""
RIGS: dict[str, Callable[[Path], Path]] = {
    "angle-meter": angle_meter_rig_file,
    "hp3458a": _example,
    "scpi-daq": lambda folder: daq_and_f4t_rig_file(folder, streams=False),
    "scpi-meter": meters_rig_file,
}
"""Driver to a rig file with a readout that has it."""


def test_every_readout_is_held_to_these_laws() -> None:
    assert set(RIGS) == set(settings_classes("readouts"))


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=sorted(RIGS))
def readout(request: pytest.FixtureRequest, line: str, tmp_path: Path) -> Iterator[tuple[Rig, Readout]]:
    """One of every driver, in its rig."""
    name = READOUTS.get(request.param, "dmm")
    with rig_on(line, RIGS[request.param](tmp_path)) as opened:
        assert opened.description.readouts[name].driver == request.param
        yield opened, opened.readouts[name]


def test_a_readout_keeps_its_promises(readout: tuple[Rig, Readout]) -> None:
    rig, held = readout
    rig.chance.announce(0, "read", 1, 0.0)
    keep_promises(rig, f"readouts.{held.name}")
    settings = rig.description.readouts[held.name]
    assert held.channels == tuple(f"{held.name}.{name}" for name in settings.channel_names())
    burst = held.read(held.channels[0], 1, rig.clock.sleep)
    assert burst.unit == settings.channel_units()[burst.channel.partition(".")[2]]
    if burst.unit == "v":
        assert held.reading_s(10.0) > held.reading_s(1.0)


@pytest.mark.parametrize("driver", sorted(RIGS))
def test_every_line_brings_the_same_readings(driver: str, tmp_path: Path) -> None:
    """The twins' chance is drawn from counters: what was announced equally reads equally, however it travelled."""
    messages = []
    for line in LINES:
        (tmp_path / line).mkdir()
        with rig_on(line, RIGS[driver](tmp_path / line)) as rig:
            readout = rig.readouts[READOUTS.get(driver, "dmm")]
            readout.prepare()
            rig.chance.announce(7, "read", 2, 0.0)
            messages.append(readout.read(readout.channels[-1], 5, rig.clock.sleep, nplc=1.0).samples)
    assert messages[0].std() > 0.0
    for other in messages[1:]:
        np.testing.assert_array_equal(other, messages[0])
