"""A run as tables: the numbers are those that SQLite and NumPy alone read out of the journal, to the last bit."""

import json
import re
import shutil
import sqlite3
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from finished_job import FinishedJob
from journals import a_clock, a_dwell, with_overload
from stored_runs import CASES, StoredCase, name_of

from procedures.data.columns import DATA_VERSION, TABLES
from procedures.data.run_data import RunData, read_run
from procedures.data.tables import dwells_table, readings_table
from procedures.errors import JournalError, RequestError
from procedures.journal.journal import Journal

PAGE = Path(__file__).parents[3] / "docs" / "data.md"
CASE = next(case for case in CASES if case.folder.name == "grid")
CONTRACT = {
    "dwells": "run step attempt epoch replication point mounting purpose accepted reasons started_utc pitch_deg "
    "roll_deg yaw_deg temperature_degc",
    "readings": "step attempt sensor axis channel unit mean sd n",
    "events": "sequence utc monotonic_s kind detail sha256",
    "samples": "step attempt sensor axis channel unit sample time_s value",
}
"""Version 1, written down a second time: other people's programs hold us to it."""


UNITS = {
    "grid": {"dmm.x": "v"},
    "rates_gyro": {"logger.gx": "v", "axes.roll": "dps"},
    "static": {"imu.ax": "g", "imu.gx": "dps"},
    "two_level": {"imu.mx": "ut"},
}
"""Of some channels, as the rig files of the stored runs have them."""


def stored(journal: Path) -> Iterator[tuple[int, dict[str, Any], dict[str, np.ndarray]]]:
    """Number, record and samples by channel of every dwell, by SQLite, JSON and NumPy alone."""
    connection = sqlite3.connect(journal)
    rows = connection.execute("SELECT number, record, samples FROM dwells ORDER BY number").fetchall()
    connection.close()
    for number, text, blob in rows:
        record, values, first = json.loads(text), np.frombuffer(blob, "<f8"), 0
        channels = {}
        for channel, count, *_ in record["readings"]:
            channels[channel] = values[first : first + count]
            first += count
        yield number, record, channels


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunData:
    return read_run(CASE.copy("finished", tmp_path_factory.mktemp("data") / "run"))


def test_the_columns_are_the_contract(run: RunData) -> None:
    assert DATA_VERSION == 1
    assert {name: " ".join(column.name for column in columns) for name, columns in TABLES.items()} == CONTRACT
    for name, table in {"dwells": run.dwells, "readings": run.readings, "events": run.events}.items():
        assert list(table.columns) == CONTRACT[name].split()
    assert list(run.samples().columns) == CONTRACT["samples"].split()


def test_the_page_lists_every_column_and_its_version() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert f"## The columns, version {DATA_VERSION}\n" in text
    for name, columns in TABLES.items():
        section = re.search(rf"### {name}\n(.*?)(?=\n##|\Z)", text, flags=re.DOTALL)
        assert section is not None
        said = re.findall(r"^\| `(.*?)` \| (.*?) \| (.*) \|$", section[1], flags=re.MULTILINE)
        assert said == [(column.name, column.kind, column.meaning) for column in columns]


@pytest.mark.parametrize("case", CASES, ids=name_of)
def test_every_number_is_the_journals_own(case: StoredCase, tmp_path: Path) -> None:
    folder = case.copy("finished", tmp_path / "run")
    found = read_run(folder)
    expected = list(stored(folder / "journal.sqlite"))
    assert found.dwells.index.tolist() == [number for number, *_ in expected]
    for number, record, channels in expected:
        row = found.dwells.loc[number]
        for key in ("step", "attempt", "epoch", "replication", "point", "mounting", "purpose", "accepted"):
            assert row[key] == record[key], key
        assert row["started_utc"] == pd.Timestamp(record["started_utc"])
        readings = found.readings.loc[[number]].set_index("channel")
        for channel, values in channels.items():
            assert readings.loc[channel, "mean"] == values.mean()
            assert readings.loc[channel, "n"] == values.size
            np.testing.assert_array_equal(
                readings.loc[channel, "sd"], values.std(ddof=1) if values.size > 1 else np.nan
            )
        rates_dps = record.get("motion", {}).get("rates_dps", {})
        assert {axis: readings.loc[f"axes.{axis}", "mean"] for axis in rates_dps} == rates_dps
        commanded_deg = record.get("motion", {}).get("commanded_deg", {})
        assert {axis: readings.loc[f"commanded.{axis}", "mean"] for axis in commanded_deg} == commanded_deg
        if not any(rates_dps.values()):
            known = {axis: row[f"{axis}_deg"] for axis in record["measured_deg"]}
            assert known == record["measured_deg"]
    stated = found.readings.drop_duplicates("channel").set_index("channel")["unit"]
    units = UNITS.get(case.folder.name, {})
    assert {channel: stated[channel] for channel in units} == units


