"""Rows in which an output of one or two axes stands at a rail have no angle, and the sentence says which."""

import csv
from pathlib import Path

import numpy as np
import pytest
from command import call
from package_outputs import TRUTH, output_v
from solved_sets import tp_set

from ams.exports.formats import export_set

ROWS, SD_V, RAIL_V = 600, 2e-5, 1.5


def _written(tmp_path: Path, axes: str) -> tuple[Path, Path, np.ndarray, np.ndarray]:
    """Return a set, data of a swept package whose x cannot leave its rails, which rows are at one, and the pitch."""
    rows, chance = np.arange(ROWS), np.random.default_rng(4)
    pitch, roll = 45.0 * np.sin(2.0 * np.pi * rows / 61.0), 10.0 * np.sin(2.0 * np.pi * rows / 97.0)
    true_v = {axis: [output_v(axis, TRUTH[axis], *at) for at in zip(pitch, roll, strict=True)] for axis in axes}
    read = {axis: np.array(values) + SD_V * chance.standard_normal(ROWS) for axis, values in true_v.items()}
    read["x"] = np.clip(read["x"], -RAIL_V, RAIL_V)
    at_rail = np.abs(read["x"]) == RAIL_V
    assert 100 < np.count_nonzero(at_rail) < 300
    data, stored = tmp_path / "data.csv", tmp_path / "tp.json"
    header = ",".join([*(f"{axis}_v" for axis in axes), "roll_deg"])
    np.savetxt(data, np.column_stack([*read.values(), roll]), fmt="%.7f", delimiter=",", header=header, comments="")
    export_set(tp_set(), "json", stored)
    return stored, data, at_rail, pitch


def _named(axes: str) -> list[str]:
    return [part for axis in axes for part in ("--axis", f"{axis}={axis}_v")]


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_no_row_at_a_rail_has_an_angle_and_all_others_have_theirs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str
) -> None:
    stored, data, at_rail, pitch = _written(tmp_path, axes)
    out = tmp_path / "a.csv"
    said = call(capsys, "attitude", stored, data, *_named(axes), "--reading-sd-v", SD_V, "--out", out).err
    with out.open() as file:
        answers = list(csv.DictReader(file))
    is_told = ["output clipped at a rail: taken as missing" in row["flag"] for row in answers]
    assert np.array_equal(is_told, at_rail)
    assert all((row["pitch_deg"] == "") == told for row, told in zip(answers, is_told, strict=True))
    angles = [float(row["pitch_deg"]) for row in answers if row["pitch_deg"]]
    assert np.abs(angles - pitch[~at_rail]).max() < 0.02
    assert "x_v stands at 1.5 V in " in said
    assert "x_v stands at -1.5 V in " in said
    assert said.count("they are taken as missing") == 2


def test_an_average_over_rows_at_a_rail_says_what_is_left(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stored, data, at_rail, _ = _written(tmp_path, "xy")
    out = tmp_path / "a.csv"
    call(
        capsys, "attitude", stored, data, *_named("xy"), "--reading-sd-v", SD_V, "--average-s", "0.05", "--rate-hz",
        "100", "--out", out,
    )  # fmt: skip
    with out.open() as file:
        flags = [row["flag"] for row in csv.DictReader(file)]
    assert np.array_equal(["readings missing" in flag or "clipped" in flag for flag in flags], _any_of_five(at_rail))


def _any_of_five(rows: np.ndarray) -> np.ndarray:
    return np.asarray(rows.reshape(-1, 5).any(axis=1))


def test_three_axes_are_told_by_one_another(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What tests every row is left to tell it: the angles stand beside the flag."""
    stored, data, at_rail, _ = _written(tmp_path, "xyz")
    out = tmp_path / "a.csv"
    said = call(capsys, "attitude", stored, data, *_named("xyz"), "--reading-sd-v", SD_V, "--out", out).err
    assert "taken as missing" not in said
    with out.open() as file:
        flags = [row["flag"] for row in csv.DictReader(file)]
    assert sum("suspect x" in flag for flag in flags) > 0.9 * np.count_nonzero(at_rail)
