"""The page on a rig of one's own shows what its example files say, and those are checked as a user checks them."""

import re
from pathlib import Path

import pytest
from command import call

from procedures.alerts.settings import read_alerts
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "rig-of-your-own.md").read_text(encoding="utf-8")
EXAMPLE = ROOT / "examples" / "eight-packages"


def test_every_piece_of_the_page_stands_in_its_files() -> None:
    files = [(EXAMPLE / name).read_text(encoding="utf-8") for name in ("rig.toml", "procedure.toml", "alerts.toml")]
    pieces = re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)
    assert len(pieces) > 5
    assert [piece for piece in pieces if not any(piece in file for file in files)] == []


def test_check_takes_the_example_and_expects_every_package(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "check", str(EXAMPLE / "procedure.toml"), "--rig", str(EXAMPLE / "rig.toml"))
    assert outcome.status == 0, outcome.err
    rig = read_rig(EXAMPLE / "rig.toml")
    assert len(rig.sensors) == 8
    assert [serial for serial, sensor in rig.sensors.items() if sensor.check_sensor] == ["CHECK1"]
    assert [serial for serial in rig.sensors if f"{serial} " not in outcome.out] == []


def test_its_relays_are_where_the_page_says_they_are() -> None:
    channels = read_rig(EXAMPLE / "rig.toml").readouts["dmm"].channels
    for index, axis in enumerate("xyz", start=1):
        assert [channels[f"p{index}{axis}"].scanner for index in range(1, 9)] == list(
            range(100 * index, 100 * index + 8)
        )


def test_its_procedure_and_its_alerts_are_read() -> None:
    assert read_procedure(EXAMPLE / "procedure.toml").environment is not None
    assert read_alerts(EXAMPLE / "alerts.toml").command
