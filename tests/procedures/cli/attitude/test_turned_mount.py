"""A package that sat turned on its fixture: the angles are the fixture's, which is said, or its own."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from command import call
from package_outputs import TRUTH, output_v

from ams.sets.canonical import render, with_checksum
from procedures.cli.results.coefficients_text import set_text

ON_ITS_BACK = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]
NOSE_RIGHT = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
"""Rows: the package's x, y, z along the axes of the fixture."""
BODY_DEG = [(10.0, 20.0), (-30.0, 100.0), (60.0, -150.0)]


def _mounted(stored: Path, rows: list[list[float]] | None) -> Path:
    """Return the set as one whose package was declared to sit so."""
    document = json.loads(stored.read_text())
    document["use"]["installation"]["fixture_to_package"] = rows
    stored.write_bytes(render(with_checksum(document)))
    return stored


def _outputs_at(rows: list[list[float]], path: Path) -> Path:
    """Write what a set in the fixture's axes reads while the package's own axes stand at ``BODY_DEG``."""
    lines = ["x_v,y_v,z_v"]
    for pitch, roll in np.deg2rad(BODY_DEG):
        own = np.array([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
        x, y, z = own @ np.array(rows)
        at = np.rad2deg(np.arcsin(x)), np.rad2deg(np.arctan2(-y, -z))
        lines.append(",".join(repr(output_v(axis, TRUTH[axis], *at)) for axis in "xyz"))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(("rows", "along"), [(ON_ITS_BACK, "+x, −y, −z"), (NOSE_RIGHT, "−y, +x, +z")])
def test_a_package_that_sat_turned_has_angles_of_its_own_and_its_set_says_whose_they_are(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: list[list[float]], along: str
) -> None:
    path = _outputs_at(rows, tmp_path / "own.csv")
    of_fixture = call(capsys, "attitude", _mounted(stored, rows), path)
    assert f"its own x, y, z along {along} of the fixture; of three axes --package-axes gives" in of_fixture.err
    own = call(capsys, "attitude", stored, path, "--package-axes")
    assert "of the fixture" not in own.err
    told = [(float(row["pitch_deg"]), float(row["roll_deg"])) for row in csv.DictReader(io.StringIO(own.out))]
    assert np.array(told) == pytest.approx(np.array(BODY_DEG), abs=1e-6)
    of_two = call(capsys, "attitude", stored, path, "--package-axes", "--axis", "x=x_v", "--axis", "y=y_v")
    assert (of_two.status, "turns three accelerometers" in of_two.err) == (2, True)


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        (None, "does not say how the package sat on its fixture"),
        ([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], "makes a left-handed package"),
    ],
)
def test_a_mount_that_tells_no_turn_is_refused_by_name(
    stored: Path, data: Path, capsys: pytest.CaptureFixture[str], rows: list[list[float]] | None, sentence: str
) -> None:
    refused = call(capsys, "attitude", _mounted(stored, rows), data, "--package-axes")
    assert (refused.status, sentence in refused.err, refused.out) == (2, True, "")


def test_what_does_not_go_with_the_packages_own_axes_is_refused(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    set_of_it = _mounted(stored, ON_ITS_BACK)
    for options in (("--alignment", tmp_path / "a.json"), ("--solve-alignment", tmp_path / "a.json")):
        refused = call(capsys, "attitude", set_of_it, data, "--package-axes", *options)
        assert (refused.status, "give one of the two" in refused.err) == (2, True)
    assert not (tmp_path / "a.json").exists()


def test_a_set_that_is_shown_says_whose_axes_its_directions_are_in(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    straight = set_text(json.loads(stored.read_text()), "engineering")
    assert "of the fixture" not in straight
    turned = set_text(json.loads(_mounted(stored, NOSE_RIGHT).read_text()), "engineering")
    assert "on which the package sat with its own x, y, z along −y, +x, +z of the fixture" in turned
