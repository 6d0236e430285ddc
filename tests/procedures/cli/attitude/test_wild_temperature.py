"""A file with a temperature that no sensor stands: the row has the flag and no angle, and the end says the unit."""

import csv
from pathlib import Path

import numpy as np
import pytest
from command import call
from foreign_sets import bending
from solved_sets import tp_set

from ams.exports.formats import export_set
from ams.sets.apply import apply
from ams.sets.canonical import table, with_checksum
from ams.sets.coefficients import from_document


def test_a_file_has_the_flag_in_its_row_and_the_likely_unit_at_its_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stored, data, out = (tmp_path / name for name in ("set.json", "data.csv", "out.csv"))
    export_set(bending(), "json", stored)
    outputs = apply(bending(), np.deg2rad(10.0), np.deg2rad(15.0), 30.0)
    columns = {f"{axis}_v": np.full(9, outputs[axis]) for axis in "xyz"}
    columns["temperature_degc"] = np.where(np.arange(9) == 7, 303.15, 30.0)
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    data.write_text("\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n")
    said = call(capsys, "attitude", stored, data, "--out", out).err
    with out.open(newline="") as answers:
        told = list(csv.DictReader(answers))
    assert [
        index for index, row in enumerate(told) if "temperature that no sensor stands: taken as missing" in row["flag"]
    ] == [7]
    assert told[7]["pitch_deg"] == ""
    assert float(told[6]["pitch_deg"]) == pytest.approx(10.0, abs=1e-6)
    assert "1 row has one that no sensor stands" in said
    assert "the numbers look like kelvin" in said


@pytest.mark.parametrize(
    ("told", "said"),
    [(None, "none of the 9 rows has"), ("some", "2 of 9 rows lack"), ("all", None)],
)
def test_the_end_says_of_how_many_rows_no_temperature_was_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], told: str | None, said: str | None
) -> None:
    """Without the column nothing was said: angles at 60 °C looked as good as those of the calibration's day."""
    still = tp_set()
    ranges = {**table(still.document["validity"]), "temperature_degc": [21.0, 23.0]}
    still = from_document(with_checksum({**still.document, "validity": ranges}), "TP1")
    stored, data, out = (tmp_path / name for name in ("set.json", "data.csv", "out.csv"))
    export_set(still, "json", stored)
    outputs = apply(still, np.deg2rad(10.0), np.deg2rad(15.0))
    columns = {f"{axis}_v": [f"{float(outputs[axis])!r}"] * 9 for axis in "xyz"}
    if told is not None:
        columns["temperature_degc"] = [*["22.0"] * 7, *(["", ""] if told == "some" else ["22.0", "22.0"])]
    data.write_text("\n".join([",".join(columns), *map(",".join, zip(*columns.values(), strict=True))]) + "\n")
    read = call(capsys, "attitude", stored, data, "--out", out).err
    sentence = "a temperature (temperature_degc): whether the sensor was used at another"
    assert (sentence in read) == (said is not None)
    if said is not None:
        assert f"TP1: valid at 21 to 23 °C; {said} {sentence}" in read