def test_every_sample_is_there_in_its_order(run: RunData) -> None:
    samples = run.samples()
    expected = list(stored(run.path / "journal.sqlite"))
    flat = [value for _, _, channels in expected for values in channels.values() for value in values]
    assert samples["value"].tolist() == flat
    number, record, _ = expected[4]
    channel, count, started_s, interval_s = record["readings"][1]
    part = samples.loc[[number]]
    part = part[part["channel"] == channel]
    assert part["sample"].tolist() == list(range(count))
    assert part["time_s"].tolist() == [started_s + index * interval_s for index in range(count)]
    assert set(samples["sensor"]) == {"SN1047"}


def test_the_events_are_those_of_the_journal(run: RunData) -> None:
    connection = sqlite3.connect(run.path / "journal.sqlite")
    rows = connection.execute("SELECT sequence, kind, detail, sha256 FROM events ORDER BY sequence").fetchall()
    connection.close()
    assert [tuple(row) for row in run.events[["sequence", "kind", "detail", "sha256"]].itertuples(index=False)] == rows


def test_readings_find_their_dwell_also_where_a_step_has_the_same_attempt_in_two_epochs() -> None:
    dwells = [(1, a_dwell(3)), (2, a_dwell(4)), (3, replace(a_dwell(3, epoch=2), measured_deg={"pitch": 30.0}))]
    joined = readings_table(dwells, {}).join(dwells_table("r", dwells)[["pitch_deg"]])
    assert len(joined) == 9
    assert joined.loc[3, "pitch_deg"].tolist() == [30.0] * 3


def test_an_overloaded_channel_has_no_mean_and_a_dwell_no_angle_that_was_not_read() -> None:
    dwells = [(1, with_overload(a_dwell(0)))]
    assert readings_table(dwells, {})["mean"].isna().tolist() == [True, False, False]
    assert np.isnan(dwells_table("r", dwells)["yaw_deg"].iloc[0])


def test_several_environments_are_readings_and_no_temperature_of_the_dwell() -> None:
    dwells = [(1, replace(a_dwell(0), temperature_degc={"air": 20.5, "table": 19.0}))]
    assert np.isnan(dwells_table("r", dwells)["temperature_degc"].iloc[0])
    warm = readings_table(dwells, {}).query("unit == 'degc'")
    assert dict(zip(warm["channel"], warm["mean"], strict=True)) == {"environment.air": 20.5, "environment.table": 19.0}


def test_a_dwell_that_was_taken_back_is_not_accepted_and_says_why(tmp_path: Path) -> None:
    folder = CASE.copy("finished", tmp_path / "run")
    clock = a_clock()
    journal = Journal.open_for_append(folder / "journal.sqlite")
    row = read_run(folder).dwells.iloc[-1]
    key = [int(row["step"]), int(row["attempt"]), int(row["epoch"])]
    journal.append_event("voided", {"by": "A. Person", "reason": "bumped", "dwells": [key]}, clock)
    journal.close()
    last = read_run(folder).dwells.iloc[-1]
    assert not last["accepted"]
    assert last["reasons"].endswith("voided by A. Person: bumped")


