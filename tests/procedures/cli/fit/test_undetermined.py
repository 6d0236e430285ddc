"""Laws: attitudes that do not determine the sensor are told in a sentence, in whatever order the rows stand."""

from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from command import call
from package_outputs import write_observations

from ams.errors import AmsError

AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
COLUMNS = {"x": "sx_v", "y": "sy_v", "z": "sz_v"}
ONE_ROLL = (range(-60, 61, 20), [0])
ONE_PITCH = ([0], range(-180, 180, 45))
ONE_POINT = ([10], [20])
TWO_POINTS = ([10], [20, 40])


def in_another_order(path: Path, pitches: object, rolls: object, *, left_out: int = 0) -> Path:
    """Write three replications of quiet rows, each in an order of its own."""
    write_observations(path, pitches, rolls, 3)
    head, *rows = path.read_text().splitlines()
    size, order = len(rows) // 3, np.random.default_rng(1)
    blocks = [order.permutation(rows[i * size : (i + 1) * size]) for i in range(3)]
    path.write_text("\n".join([head, *(row for block in blocks for row in block)][: len(rows) + 1 - left_out]) + "\n")
    return path


@pytest.mark.parametrize("options", [(), ("--extended", "test")])
@pytest.mark.parametrize("left_out", [0, 1])
@pytest.mark.parametrize(
    ("angles", "words"),
    [
        (ONE_ROLL, "rank 3 of 4: the points cannot determine k_y_v_per_g: .*roll has one value only (0°)"),
        (ONE_PITCH, "rank 3 of 4: the points cannot determine k_x_v_per_g: pitch has one value only (0°)"),
    ],
)
def test_one_angle_that_never_moves_is_a_sentence_of_the_attitudes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], angles: tuple, words: str, left_out: int, options: tuple
) -> None:
    file = in_another_order(tmp_path / "few.csv", *angles, left_out=left_out)
    done = call(capsys, "fit", file, *AXES, *options)
    assert done.status == 2
    for part in words.split(".*"):
        assert part in done.err
    assert done.err.startswith(f"calrig: {file}: design: ")
    assert "nothing was solved; with one " in done.err


@pytest.mark.parametrize("angles", [ONE_POINT, TWO_POINTS])
def test_one_or_two_points_are_a_sentence_of_the_points(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], angles: tuple
) -> None:
    file = in_another_order(tmp_path / "few.csv", *angles)
    done = call(capsys, "fit", file, *AXES)
    assert done.status == 2
    assert "the points cannot determine" in done.err or "observations cannot determine 4 parameters" in done.err


@pytest.mark.parametrize("angles", [ONE_ROLL, ONE_PITCH, ONE_POINT, TWO_POINTS])
@pytest.mark.parametrize(("model", "package"), [("pitch-roll", None), ("pitch-yaw-roll", "model")])
def test_no_model_of_packages_ends_in_an_error_of_the_algebra(
    tmp_path: Path, angles: tuple, model: str, package: str | None
) -> None:
    rows = pd.read_csv(in_another_order(tmp_path / "few.csv", *angles)).assign(yaw_deg=0.0)
    with pytest.raises(AmsError, match=r"nothing was solved"):
        calrig.fit(rows, COLUMNS, model=model, package=package)


@pytest.mark.parametrize(
    ("rates", "words"), [(((-10, 0, 10), (-5, 5), (0,)), "rank 3 of 4"), (((10,), (0,), (0,)), "determine")]
)
def test_gyros_that_were_not_turned_about_all_axes_are_told_so_in_any_order(rates: tuple, words: str) -> None:
    points = [(p, y, r) for p in rates[0] for y in rates[1] for r in rates[2]]
    rows = [
        {"replication": n, "point": points.index((p, y, r)), "pitch_deg": 0, "yaw_deg": 0, "roll_deg": 0,
         "pitch_rate_dps": p, "yaw_rate_dps": y, "roll_rate_dps": r, "gx_v": 0.01 * r + 1e-5 * p * n}
        for n in (1, 2, 3)
        for p, y, r in np.random.default_rng(n).permutation(points).tolist()
    ]  # fmt: skip
    with pytest.raises(AmsError, match=words):
        calrig.fit(pd.DataFrame(rows), {"x": "gx_v"}, model="gyro")


def test_a_table_without_rows_has_the_sentence_of_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = in_another_order(tmp_path / "empty.csv", *ONE_POINT, left_out=3)
    done = call(capsys, "fit", file, *AXES)
    assert done.status == 2
    said = done.err.partition("empty.csv: ")[2].strip()
    assert said == "a header and no rows; nothing was solved; export the rows again"
    for table in (pd.read_csv(file), pd.read_csv(file).assign(yaw_deg=[])):
        with pytest.raises(AmsError) as refusal:
            calrig.fit(table, COLUMNS)
        assert str(refusal.value) == f"table: {said}"
    with pytest.raises(AmsError, match="no header and no rows"):
        calrig.fit(pd.DataFrame(), COLUMNS)
