"""A set of a file has the day on which it was measured, and where nobody knows it says so, up to the certificate."""

from datetime import UTC, date, datetime
from pathlib import Path

import pytest
from command import call
from package_outputs import write_observations

from ams.archive.sign_offs import SignOff
from ams.exports.formats import load_set
from ams.sets.coefficients import CoefficientSet
from procedures.certificate.grounds import Grounds
from procedures.certificate.page import certificate_page

AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
TODAY = datetime.now(UTC).date()


@pytest.fixture
def observations(tmp_path: Path) -> Path:
    return write_observations(tmp_path / "obs.csv", range(-60, 61, 30), range(-180, 180, 60), 2, noise_v=6e-6)


def _set_of(capsys: pytest.CaptureFixture[str], file: Path, *options: str) -> CoefficientSet:
    path = file.with_suffix(".json")
    where = ("--set", path, "--sensor", "SN1", "--gravity-mps2", "9.8")
    assert call(capsys, "fit", file, *AXES, *where, *options).status == 0
    return load_set(path)


def _certificate(coefficients: CoefficientSet) -> str:
    signed = SignOff(coefficients.sha256, (), ())
    return certificate_page(Grounds("2026-1", date(2026, 3, 3), coefficients, None, signed, is_specimen=True))


def _timed(file: Path, day: str) -> Path:
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    timed = [f"{row},{day}T{8 + index // 60:02d}:{index % 60:02d}:00+00:00" for index, row in enumerate(rows)]
    file.write_text("\n".join([f"{head},started_utc", *reversed(timed)]) + "\n", encoding="utf-8")
    return file


def test_the_day_is_that_of_the_last_reading_of_the_file(
    observations: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = _set_of(capsys, _timed(observations, "2026-02-11"))
    assert found.created_utc == datetime(2026, 2, 11, 8, 59, tzinfo=UTC)
    assert "<dd>2026-02-11</dd>" in _certificate(found)


def test_the_day_that_is_stated_is_that_of_the_set(observations: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = _set_of(capsys, observations, "--calibrated-on", "2026-02-12")
    assert found.created_utc.date() == date(2026, 2, 12)
    assert "<dd>2026-02-12</dd>" in _certificate(found)


def test_a_day_that_nobody_knows_is_no_day_of_calibration(
    observations: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = _set_of(capsys, observations)
    page = _certificate(found)
    assert f"on a day that is not known; the readings were solved on {found.created_utc.date()}" in page
    (remark,) = (text for text in map(str, found.document["remarks"]) if "--calibrated-on" in text)
    assert remark.startswith("the day on which the readings were taken is not known")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--calibrated-on", "11.2.2026"), "--calibrated-on: got '11.2.2026', allowed is a day such as 2026-03-01"),
        (("--calibrated-on", "2999-01-01"), "--calibrated-on: got 2999-01-01, which is to come"),
    ],
)
def test_what_is_no_day_of_the_readings_is_refused(
    observations: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str
) -> None:
    where = ("--set", observations.with_suffix(".json"), "--sensor", "SN1", "--gravity-mps2", "9.8")
    outcome = call(capsys, "fit", observations, *AXES, *where, *options)
    assert outcome.status == 2
    assert said in outcome.err
    assert not observations.with_suffix(".json").exists()


def test_a_day_beside_those_of_the_file_and_a_day_for_nothing_are_refused(
    observations: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lonely = call(capsys, "fit", observations, *AXES, "--calibrated-on", "2026-02-12")
    assert (lonely.status, "belongs to --set or --rig" in lonely.err) == (2, True)
    where = ("--set", observations.with_suffix(".json"), "--sensor", "SN1", "--gravity-mps2", "9.8")
    both = call(capsys, "fit", _timed(observations, "2026-02-11"), *AXES, *where, "--calibrated-on", "2026-02-12")
    assert (both.status, "the file tells it already (column started_utc, last 2026-02-11)" in both.err) == (2, True)


def test_a_moment_that_is_none_is_refused_with_its_line(observations: Path, capsys: pytest.CaptureFixture[str]) -> None:
    timed = _timed(observations, "2026-02-11")
    lines = timed.read_text(encoding="utf-8").splitlines()
    lines[4] = lines[4].replace("2026-02-11T", "yesterday ")
    timed.write_text("\n".join(lines) + "\n", encoding="utf-8")
    where = ("--set", timed.with_suffix(".json"), "--sensor", "SN1", "--gravity-mps2", "9.8")
    outcome = call(capsys, "fit", timed, *AXES, *where)
    assert outcome.status == 2
    assert "line 5: column started_utc: got 'yesterday " in outcome.err


def test_readings_that_are_to_come_are_refused(observations: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = call(capsys, "fit", _timed(observations, "2126-03-02"), *AXES)
    assert found.status == 2
    assert "column started_utc: the last reading is of 2126-03-02, which is to come" in found.err
