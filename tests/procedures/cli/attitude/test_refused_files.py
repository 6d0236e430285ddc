"""What ``calrig attitude`` and ``calrig fit`` say of a file that they cannot read is true of themselves."""

import re
from pathlib import Path

import h5py
import pandas as pd
import pytest
from command import call
from package_outputs import TRUTH, output_v


@pytest.fixture
def data(tmp_path: Path) -> Path:
    path = tmp_path / "data.csv"
    rows = ["replication,point,pitch_deg,roll_deg,x_v,y_v,z_v"]
    for point, pitch in enumerate((-35.0, 5.0, 60.0)):
        volts = ",".join(repr(output_v(axis, TRUTH[axis], pitch, 20.0)) for axis in "xyz")
        rows.append(f"1,{point},{pitch},20.0,{volts}")
    path.write_text("\n".join(rows) + "\n")
    return path


UNREADABLE = {
    "semicolons": lambda text: text.replace(",", ";"),
    "tabs": lambda text: text.replace(",", "\t"),
    "a column": lambda text: text.replace("y_v", "w_v"),
    "a column twice": lambda text: text.replace("y_v", "x_v"),
    "a cell too many": lambda text: text + "1,3,0,0,1,1,1,1\n",
    "a NUL": lambda text: text + "1,3,0,\0,1,1,1\n",
    "nothing": lambda text: "",
    "no rows": lambda text: text.splitlines()[0] + "\n",
    "a quote": lambda text: text + '1,3,0,0,"1,1,1\n',
}
OPTION = re.compile(r"--[a-z][a-z-]+")


@pytest.mark.usefixtures("wide_terminal")
@pytest.mark.parametrize("what", UNREADABLE)
@pytest.mark.parametrize("command", ["attitude", "fit", "alignment"])
def test_a_refusal_names_options_of_the_command_that_refuses_and_says_what_was_not_done(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, what: str
) -> None:
    data.write_text(UNREADABLE[what](data.read_text()))
    asked = {
        "attitude": ("attitude", stored, data),
        "fit": ("fit", data, *(f"--axis={axis}={axis}_v" for axis in "xyz")),
        "alignment": ("attitude", stored, data, "--solve-alignment", tmp_path / "alignment.json"),
    }[command]
    outcome = call(capsys, *asked)
    assert outcome.status == 2
    assert ("nothing was solved" if command == "fit" else "nothing was computed") in outcome.err
    known = set(OPTION.findall(call(capsys, asked[0], "--help").out))
    assert set(OPTION.findall(outcome.err)) <= known
    assert set(re.findall(r"calrig (\w+)", outcome.err)) <= {asked[0]}


@pytest.mark.parametrize("ending", ["parquet", "h5"])
def test_a_column_that_a_binary_file_lacks_is_named_with_the_options_that_name_it(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    rows, path = pd.read_csv(data), tmp_path / f"data.{ending}"
    if ending == "parquet":
        rows.rename(columns={"y_v": "w_v"}).to_parquet(path)
    else:
        with h5py.File(path, "w") as file:
            for column in rows.columns:
                file[column.replace("y_v", "w_v")] = rows[column].to_numpy()
    outcome = call(capsys, "attitude", stored, path)
    assert outcome.status == 2
    assert "y_v missing; found:" in outcome.err
    assert "w_v" in outcome.err
    assert "nothing was computed" in outcome.err
    assert "--axis AXIS=COLUMN" in outcome.err
