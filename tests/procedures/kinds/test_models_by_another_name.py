"""A model is planned, solved and used by what it is registered with: the same one by another name gives the same."""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from installed_examples import install
from planning_files import procedure_file, rig_file
from solved import provenance
from solved_sets import package_set
from stored_runs import DATA, StoredCase

from ams.calibration.calibrate import calibrate
from ams.errors import ObservationsError
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.models.registry import names_at_rest, names_by_option, names_of_rates
from ams.observations import Observations
from ams.sets.coefficients import build_set
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.planner import make_plan
from procedures.kinds.registry import KINDS
from procedures.kinds.solve import solve_record
from procedures.solution.provenance import provenance_of
from procedures.solution.record import read_record
from procedures.solution.said_of_file import rate_remarks

AGAIN = """
from dataclasses import replace
from ams.models.accelerometer import PITCH_ONLY, PitchOnly
from ams.models.gyro import GYRO, Gyro
from ams.models.pitch_yaw_roll import STING, PitchYawRoll

class PitchAgain(PitchOnly):
    name = "pitch-again"

class GyroAgain(Gyro):
    name = "gyro-again"

class StingAgain(PitchYawRoll):
    name = "sting-again"

PITCH = replace(PITCH_ONLY, name="pitch-again", make=PitchAgain)
RATES = replace(GYRO, name="gyro-again", make=GyroAgain)
OF_STING = replace(STING, name="sting-again", family=None, make=lambda axis: StingAgain(axis, package="sting"))
"""
ENTRIES = {"pitch-again": "again:PITCH", "gyro-again": "again:RATES", "sting-again": "again:OF_STING"}


@pytest.fixture(autouse=True)
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    site = tmp_path / "site"
    site.mkdir()
    (site / "again.py").write_text(AGAIN, encoding="utf-8")
    install("again", {"calrig.models": ENTRIES}, site, monkeypatch)
    monkeypatch.delitem(sys.modules, "again", raising=False)
    yield
    sys.modules.pop("again", None)


def test_the_names_that_may_be_asked_for_follow_from_what_is_registered() -> None:
    again, told = {"pitch-again", "sting-again"}, set(names_at_rest())
    assert {"linear", "pitch-only", "pitch-roll", "pitch-yaw-roll", *again} <= told
    assert {"gyro", "gyro-again"} <= set(names_of_rates())
    assert told.isdisjoint(names_of_rates())
    assert set(names_by_option()) == {*names_at_rest(), *names_of_rates()}
    assert set(KINDS["grid"].models) == told
    assert set(KINDS["rates"].models) == {*names_of_rates(), "linear"}


def test_a_tumble_goes_without_roll_for_every_model_that_states_none(tmp_path: Path) -> None:
    rig = rig_file(
        tmp_path, ('"three-axis package"', '"single-axis package"'), (', y = "dmm.y", z = "dmm.z" }\nnom', " }\nnom")
    )
    changes = [
        ('kind = "grid"', 'kind = "tumble"'), ('kind = "D1"', 'kind = "T"'),
        ("pitch_deg = { from = -30.0, to = 30.0, step = 10.0 }", ""),
        ("roll_deg = { from = -180.0, to = 180.0, step = 90.0 }", ""),
    ]  # fmt: skip
    plans = {
        model: make_plan(rig, procedure_file(tmp_path, *changes, more=f'[solve]\nmodel = "{model}"\n'))
        for model in ("pitch-only", "pitch-again", "pitch-roll")
    }
    assert plans["pitch-again"].steps == plans["pitch-only"].steps
    assert plans["pitch-again"].design == plans["pitch-only"].design
    assert {point.roll_deg for point in plans["pitch-again"].design.points} == {0.0}
    assert len(plans["pitch-roll"].design.points) > len(plans["pitch-only"].design.points)


def _pitched(yaw_deg: float = 0.0) -> Observations:
    pitch = np.deg2rad(np.tile(np.arange(-60.0, 61.0, 15.0), 3))
    noise = 1e-5 * np.random.default_rng(1).standard_normal(pitch.size)
    return Observations(
        np.repeat([1, 2, 3], 9), np.tile(np.arange(9), 3), pitch, np.zeros(27),
        {"x": 0.01 + 2.5 * np.sin(pitch - 0.003) + noise}, yaw_rad=np.full(27, np.deg2rad(yaw_deg)),
    )  # fmt: skip


def test_angles_are_told_as_by_the_same_model_with_its_own_name() -> None:
    found = {}
    for model in ("pitch-only", "pitch-again"):
        solved = calibrate(_pitched(), CalibrationRequest(model=model))
        coefficients = build_set(solved, provenance(sensor="SN1"))
        readings = {"x_v": np.array([-1.0, 0.2, 1.7]), "roll_deg": np.array([40.0, -30.0, 90.0])}
        found[model] = inference(Package(coefficients, {"x": "x_v"}), reading_sd_v=1e-5).infer(readings)
        assert set(found[model]) == {"pitch_deg", "pitch_sd_deg", "roll_deg", "roll_sd_deg", "flag"}
    for name, values in found["pitch-only"].items():
        np.testing.assert_array_equal(found["pitch-again"][name], values)


@pytest.mark.parametrize("model", ["pitch-roll", "pitch-only", "pitch-again"])
def test_yaw_is_refused_by_every_model_that_has_none(model: str) -> None:
    with pytest.raises(ObservationsError, match=f"the model {model} has no yaw, allowed 0°; nothing was solved"):
        calibrate(_pitched(yaw_deg=3.0), CalibrationRequest(model=model))


def test_a_package_on_the_sting_tells_yaw_by_any_name() -> None:
    own = package_set("sting")
    axes = {axis: replace(numbers, model="sting-again") for axis, numbers in own.axes.items()}
    columns = {axis: f"{axis}_v" for axis in axes}
    readings = {"x_v": np.array([0.1, -0.4]), "y_v": np.array([0.05, 0.2]), "z_v": np.array([2.0, 1.9])}
    answers = [
        inference(Package(coefficients, columns), reading_sd_v=1e-5).infer(readings)
        for coefficients in (own, replace(own, axes=axes))
    ]
    assert {"yaw_deg", "yaw_sd_deg"} <= set(answers[0])
    for name, values in answers[0].items():
        np.testing.assert_array_equal(answers[1][name], values)


def test_a_run_on_a_rate_table_is_solved_as_by_gyro(tmp_path: Path) -> None:
    run = StoredCase(DATA / "runs_0_1_0" / "rates_gyro").copy("finished", tmp_path / "run")
    with JournalReader.open(run) as reader:
        record = read_record(reader)
    again = replace(
        record, plan=replace(record.plan, solve=record.plan.solve.model_copy(update={"model": "gyro-again"}))
    )
    [own], [other] = (solve_record(which).values() for which in (record, again))
    assert own.calibration is not None
    assert other.calibration is not None
    for axis, found in own.calibration.axes.items():
        assert other.calibration.axes[axis].parameters == found.parameters
    assert other.calibration.remarks == own.calibration.remarks
    assert provenance_of(other, again).rate_range_dps == provenance_of(own, record).rate_range_dps is not None
    assert rate_remarks(CalibrationRequest(model="gyro-again")) == rate_remarks(CalibrationRequest(model="gyro")) != ()
