"""No dead keys in ``procedure.toml``: every key of the form, changed, changes a plan, a result, a page or a refusal."""

from pathlib import Path

import pytest
from file_keys import keys_of
from key_trials import Trial, marks_of, what_a_change_does

from procedures.kinds.read import procedure_form

FREE_TEXT = frozenset({"procedure.title"})
STEPS = {"from": -30.0, "to": 30.0, "step": 30.0}
COUNT = {"from": -30.0, "to": 30.0, "step": None, "count": 2}
UNTIL_ENOUGH = {
    "procedure": {"replications": None},
    "stop": {"half_width_deg": 0.01, "least_replications": 2, "most_replications": 3},
}
GIMBAL = {
    "axes": {
        "yaw": {
            "driver": "indexing-table", "port": "twin", "increment_deg": 1.0, "limits_deg": [-180.0, 180.0],
            "speed_dps": 20.0, "axis": 3,
        }
    }
}  # fmt: skip
MODEL_PACKAGE = {"solve": {"model": "pitch-yaw-roll"}}
YAW = {**MODEL_PACKAGE, "design": {"yaw_deg": STEPS}}
YAW_COUNT = {**MODEL_PACKAGE, "design": {"yaw_deg": COUNT}}
APPLIED = {
    "solve": {
        "temperature": "apply",
        "known_temperature": {
            f"SN1047.{axis}": {
                "offset_tc_v_per_degc": 1e-5, "sensitivity_tc_per_degc": 1e-5, "reference_temperature_degc": 23.0,
            }
            for axis in "xyz"
        },
    }
}  # fmt: skip
TWO_PLATEAUS = {"solve": {"temperature": "estimate"}, "environment": {"plateaus_degc": [10.0, 30.0, 10.0, 30.0, 10.0]}}
"""Enough for a straight line and for no bend."""
NOISY = {"dwell": {"max_noise_factor": 1.001, "samples": 5}}
ADAPTIVE = {"dwell": {"samples": 5, "adaptive": {"noise_arcsec": 1.0, "least_samples": 3, "most_samples": 6}}}
RESTLESS = {"twin": {"axes": {name: {"creep_arcsec": 2000.0, "creep_s": 5.0} for name in ("pitch", "roll")}}}
TRIALS = {
    "design.kind": Trial("D1"),
    "design.pitch_deg.from": Trial(-90.0),
    "design.pitch_deg.to": Trial(90.0),
    "design.pitch_deg.step": Trial(30.0),
    "design.pitch_deg.count": Trial(3, procedure={"design": {"pitch_deg": COUNT}}),
    "design.pitch_deg": Trial([-40.0, 40.0]),
    "design.roll_deg.to": Trial(150.0),
    "design.roll_deg.count": Trial(2),
    "design.roll_deg.step": Trial(
        90.0, procedure={"design": {"roll_deg": {"from": -180.0, "to": 90.0, "count": None, "step": 45.0}}}
    ),
    "design.roll_deg": Trial([-90.0, 0.0, 90.0]),
    "design.yaw_deg.from": Trial(0.0, job="indexing-table", rig=GIMBAL, procedure=YAW),
    "design.yaw_deg.to": Trial(0.0, job="indexing-table", rig=GIMBAL, procedure=YAW),
    "design.yaw_deg.step": Trial(60.0, job="indexing-table", rig=GIMBAL, procedure=YAW),
    "design.yaw_deg.count": Trial(3, job="indexing-table", rig=GIMBAL, procedure=YAW_COUNT),
    "design.yaw_deg": Trial([0.0, 30.0], job="indexing-table", rig=GIMBAL, procedure=YAW),
    "design.fractional": Trial(
        [1, 2],
        job="indexing-table",
        procedure={
            "design": {
                "kind": "fractional",
                "fractional": [1, 1],
                "pitch_deg": {"from": -60.0, "to": 60.0, "step": 30.0},
                "roll_deg": {"from": -180.0, "to": 150.0, "count": None, "step": 30.0},
            }
        },
    ),
    "design.file": Trial(
        "other.csv",
        procedure={"design": {"kind": "file", "file": "points.csv", "pitch_deg": None, "roll_deg": None}},
        files={
            "points.csv": "pitch_deg,roll_deg\n-30,-90\n-30,0\n-30,90\n30,-90\n30,0\n30,90\n",
            "other.csv": "pitch_deg,roll_deg\n-40,-90\n-30,0\n-30,90\n30,-90\n30,0\n30,90\n",
        },
    ),
    "design.repeat_roll": Trial(
        procedure={"design": {"roll_deg": {"from": -180.0, "to": 90.0, "count": None, "step": 90.0}}}
    ),
    "design.usage_pitch_deg": Trial([-20.0, 20.0]),
    "design.usage_noise_arcsec": Trial(3.0),
    "design.seed": Trial(procedure={"design": {"order": "seeded"}}),
    "dwell.settle.min_s": Trial(5.0),
    "dwell.settle.max_s": Trial(3.0, rig=RESTLESS),
    "dwell.max_noise_factor": Trial(1.001),
    "dwell.adaptive.noise_arcsec": Trial(0.1, job="indexing-table", procedure=ADAPTIVE),
    "dwell.adaptive.least_samples": Trial(4, job="indexing-table", procedure=ADAPTIVE),
    "dwell.adaptive.most_samples": Trial(9, job="indexing-table", procedure=ADAPTIVE),
    "dwell.adaptive.nplc": Trial([1.0, 2.0], job="indexing-table", procedure=ADAPTIVE),
    "dwell.nplc": Trial(1.0),
    "dwell.retries": Trial(procedure=NOISY),
    "environment.name": Trial("nowhere"),
    "environment.end_degc": Trial(21.0),
    "check.pitch_deg": Trial(10.0),
    "check.roll_deg": Trial(10.0),
    "stop.max_duration_s": Trial(60.0),
    "stop.half_width_deg": Trial(0.02, procedure=UNTIL_ENOUGH),
    "stop.least_replications": Trial(3, procedure=UNTIL_ENOUGH),
    "stop.most_replications": Trial(4, procedure=UNTIL_ENOUGH),
    "solve.model": Trial("pitch-yaw-roll", job="indexing-table", rig=GIMBAL),
    "solve.packages": Trial({"SN1047": "sting"}, job="indexing-table", rig=GIMBAL, procedure=YAW),
    "solve.temperature": Trial("estimate", job="table"),
    "solve.known_temperature.*.offset_tc_v_per_degc": Trial(job="table", procedure=APPLIED),
    "solve.known_temperature.*.sensitivity_tc_per_degc": Trial(job="table", procedure=APPLIED),
    "solve.known_temperature.*.offset_tc2_v_per_degc2": Trial(1e-6, job="table", procedure=APPLIED),
    "solve.known_temperature.*.sensitivity_tc2_per_degc2": Trial(1e-6, job="table", procedure=APPLIED),
    "solve.known_temperature.*.offset_tc_uncertainty_v_per_degc": Trial(1e-6, job="table", procedure=APPLIED),
    "solve.known_temperature.*.sensitivity_tc_uncertainty_per_degc": Trial(1e-6, job="table", procedure=APPLIED),
    "solve.temperature_order": Trial(2, job="table", procedure=TWO_PLATEAUS),
    "solve.reference_temperature_degc": Trial(25.0, job="table", procedure=TWO_PLATEAUS),
    "solve.joint_priors_arcsec": Trial({"roll_zero": 20.0}, procedure={"solve": {"joint": True}}),
    "solve.known_temperature.*.reference_temperature_degc": Trial(job="table", procedure=APPLIED),
    "export.formats": Trial(["csv"], procedure={"export": {"formats": ["json"]}}),
    "profile.span_deg": Trial({"pitch": 5.0, "yaw": 10.0, "roll": 10.0}),
    "profile.frequency_hz": Trial({"pitch": 0.25, "yaw": 0.0625, "roll": 0.25}),
    "profile.update_s": Trial(0.054),
    "levels.coil": Trial("nothing"),
    "levels.surroundings_ut": Trial([22.0, -3.0, 40.0]),
    "levels.surroundings_uncertainty_ut": Trial(
        0.5, job="levels", procedure={"levels": {"surroundings_ut": [22.0, -3.0, 40.0]}}
    ),
    "static.shortest_s": Trial(5.0),
    "static.parts": Trial({"ITG3200": "MG-L106C"}),
}
KEYS = keys_of(procedure_form())


def trial_of(key: str) -> Trial:
    return TRIALS.get(key) or Trial()


@pytest.mark.parametrize("key", [pytest.param(key, marks=marks_of(key)) for key in KEYS if key not in FREE_TEXT])
def test_a_change_of_the_key_is_seen(key: str, tmp_path: Path) -> None:
    assert what_a_change_does("procedure", key, KEYS[key], trial_of(key), tmp_path), f"{key}: nothing reads it"


def test_every_key_that_is_named_is_a_key_of_the_form() -> None:
    assert FREE_TEXT | TRIALS.keys() <= KEYS.keys()
