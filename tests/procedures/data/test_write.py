"""What ``calrig data`` writes, read back by the readers that people use: not a bit of a number is lost."""

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray
from command import call
from stored_runs import CASES

from procedures.data.columns import DATA_VERSION, TABLES
from procedures.data.run_data import RunData, read_run
from procedures.data.write import FORMATS, write_tables

Read = Callable[[Path, str], pd.DataFrame]
RUNS = {case.folder.name: case for case in CASES}


@pytest.fixture(scope="module", params=["grid", "rates_gyro"])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> RunData:
    return read_run(RUNS[request.param].copy("finished", tmp_path_factory.mktemp("write") / "run"))


def from_csv(folder: Path, name: str) -> pd.DataFrame:
    texts = {table.name: "str" for table in TABLES[name] if table.kind == "str"}
    empty = {table.name: [""] for table in TABLES[name] if table.kind == "float64"}
    table = pd.read_csv(folder / f"{name}.csv", dtype=texts, keep_default_na=False, na_values=empty)
    return table if name == "events" else table.set_index("dwell")


def from_parquet(folder: Path, name: str) -> pd.DataFrame:
    return pd.read_parquet(folder / f"{name}.parquet")


def from_hdf5(folder: Path, name: str) -> pd.DataFrame:
    with h5py.File(folder / "run.h5") as file:
        assert file.attrs["calrig_data_version"] == DATA_VERSION
        columns = {
            column: data.asstr()[()] if h5py.check_string_dtype(data.dtype) else data[()]
            for column, data in file[name].items()
        }
    table = pd.DataFrame(columns)
    return table if name == "events" else table.set_index("dwell")


READERS: dict[str, Read] = {"csv": from_csv, "parquet": from_parquet, "hdf5": from_hdf5}


@pytest.mark.parametrize("kind", READERS)
def test_what_is_read_back_is_what_was_there(run: RunData, kind: str, tmp_path: Path) -> None:
    write_tables(run, kind, tmp_path, with_samples=True)
    tables = {"dwells": run.dwells, "readings": run.readings, "events": run.events, "samples": run.samples()}
    for name, table in tables.items():
        found = READERS[kind](tmp_path, name)
        for column in TABLES[name]:
            values = found[column.name]
            if column.kind.startswith("datetime"):
                values = pd.to_datetime(values, utc=True, format="ISO8601")
            np.testing.assert_array_equal(values.to_numpy(), table[column.name].to_numpy(), f"{name} {column.name}")
        assert found.index.tolist() == table.index.tolist()
        assert list(found.columns) == list(table.columns) or kind == "hdf5"


def test_a_dataset_holds_the_same_over_dwell_and_channel(run: RunData, tmp_path: Path) -> None:
    write_tables(run, "xarray", tmp_path, with_samples=True)
    with xarray.open_dataset(tmp_path / "run.nc") as found:
        assert found.attrs["calrig_data_version"] == DATA_VERSION
        for row in run.readings.itertuples():
            location = {"dwell": row.Index, "channel": row.channel}
            for figure in ("mean", "sd", "n"):
                np.testing.assert_array_equal(found[figure].sel(location).item(), getattr(row, figure))
        values = found["value"].to_numpy()
        assert values[np.isfinite(values)].tolist() == run.samples()["value"].tolist()
        assert found["pitch_deg"].to_numpy().tolist() == run.dwells["pitch_deg"].tolist()
        assert found["accepted"].to_numpy().all()


def test_every_format_of_the_command_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Beside the run where no folder is given; the latest run where none is named."""
    folder = RUNS["tumble"].copy("finished", tmp_path / "runs" / "a-run")
    for kind in FORMATS:
        outcome = call(capsys, "data", "--runs", tmp_path / "runs", "--to", kind, "--json")
        assert outcome.status == 0, outcome.err
        assert outcome.document["run"] == str(folder)
        assert outcome.document["version"] == DATA_VERSION
        assert [Path(file).is_file() for file in outcome.document["files"]] == [True] * len(outcome.document["files"])
        assert outcome.document["rows"]["dwells"] == len(read_run(folder).dwells)
    described = json.loads((folder / "data" / "columns.json").read_text(encoding="utf-8"))
    assert [table["name"] for table in described["tables"]["readings"]] == [table.name for table in TABLES["readings"]]
    assert not (folder / "data" / "samples.csv").exists()


def test_the_command_makes_its_folder_and_says_what_it_wrote(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = RUNS["tumble"].copy("interrupted", tmp_path / "run")
    outcome = call(capsys, "data", folder, "--samples", "--out", tmp_path / "new")
    assert outcome.status == 0
    names = ["dwells.csv", "readings.csv", "events.csv", "samples.csv", "columns.json"]
    assert outcome.out.splitlines() == [str(tmp_path / "new" / name) for name in names]


def test_a_run_of_the_archive_must_be_named(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "data", "--archived")
    assert (outcome.status, "RUN is missing" in outcome.err) == (2, True)


def test_an_archive_belongs_to_an_archived_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = RUNS["tumble"].copy("interrupted", tmp_path / "run")
    outcome = call(capsys, "data", folder, "--archive", "sqlite:///elsewhere.sqlite", "--out", tmp_path / "new")
    assert outcome.status == 2
    assert "--archive: belongs to --archived, which is missing; nothing was written" in outcome.err
    assert not (tmp_path / "new").exists()