def test_solve_gives_what_the_version_that_stored_the_run_solved(run: RunData) -> None:
    found = run.solve()
    expected = CASE.numbers["SN1047"]["axes"]
    for axis, section in expected.items():  # noqa: B007, PERF102  the query below names the axis
        rows = found.parameters.query("axis == @axis").set_index("parameter")["value"]
        text = {name: entry["value"] for name, entry in section["parameters"].items()}
        assert {name: pytest.approx(value, rel=1e-9) for name, value in text.items()} == {n: rows[n] for n in text}
    documented = {word for entry in found.document["sensors"]["SN1047"]["axes"].values() for word in entry["warnings"]}
    assert documented
    assert [word for word in documented if not any(found.endswith(f": {word}") for found in found.warnings)] == []


def test_a_notebook_shows_a_run_and_a_solution(run: RunData) -> None:
    assert "47 dwells, 47 of them accepted" in run._repr_html_()
    assert "offset_v" in run.solve()._repr_html_()
    assert len(run.plot().axes) == 3
    assert run.plot("dmm.y")._repr_svg_().startswith("<?xml")
    drawn = run.solve().plot().axes[0].lines[-1].get_ydata()
    solved = run.solve().sensors["SN1047"].calibration
    assert solved is not None
    np.testing.assert_allclose(drawn, solved.axes["x"].residuals_v * 1e6)


def test_a_damaged_journal_gives_no_number(tmp_path: Path) -> None:
    folder = CASE.copy("finished", tmp_path / "run")
    connection = sqlite3.connect(folder / "journal.sqlite")
    connection.execute("UPDATE dwells SET samples = zeroblob(length(samples)) WHERE number = 7")
    connection.commit()
    connection.close()
    with pytest.raises(JournalError, match=r"is not as it was written \(SHA-256 differs\)"):
        read_run(folder)


def test_where_no_run_is_a_sentence_says_so(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"no run is there: it holds no journal.sqlite; give the folder of a run"):
        read_run(str(tmp_path))


def test_a_run_is_found_by_its_journal_too(run: RunData) -> None:
    assert read_run(str(run.path / "journal.sqlite")).run == run.run


def test_the_views_of_the_page_give_the_dwells(run: RunData) -> None:
    block = re.search(r"```sql\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert block is not None
    connection = sqlite3.connect(f"file:{run.path / 'journal.sqlite'}?mode=ro", uri=True)
    connection.executescript(block[1])
    rows = connection.execute("SELECT dwell, replication, point, pitch_deg, roll_deg FROM dwell_view").fetchall()
    states = [row[0] for row in connection.execute("SELECT state FROM state_view ORDER BY sequence")]
    connection.close()
    table = run.dwells[["replication", "point", "pitch_deg", "roll_deg"]]
    assert rows == [tuple(row) for row in table.itertuples()]
    assert states[-1] == "finished"


def test_an_archived_run_is_read_where_its_journal_is_still_that_one(finished_job: FinishedJob, tmp_path: Path) -> None:
    url = f"sqlite:///{finished_job.run.parent / 'archive.sqlite'}"
    assert read_run(finished_job.run.name, archive=url).path == finished_job.run
    with pytest.raises(RequestError, match=r"other: the archive has no such run; nothing was read"):
        read_run("other", archive=url)
    copy = finished_job.copied_to(tmp_path)
    copied = copy.parent / "archive.sqlite"
    connection = sqlite3.connect(copied)
    connection.execute("UPDATE runs SET folder = ?", (str(copy),))
    connection.commit()
    connection.close()
    shutil.copy(CASE.folder / "finished" / "journal.sqlite", copy / "journal.sqlite")
    (copy / "journal.count").unlink()
    with pytest.raises(RequestError, match=r"is not the one that was archived; nothing was read"):
        read_run(copy.name, archive=f"sqlite:///{copied}")
    shutil.rmtree(copy)
    with pytest.raises(RequestError, match=r"its journal is no longer in .*; give the folder that it was moved to"):
        read_run(copy.name, archive=f"sqlite:///{copied}")
