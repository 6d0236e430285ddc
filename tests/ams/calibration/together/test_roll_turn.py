"""A package that turns on its mount with the angle of roll is named as that, and neither sensor nor squareness is."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes import campaigns
from physics_scenes.rotations import ARCSEC
from solved_campaigns import columns_of, rows_of, solved

from ams.calibration.calibrate import calibrate
from ams.calibration.output.believed import evidence_of
from ams.calibration.together.roll_turn import judge_roll_turn
from ams.calibration.together.roll_turn_found import RollTurn
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
SHARE = 0.05 / 38.0
ABOUT = np.array([0.3, -0.6, 0.742])
"""x, y and z of the package: of unit length."""
NOISE_RAD = 1.65 * ARCSEC
SENSITIVITY = np.array([[2.5, 0.01, 0.02], [-0.015, 2.48, 0.012], [0.02, -0.011, 2.52]])
"""V/g: of x, y and z along x, y and z."""
ROLL_DEG = np.arange(-180.0, 180.0, 30.0)


def _measured(seed: int, turn_arcsec: FloatArray, added: str = "", size: float = 0.0) -> Observations:
    """Return 13 × 12 points in six replications, there and back, the package turned by t R/360° at roll R."""
    rng = np.random.default_rng(seed)
    pitches = [*range(0, 13, 2), *range(11, 0, -2)]
    there = np.array([(15 * p - 90, r) for row, p in enumerate(pitches) for r in ROLL_DEG[:: (-1) ** row]])
    pitch, roll = np.deg2rad(np.tile(there, (6, 1))).T
    cosine = np.cos(pitch)
    force = np.stack([np.sin(pitch), -cosine * np.sin(roll), -cosine * np.cos(roll)], axis=1)
    felt = force - (roll / (2.0 * np.pi))[:, None] * np.cross(turn_arcsec * ARCSEC, force)
    if added == "squareness":
        felt = felt + size * ARCSEC * np.sin(pitch)[:, None] * np.stack([0 * roll, np.cos(roll), -np.sin(roll)], axis=1)
    output = 0.005 + felt @ SENSITIVITY.T + 2.5 * NOISE_RAD * rng.normal(size=force.shape)
    if added == "K2 of x":
        output[:, 0] += 2.5e-6 * size * force[:, 0] ** 2
    if added == "index of pitch":
        pitch_by = np.stack([cosine, np.sin(pitch) * np.sin(roll), np.sin(pitch) * np.cos(roll)], axis=1)
        output += size * ARCSEC * np.sin(3.0 * pitch)[:, None] * (pitch_by @ SENSITIVITY.T)
    points = np.tile(np.arange(len(there)), 6)
    outputs = dict(zip("xyz", output.T, strict=True))
    return Observations(
        np.repeat(np.arange(6), len(there)),
        points,
        pitch,
        roll,
        outputs,
        time_s=np.arange(0.0, 30.0 * points.size, 30.0),
    )


def _told(rows: Observations, axes: str = "xyz") -> list[Finding]:
    seen = replace(rows, outputs={axis: rows.outputs[axis] for axis in axes})
    found = calibrate(seen, CalibrationRequest())
    return [finding for axis in found.axes.values() for finding in axis.findings if finding.is_significant]


@pytest.mark.parametrize("size", [10.0, 40.0])
def test_a_package_that_turns_with_roll_is_told_by_how_much_and_about_what(size: float) -> None:
    """K₂ of −67 µV/g² and a table out of square by 3″ were told of a perfect table and perfect sensors."""
    for seed in range(3):
        told = _told(_measured(seed, size * ABOUT))
        assert [finding.kind for finding in told] == ["table-rotation"] * 3
        details = told[0].details
        away = float(details["turn_with_roll_arcsec"] or 0.0) - size
        assert abs(away) < 4.0 * float(details["standard_uncertainty_arcsec"] or 0.0)
        about = np.array([float(details[f"turn_about_{axis}_arcsec"] or 0.0) for axis in "xyz"])
        assert about[1:] == pytest.approx(size * ABOUT[1:], abs=2.0)
        assert not any(finding.is_held for finding in told)


def test_a_curvature_beside_the_turn_is_told_too() -> None:
    kinds = {finding.kind for finding in _told(_measured(4, 20.0 * ABOUT, "K2 of x", 60.0))}
    assert kinds == {"table-rotation", "quadratic"}


@pytest.mark.parametrize(
    ("added", "size", "kind"),
    [("K2 of x", 40.0, "quadratic"), ("squareness", 10.0, "lack-of-fit"), ("index of pitch", 10.0, "lack-of-fit")],
)
def test_what_a_sensor_or_the_table_does_is_not_named_a_turn_with_roll(added: str, size: float, kind: str) -> None:
    for seed in range(3):
        kinds = {finding.kind for finding in _told(_measured(seed, np.zeros(3), added, size))}
        assert kind in kinds
        assert "table-rotation" not in kinds


def test_a_turn_that_one_output_shows_alone_may_be_of_that_output() -> None:
    """About z of the package z sees nothing of it; about y both x and z do."""
    for about, axes, is_lone in (([0.0, 0.0, 10.0], "yz", True), ([0.0, 10.0, 0.0], "xz", False)):
        told = [found for found in _told(_measured(8, np.array(about)), axes) if found.kind == "table-rotation"]
        assert len(told) == 2
        assert all(("or it is of y alone" in found.fact) is is_lone for found in told)
        assert all(("confounded_with" in found.details) is is_lone for found in told)


def test_a_package_of_one_axis_is_not_asked() -> None:
    assert not any(finding.kind == "table-rotation" for finding in _told(_measured(1, 20.0 * ABOUT), axes="y"))


def test_what_settles_as_rows_begin_is_not_named_a_turn_with_roll() -> None:
    """Means of the points alone show a turn in 33 of 40 of these; the replications show what it is."""
    drawn = campaigns(
        "drift-settling", 20.0, np.random.default_rng(21), 3, order="there-and-back", sensors=1, reference_every=0
    )
    for index in range(3):
        outputs = {axis: columns_of(drawn, axis)[:, index] for axis in "xyz"}
        kinds = {finding.kind for finding in _told(replace(rows_of(drawn), outputs=outputs))}
        assert "drift" in kinds
        assert "table-rotation" not in kinds


def _turns(scene: str, size: float, count: int, level: float, seed: int, **design: object) -> list[RollTurn | None]:
    alone = {"sensors": 1, "reference_every": 0, "check_set": False}
    drawn = campaigns(scene, size, np.random.default_rng(seed), count, **{**alone, **design})
    rows = rows_of(drawn)
    evidence = {axis: evidence_of(columns, rows) for axis, columns in solved(drawn).items()}
    return [judge_roll_turn([(evidence[axis], index) for axis in "xyz"], level) for index in range(drawn.campaigns)]


@pytest.mark.parametrize("order", ["random", "there-and-back"])
def test_where_nothing_is_wrong_a_turn_is_told_as_often_as_the_level(order: str) -> None:
    level, runs = 0.05, 200
    told = _turns("clean", 0.0, runs, level, 7, order=order, pitch_count=9, roll_count=8, replications=4)
    share = np.mean([turn is not None for turn in told])
    assert abs(share - level) <= 3.0 * np.sqrt(level / runs)


@pytest.mark.parametrize(
    ("scene", "size"),
    [("soft-mount", 50.0), ("k3", 50.0), ("table-once", 20.0), ("table-teeth", 20.0), ("table-wrong-zero", 100.0)],
)
def test_neither_terms_of_sensors_nor_errors_of_the_table_pass_for_it(scene: str, size: float) -> None:
    told = _turns(scene, size, 30, SHARE, 22, order="there-and-back")
    assert sum(turn is not None for turn in told) <= 1
