"""One and two axes have nothing that tests them: the g that is assumed, and outputs that are dead, are said."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command import call
from package_outputs import TRUTH, output_v
from solved_sets import tp_set

from ams.exports.formats import export_set

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
    assert "g is taken as 9.83000 m/s², as stated" in stated


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


def test_three_axes_test_themselves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "g is taken as" not in _told(tmp_path, capsys, "xyz")
