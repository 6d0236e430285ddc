"""A file with a temperature that no sensor stands: the row has the flag and no angle, and the end says the unit."""

import csv
from pathlib import Path

import numpy as np
import pytest
from command import call
from foreign_sets import bending

from ams.exports.formats import export_set
from ams.sets.apply import apply


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
