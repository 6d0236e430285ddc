"""``calrig prove`` as a command: against served twins it is clean, its bundle is whole, and it asks before it moves."""

import json
import zipfile
from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG

from procedures.cli.main import run_command
from procedures.errors import ExitStatus
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig

FACTOR = 100.0


def test_against_served_twins_it_is_clean_and_keeps_every_byte(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    served_file, bundle = tmp_path / "served.toml", tmp_path / "proof.zip"
    with serve_rig(read_rig(EXAMPLE_RIG), ScaledClock(FACTOR)) as served:
        write_rig(EXAMPLE_RIG, served.addresses, FACTOR, served_file)
        status = run_command(["prove", "--rig", str(served_file), "--out", str(bundle), "--json"])
    document = json.loads(capsys.readouterr().out)
    assert (status, document["differences"]) == (ExitStatus.DONE, 0), document
    assert {device["device"] for device in document["devices"]} >= {"axes.pitch", "readouts.dmm"}
    with zipfile.ZipFile(bundle) as kept:
        names = set(kept.namelist())
        assert json.loads(kept.read("proof.json")) == document
    assert {"rig.toml", "device/axes.pitch.jsonl", "twin/axes.pitch.jsonl", "device/readouts.dmm.jsonl"} <= names


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--motion", "pitch"], "nobody can be asked here; nothing was opened"),
        (["--motion", "azimuth", "--yes"], "no axis 'azimuth'"),
        (["--out", "/nowhere/proof.zip"], "there is no folder /nowhere"),
    ],
)
def test_it_refuses_before_anything_is_opened(
    capsys: pytest.CaptureFixture[str], arguments: list[str], sentence: str
) -> None:
    assert run_command(["prove", "--rig", str(EXAMPLE_RIG), *arguments]) == ExitStatus.WRONG_REQUEST
    assert sentence in capsys.readouterr().err
