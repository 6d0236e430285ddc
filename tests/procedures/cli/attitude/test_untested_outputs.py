"""One and two axes have nothing that tests them: the g that is assumed, and outputs that are dead, are said."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command import call
from cr_outputs import TABLE_4, gyro_v
from package_outputs import TRUTH, output_v
from solved_sets import gyro_set, tp_set

from ams.exports.formats import export_set
from ams.sets.canonical import with_checksum
from ams.sets.coefficients import from_document
from ams.sets.verdict_conditions import (
    CUBIC_BEND_UNDETERMINED,
    CURVATURE_UNDETERMINED,
    REFERENCE_NOT_MEASURED,
    TERMS_NOT_DETERMINED,
)

ROWS = 40


def _told(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    axes: str,
    change: Callable[[str, float], float] = lambda _, value: value,
    *options: str,
) -> str:
    chance = np.random.default_rng(2)
    attitudes = zip(chance.uniform(-60.0, 60.0, ROWS), chance.uniform(-60.0, 60.0, ROWS), strict=True)
    rows = [
        [*(change(axis, float(output_v(axis, TRUTH[axis], p, r))) for axis in axes), float(r)] for p, r in attitudes
    ]
    data, stored = tmp_path / "data.csv", tmp_path / "tp.json"
    header = ",".join([*(f"{axis}_v" for axis in axes), "roll_deg"])
    data.write_text(header + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    export_set(tp_set(), "json", stored)
    named = [part for axis in axes for part in ("--axis", f"{axis}={axis}_v")]
    return call(capsys, "attitude", stored, data, *named, *options, "--out", tmp_path / "a.csv").err


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_one_and_two_axes_say_the_g_and_that_nothing_tests_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str
) -> None:
    said = _told(tmp_path, capsys, axes)
    assert "that of the calibration" in said
    assert "nothing in the rows tests it" in said
    assert "in all" not in said
    stated = _told(tmp_path, capsys, axes, lambda _, value: value, "--gravity-mps2", "9.83")
    assert "g is taken as 9.83000 m/s², as stated, with no uncertainty: --gravity-uncertainty-mps2" in stated
    site = ("--gravity-mps2", "9.83", "--gravity-uncertainty-mps2", "5e-4")
    declared = _told(tmp_path, capsys, axes, lambda _, value: value, *site)
    assert "g is taken as 9.83000 m/s², as stated, standard uncertainty 0.0005 m/s²" in declared


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_an_output_that_never_changes_and_one_at_its_offset_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str
) -> None:
    offset_v, chance = TRUTH["x"][0], np.random.default_rng(5)
    stuck = _told(tmp_path, capsys, axes, lambda axis, value: 0.3 if axis == "x" else value)
    assert f"x_v is the same number in all {ROWS} rows" in stuck
    assert "y_v is" not in stuck
    dead = _told(
        tmp_path, capsys, axes,
        lambda axis, value: offset_v + 1e-5 * chance.standard_normal() if axis == "x" else value,
        "--reading-sd-v", "1e-5",
    )  # fmt: skip
    assert f"x_v lies at its offset in all {ROWS} rows" in dead


@pytest.mark.parametrize("axes", ["x", "xy"])
@pytest.mark.parametrize("is_swept", [False, True])
def test_no_row_of_an_output_that_hangs_while_the_package_moves_has_an_angle(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str, *, is_swept: bool
) -> None:
    rows, sd_v, chance = np.arange(600), 2e-5, np.random.default_rng(4)
    pitch = 35.0 * np.sin(rows / 600.0 * 14.5) if is_swept else 0.05 * rows - 30.0
    roll = 20.0 * np.sin(rows / 600.0 * 6.3) if is_swept else np.zeros(rows.size)
    true_v = {axis: [output_v(axis, TRUTH[axis], *at) for at in zip(pitch, roll, strict=True)] for axis in axes}
    read = {axis: np.array(values) + sd_v * chance.standard_normal(rows.size) for axis, values in true_v.items()}
    read["x"][200:320] = read["x"][200]
    data, stored, out = tmp_path / "data.csv", tmp_path / "tp.json", tmp_path / "a.csv"
    table = np.column_stack([*read.values(), roll])
    header = ",".join([*(f"{axis}_v" for axis in axes), "roll_deg"])
    np.savetxt(data, table, fmt="%.7f", delimiter=",", header=header, comments="")
    export_set(tp_set(), "json", stored)
    named = [part for axis in axes for part in ("--axis", f"{axis}={axis}_v")]
    said = call(capsys, "attitude", stored, data, *named, "--reading-sd-v", sd_v, "--out", out).err
    with out.open() as file:
        answers = list(csv.DictReader(file))
    assert all(row["pitch_deg"] == "" and "output frozen" in row["flag"] for row in answers[201:320])
    assert not any("output frozen" in row["flag"] for row in answers[:201] + answers[320:])
    assert "x_v repeats one number in 119 rows" in said


TELLS = {
    f"{TERMS_NOT_DETERMINED} and so on": "its calibration tells no terms of second and third order",
    f"{REFERENCE_NOT_MEASURED}: and so on": "its calibration tells no curvature over temperature",
    f"{CURVATURE_UNDETERMINED}: and so on": "its calibration tells no curvature over temperature",
    f"{CUBIC_BEND_UNDETERMINED}: and so on": "it was calibrated at three temperatures",
}


@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
@pytest.mark.parametrize("stated", ["", *TELLS])
def test_what_a_calibration_does_not_tell_is_said_where_its_set_is_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, axes: str, stated: str
) -> None:
    """Of terms of second and third order no more where a third axis tests the row."""
    plain = tp_set().document
    content = {key: value for key, value in plain.items() if key != "checksum"}
    remarked = with_checksum({**content, "warnings": [stated], "remarks": []} if stated else content)
    monkeypatch.setattr(f"{__name__}.tp_set", lambda: from_document(remarked, "set"))
    said = _told(tmp_path, capsys, axes)
    for beginning, sentence in TELLS.items():
        is_flagged = beginning.startswith(TERMS_NOT_DETERMINED) and axes == "xyz"
        assert (sentence in said) == (TELLS.get(stated) == sentence and not is_flagged)


def test_three_axes_test_themselves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "g is taken as" not in _told(tmp_path, capsys, "xyz")


@pytest.mark.parametrize(
    ("axes", "option"), [("xyz", "--no-upright"), ("xz", "--no-upright"), ("xy", "--no-right-wing-down")]
)
def test_a_side_that_a_package_has_no_two_of_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str, option: str
) -> None:
    said = _told(tmp_path, capsys, axes, lambda _, value: value, option)
    assert f"{option}: belongs to a package of x and" in said
    assert f"got {', '.join(axes)}" in said


def test_two_axes_are_not_read_from_one_column(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A slip of the pen that no row shows: two axes have an attitude for nearly every pair of numbers."""
    said = _told(tmp_path, capsys, "x", lambda _, value: value, "--axis", "z=x_v")
    assert "--axis z=x_v: x_v is read for another axis already" in said


