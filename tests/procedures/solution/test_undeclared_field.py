"""What a magnetometer is held against and nobody declared: check, result, verdict, set and certificate tell it.

A gain is a field over a field: GUM 4.3 has no residual of a coil that is off by a part, so only a declaration tells.
"""

from datetime import date
from pathlib import Path

import pytest
from motion_runs import motion_run

from ams.archive.sign_offs import SignOff
from ams.sets.verdict_conditions import NO_FIELD, NO_LEVEL, NO_TABLE
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.delivery.deliver import sets_of
from procedures.plan.undeclared import undeclared_of_plan
from procedures.report.assemble import assemble_view

SHORT = {r"rest_s = 60.0": "rest_s = 15.0", r"replications = 4": "replications = 3"}
STRENGTH, DIRECTION, BESIDE = "field.coil.uncertainty_ut", "field.coil.direction_uncertainty_deg", "levels.surr"
NO_STRENGTH = {r"uncertainty_ut = 0.05": ""}
A_DIRECTION = {r"uncertainty_ut = 0.05": "uncertainty_ut = 0.05\ndirection_uncertainty_deg = 0.1"}
NO_REFERENCE = {r"\[attitude_reference\]\n(?:.+\n)+": ""}
KNOWN = {r"rest_s = 60.0": "rest_s = 15.0\nsurroundings_ut = [22.0, -3.0, 40.0]"}
DECLARED = {r"rest_s = 60.0": "rest_s = 15.0\nsurroundings_ut = [22.0, -3.0, 40.0]\nsurroundings_uncertainty_ut = 0.02"}


@pytest.mark.parametrize(
    ("rig_changes", "changes", "wanted"),
    [
        ({}, {}, {DIRECTION}),
        (NO_STRENGTH, {}, {STRENGTH, DIRECTION}),
        (A_DIRECTION, {}, set()),
        (A_DIRECTION, KNOWN, {BESIDE}),
        (A_DIRECTION, DECLARED, set()),
        (NO_STRENGTH, KNOWN, {STRENGTH, DIRECTION, BESIDE}),
        (NO_STRENGTH, {r"rest_s = 60.0": 'rest_s = 15.0\nmethod = "magnet-difference"'}, set()),
    ],
    ids=["example", "nothing", "coil", "beside", "everything", "none", "magnet"],
)
def test_every_key_that_nobody_declared_is_named_and_no_other(
    tmp_path: Path, rig_changes: dict[str, str], changes: dict[str, str], wanted: set[str]
) -> None:
    made = motion_run(tmp_path, "servo-mechanism", "magnetometer", changes, rig_changes)
    said = undeclared_of_plan(made.rig, made.plan).field
    named = " ".join(entry.what_to_do for entry in said)
    assert {key for key in (STRENGTH, DIRECTION, BESIDE) if key in named} == wanted
    assert len(said) == bool(wanted)


def test_a_field_of_which_nothing_is_declared_is_told_in_check_result_verdict_and_certificate(tmp_path: Path) -> None:
    made = motion_run(tmp_path, "servo-mechanism", "magnetometer", SHORT, NO_STRENGTH)
    undeclared = undeclared_of_plan(made.rig, made.plan)
    (said,) = (text for text in undeclared.remarks if text.startswith(NO_FIELD))
    solved = made.solved()
    calibration = solved.sensors["MicroMag3"].calibration
    assert calibration is not None
    assert said in calibration.remarks
    assert all("field-undeclared" in [finding.kind for finding in axis.findings] for axis in calibration.axes.values())
    assert "the uncertainty of the field" in assemble_view(solved.record, solved.sensors).verdict.sentence
    (entry,) = sets_of(solved).values()
    grounds = Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))
    assert [gap for gap in gaps_of(grounds) if gap.startswith(NO_FIELD)]


def test_indices_and_the_level_turn_a_magnetometer_as_they_turn_what_senses_gravity(tmp_path: Path) -> None:
    """The example's attitudes are told by a reference sensor; without it by its axes, of which nothing is declared."""
    told, by_axes = (tmp_path / name for name in ("told", "by_axes"))
    for folder, rig_changes, wanted in ((told, {}, False), (by_axes, NO_REFERENCE, True)):
        folder.mkdir()
        made = motion_run(folder, "servo-mechanism", "magnetometer", SHORT, rig_changes)
        undeclared = undeclared_of_plan(made.rig, made.plan)
        assert bool(undeclared.level) == bool(undeclared.table) == wanted
        assert all(entry.text.startswith(NO_LEVEL) for entry in undeclared.level)
        assert all(entry.text.startswith(NO_TABLE) for entry in undeclared.table)
