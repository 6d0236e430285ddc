"""What a history says with a set that is published is told at once, on standard error, and nothing of a sound one."""

import re
import sqlite3
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest
from archived_runs import STARTED, a_sensor
from command import Outcome, call

from ams.calibration.calibrate import calibrate
from ams.exports.formats import export_set
from ams.inputs.request import CalibrationRequest
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance


def _published(capsys: pytest.CaptureFixture[str], folder: Path, year: int, gain: float, *words: str) -> Outcome:
    """Publish a set of a file of readings, of a yearly calibration of one sensor."""
    rows, made = a_sensor(year, gain=gain).observations, STARTED + timedelta(days=365 * (year - 12))
    provenance = Provenance(
        sensor="SN1", gravity_mps2=9.79826, gravity_source="survey", pitch_range_deg=(-60.0, 60.0),
        roll_range_deg=(-180.0, 180.0), created_utc=made, software_version="0.1.0",
        rig="bench", procedure="readings", simulated=False,
    )  # fmt: skip
    export_set(build_set(calibrate(rows, CalibrationRequest(extended="no")), provenance), "json", folder / "set.json")
    url = f"sqlite:///{folder / 'archive.sqlite'}"
    said = call(capsys, "archive", "publish", folder / "set.json", "--archive", url, *words)
    assert said.status == 0, said.err
    assert "look at this" not in said.out
    return said


def test_a_drift_is_told_with_every_set_that_shows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = [_published(capsys, tmp_path, year, 1.0 + 4e-4 * year).err for year in range(7)]
    assert "look at this" not in said[0]
    assert "sensitivity x by 0.0" in said[1]
    assert "look at this: SN1: more than the two calibrations' own uncertainties explain" in said[1]
    for text in said[4:]:
        assert "look at this: SN1: sensitivity x" in text
        assert "drift, by 0.02" in text, "4e-4 of a radian a year"
    as_json = _published(capsys, tmp_path, 7, 1.0 + 4e-4 * 7, "--json")
    assert as_json.document["sets"][0]["is_new"] is True
    assert "look at this: SN1: sensitivity x" in as_json.err


def test_of_a_sensor_that_stayed_nothing_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for year in range(6):
        assert "look at this" not in _published(capsys, tmp_path, year, 1.0).err


def test_what_the_sets_explain_is_told_where_nothing_can_be_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for year in range(2):
        _published(capsys, tmp_path, year, 1.0)
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    said = call(capsys, "archive", "history", "SN1", "--archive", url)
    assert "(2 of 5 calibrations)" in said.out
    assert re.search(r"what the calibrations state of themselves explains changes up to 0\.\d{4}°", said.out)


def test_a_set_that_cannot_be_read_is_told_and_the_history_stands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for year in range(2):
        _published(capsys, tmp_path, year, 1.0)
    with closing(sqlite3.connect(tmp_path / "archive.sqlite")) as connection, connection:
        connection.execute(
            "UPDATE sets SET document = substr(document, 1, 2000) "
            "WHERE created_utc = (SELECT min(created_utc) FROM sets)"
        )
    said = call(capsys, "archive", "history", "SN1", "--archive", f"sqlite:///{tmp_path / 'archive.sqlite'}")
    assert said.status == 0
    assert "whether the newest calibration changed beyond what the sets state is not known: archive: set" in said.out