def test_without_x_the_sign_of_pitch_is_said_to_be_open(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "without x the sign of pitch is not told" in _told(tmp_path, capsys, "yz")


def test_gyros_alone_say_what_is_taken_for_granted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The start, the Earth's turn and how the rate runs are in no standard deviation; said is what was not stated."""
    said = _told_of_gyros(tmp_path, capsys, 0.0)
    assert "the start is taken as pitch 0°, yaw 0°, roll 0°, known exactly" in said
    assert "the Earth's turn" in said
    stated = ("--start-deg", "0", "0", "5", "--start-sd-deg", "0.1", "--latitude-deg", "37", "--heading-deg", "90")
    said = _told_of_gyros(tmp_path, capsys, 0.0, *stated, "--interpolation", "hold")
    assert "the start is" not in said
    assert "the Earth's turn" not in said
    assert "--interpolation hold: what it makes wrong is in no standard deviation" in said


@pytest.mark.parametrize(("swing_dps", "is_still"), [(0.0, True), (20.0, False)])
def test_a_rest_that_was_none_is_told_and_its_zero_is_no_zero(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing_dps: float, is_still: bool
) -> None:
    """Turned to and fro over the rest: the angles behind it are withheld, where they were plausible and wrong."""
    said = _told_of_gyros(tmp_path, capsys, swing_dps, "--rest-s", "5")
    assert "°/s from the zeros of the calibration" in said
    assert ("it did not rest" in said) != is_still
    last = (tmp_path / "a.csv").read_text().splitlines()[-1]
    assert ("attitude unknown: grown uncertain" in last) != is_still


@pytest.mark.parametrize(
    ("step_v", "said"),
    [
        (1e-5, "x_v is the same number in all 2000 rows: a dead axis"),
        (0.0, "at rest: got 1 readings of all three axes in 500 rows (1 of x_v, 500 of y_v, 500 of z_v)"),
    ],
)
def test_a_gyro_that_hangs_from_the_first_row_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], step_v: float, said: str
) -> None:
    """Its last number is taken as its zero, so that the roll of 22° that the others know nothing of is none."""
    assert said in _told_of_gyros(tmp_path, capsys, 20.0, "--rest-s", "5", step_v=step_v, hangs=True)
    assert "is the same number" not in _told_of_gyros(tmp_path, capsys, 20.0, step_v=step_v)


