"""What every environment promises, by every driver and on every line: in memory, over TCP and over a pty."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from instrument_rigs import CHAMBER, daq_and_f4t_rig_file

from rig.assembly.open_rig import Rig
from rig.description.drivers import settings_classes
from rig.testing import LINES, keep_promises, rig_on


def _ascii(model: str) -> str:
    return f'[environment.air]\ndriver = "ascii-chamber"\nport = "twin"\nmodel = "{model}"\n'


TABLES = {
    "ascii-chamber": _ascii("thermotron-8800"),
    "ascii-chamber, degF": f'{_ascii("thermotron-8800")}values = "degf"\n',
    "ascii-chamber, thermotron-3800": f'{_ascii("thermotron-3800")}values = "degc"\npause_s = 0.01\n',
    "ascii-chamber, espec-p300": f'{_ascii("espec-p300")}values = "degc"\npause_s = 0.01\naddress = 1\n',
    "watlow-f4": CHAMBER.replace("watlow-f4t", "watlow-f4"),
    "watlow-f4t": CHAMBER,
    "watlow-f4t, rtu": f'{CHAMBER}transport = "rtu"\n',
    "watlow-f4t, high word first": f'{CHAMBER}word_order = "high-first"\n',
}
"""Driver, and how it is set up, to its table."""
FACTOR = 150.0
LIMITS = "limits_degc = [-40.0, 85.0]\n"


def test_every_environment_is_held_to_these_laws() -> None:
    assert {name.partition(",")[0] for name in TABLES} == set(settings_classes("environments"))


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=sorted(TABLES))
def rig(request: pytest.FixtureRequest, line: str, tmp_path: Path) -> Iterator[Rig]:
    path = daq_and_f4t_rig_file(tmp_path, streams=False)
    text = path.read_text(encoding="utf-8").replace(CHAMBER, TABLES[request.param] + LIMITS)
    path.write_text(text, encoding="utf-8")
    with rig_on(line, path, FACTOR) as opened:
        assert opened.description.environment["air"].driver == request.param.partition(",")[0]
        yield opened


def test_an_environment_keeps_its_promises(rig: Rig) -> None:
    keep_promises(rig, "environment.air")
