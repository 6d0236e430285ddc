"""A set that is dated in the future wins as the newest of its sensor; everything that rests on it says so."""

import re
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

import pytest
from archived_runs import STARTED, a_run, a_sensor
from command import call
from example_files import EXAMPLE_RIG

from ams.archive.runs import publish_run
from ams.archive.sets import list_sets
from ams.archive.signatures import sign
from ams.exports.formats import export_set
from procedures.delivery.publish import history_findings

AHEAD_DAYS = 400
FAR = date(2999, 1, 1)


def _day_of_today() -> int:
    """The newest of the days of `a_run` whose night is over at any hour of the day."""
    return (datetime.now(UTC) - STARTED - timedelta(days=1)).days


@pytest.fixture
def url(tmp_path: Path) -> str:
    """An archive of a calibration of yesterday, and of one by a clock that was more than a year ahead."""
    archive = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    for day in (_day_of_today() - 1, _day_of_today() + AHEAD_DAYS):
        publish_run(archive, a_run(day), [a_sensor(day, due=FAR)], datetime.now(UTC))
    return archive


def _is_told(text: str, sha256: str) -> bool:
    words = " ".join(text.split())
    told = f"SN1: set {sha256[:12]} is dated "
    return told in words and "in the future by" in words and "counts as the newest of the sensor" in words


def test_every_look_at_the_archive_and_every_use_of_its_newest_set_tells_it(
    url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sha256 = list_sets(url, "SN1")[-1].sha256
    for words in (
        ["history", "SN1"],
        ["due"],
        ["show", "SN1"],
        ["export", "SN1", "--to", "csv", "--out", tmp_path / "s.csv"],
    ):
        said = call(capsys, "archive", *words, "--archive", url)
        assert said.status == 0, said.err
        assert _is_told(said.out + said.err, sha256), words
    assert "in the future" in " ".join(
        call(capsys, "archive", "history", "SN1", "--archive", url, "--json").document["dated_ahead"]
    )
    lines = call(capsys, "archive", "list", "--archive", url).out.splitlines()
    assert [line.endswith(", dated in the future by the clock of this computer") for line in lines] == [
        False,
        False,
        True,
    ]


def test_a_calibration_that_is_published_behind_it_is_told_that_it_is_not_the_newest(url: str) -> None:
    sensors = [a_sensor(_day_of_today(), due=FAR)]
    published = publish_run(url, a_run(_day_of_today()), sensors, datetime.now(UTC))
    (found,) = [
        entry for entry in history_findings(url, published.publications, datetime.now(UTC)) if "in the future" in entry
    ]
    assert "before what is calibrated after it" in found


def test_attitude_by_such_a_set_says_it(url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for day, is_ahead in ((_day_of_today() - 1, False), (_day_of_today() + AHEAD_DAYS, True)):
        coefficients = a_sensor(day, due=FAR).coefficients
        export_set(coefficients, "json", tmp_path / "set.json")
        (tmp_path / "rows.csv").write_text("x_v,y_v,z_v\n0.1,0.2,2.4\n", encoding="utf-8")
        said = call(capsys, "attitude", tmp_path / "set.json", tmp_path / "rows.csv")
        assert _is_told(said.err, coefficients.sha256) is is_ahead


def test_check_says_it_before_the_sensor_is_calibrated_again(
    url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    number = iter(range(50))
    text = EXAMPLE_RIG.read_text(encoding="utf-8").replace("sensors.SN1047", "sensors.SN1")
    text = text.replace('resource = "twin"', 'resource = "prologix+socket://localhost:3999#22"')
    text = re.sub(r'port = "twin"', lambda _: f'port = "socket://localhost:{4000 + next(number)}"', text)
    (tmp_path / "rig.toml").write_text(text.partition("\n[twin")[0], encoding="utf-8")
    words = ["check", "--rig", tmp_path / "rig.toml", "--archive", url]
    sha256 = list_sets(url, "SN1")[-1].sha256
    said = call(capsys, *words)
    assert _is_told(said.out, sha256), said.out + said.err
    assert len(call(capsys, *words, "--json").document["dated_ahead"]) == 1
    sign(url, sha256, "withdrawn", "C. Lim", datetime.now(UTC), "the clock was wrong")
    assert "in the future" not in call(capsys, *words).out


def test_clocks_that_differ_by_minutes_are_not_told(tmp_path: Path) -> None:
    archive = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    published = publish_run(archive, a_run(0), [a_sensor(0)], datetime.now(UTC))
    (created,) = [row.created_utc for row in list_sets(archive)]
    assert not list(history_findings(archive, published.publications, created - timedelta(minutes=9)))
    assert list(history_findings(archive, published.publications, created - timedelta(minutes=11)))