def _told_of_gyros(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    swing_dps: float,
    *options: str,
    step_v: float = 0.0,
    hangs: bool = False,
) -> str:
    """Roll to and fro through a period of 7 s, 20 s at 100 Hz, as CR's gyros read it by explicit rotations.

    Read in steps of a meter; with one that ``hangs`` x reads its first number from the first row on.
    """
    data, stored, chance = tmp_path / "gyro.csv", tmp_path / "gyro.json", np.random.default_rng(4)
    export_set(gyro_set(), "json", stored)
    rows = []
    for step in range(2000):
        phase = 2 * np.pi * step / 700.0
        roll_deg, rate_dps = 7.0 * swing_dps / (2 * np.pi) * np.sin(phase), swing_dps * np.cos(phase)
        read = [gyro_v(axis, TABLE_4[axis], (0.0, 0.0, roll_deg), (0.0, 0.0, rate_dps)) for axis in "xyz"]
        read = [float(value + 1e-6 * chance.standard_normal()) for value in read]
        rows.append([step_v * round(value / step_v) if step_v else value for value in read])
    for row in rows[1:] if hangs else []:
        row[0] = rows[0][0]
    data.write_text("x_v,y_v,z_v\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    given = ("--rate-hz", "100", "--reading-sd-v", "1e-6", *options)
    return call(capsys, "attitude", stored, data, *given, "--out", tmp_path / "a.csv").err


@pytest.mark.parametrize("order", ["xyz", "zxy"])
def test_the_axis_at_fault_is_named_after_the_last_row_and_in_every_flag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], order: str
) -> None:
    said = _told(tmp_path, capsys, order, lambda axis, value: 0.0 if axis == "x" else value, "--reading-sd-v", "1e-5")
    assert "x is the faulty axis: it stands at 0 V while the others move" in said
    flags = {line.rpartition(",")[2] for line in (tmp_path / "a.csv").read_text().splitlines()[1:]}
    assert {flag.rpartition("redundancy: ")[2] for flag in flags if flag} == {"suspect x"}


def test_outputs_that_are_all_high_accuse_no_axis(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = _told(tmp_path, capsys, "xyz", lambda _, value: 1.02 * value, "--reading-sd-v", "1e-5")
    assert "all outputs are wrong alike" in said
    assert "1.02 ± " in said
    assert "suspect" not in said + (tmp_path / "a.csv").read_text()


def test_rows_that_agree_say_nothing_of_axes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "faulty" not in _told(tmp_path, capsys, "xyz", lambda _, value: value, "--reading-sd-v", "1e-5")


def test_two_axes_at_fault_are_told_as_what_cannot_be_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = _told(
        tmp_path, capsys, "xyz", lambda axis, value: 0.1 if axis == "x" else 1.1 * value, "--reading-sd-v", "1e-5"
    )
    assert "cannot be named" in said


@pytest.mark.parametrize("is_exact", [False, True])
def test_an_axis_that_is_unplugged_in_some_rows_is_flagged_in_these(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], *, is_exact: bool
) -> None:
    rows, sd_v, chance = np.arange(600), 2e-5, np.random.default_rng(4)
    pitch, roll = 35.0 * np.sin(rows / 41.0), 20.0 * np.sin(rows / 95.0)
    read = {
        axis: np.array([output_v(axis, TRUTH[axis], *at) for at in zip(pitch, roll, strict=True)])
        + sd_v * chance.standard_normal(rows.size)
        for axis in "xy"
    }
    read["y"][200 : 220 if is_exact else 320] = TRUTH["y"][0]
    read["y"][200:320] += 0.0 if is_exact else sd_v * chance.standard_normal(120)
    data, stored, out = tmp_path / "data.csv", tmp_path / "tp.json", tmp_path / "a.csv"
    np.savetxt(data, np.column_stack([*read.values()]), fmt="%.7f", delimiter=",", header="x_v,y_v", comments="")
    export_set(tp_set(), "json", stored)
    named = ("--axis", "x=x_v", "--axis", "y=y_v", "--reading-sd-v", sd_v)
    said = call(capsys, "attitude", stored, data, *named, "--out", out).err
    last = 220 if is_exact else 320
    with out.open() as file:
        flags = [row["flag"] for row in csv.DictReader(file)]
    assert all("y lies at its zero though the package moves" in flag for flag in flags[200:last])
    assert not any("lies at its zero" in flag for flag in flags[:200] + flags[last:])
    assert f"y_v lies at its offset in rows 201 to {last} and has nothing of" in said
    assert "the rows are flagged" in said
