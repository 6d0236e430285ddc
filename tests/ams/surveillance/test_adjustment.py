"""As found and as left: errors in degrees that were put in come out, and the verdict follows its stated rule."""

import numpy as np
import pytest
from changed_sets import changed
from package_outputs import TRUTH, output_v
from solved_sets import package_set, tp_set

from ams.calibration.calibrate import calibrate
from ams.errors import OutsideValidity
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.coefficients import from_document as set_from_document
from ams.sets.provenance import Provenance
from ams.surveillance.adjustment import (
    Acceptance,
    Verdict,
    acceptance_of,
    adjust,
    from_document,
    judge,
    to_document,
)
from ams.surveillance.attitude_errors import TWO_ATTITUDES, AngleErrors, angles_judged, errors_of

GRID = [(p, r) for p in range(-90, 91, 15) for r in range(-180, 180, 45)]
PITCH_RAD, ROLL_RAD = np.radians(np.array(GRID, dtype=float)).T


def measured(axes: str, seen_pitch_deg: float = 0.0, seen_roll_deg: float = 0.0, noise_v: float = 0.0) -> Observations:
    """Outputs of a package that sees its table off by these angles; two replications."""
    chance = np.random.default_rng(12)
    clean = {
        axis: np.array([output_v(axis, TRUTH[axis], p + seen_pitch_deg, r + seen_roll_deg) for p, r in GRID])
        for axis in axes
    }
    outputs = {axis: np.tile(entry, 2) + noise_v * chance.normal(size=2 * entry.size) for axis, entry in clean.items()}
    count = len(GRID)
    return Observations(
        np.repeat([1, 2], count), np.tile(np.arange(count), 2), np.tile(PITCH_RAD, 2), np.tile(ROLL_RAD, 2), outputs
    )


def solved(observations: Observations) -> CoefficientSet:
    location = tp_set("x").provenance
    provenance = Provenance(
        sensor="TP1", gravity_mps2=9.79826, gravity_source="survey", pitch_range_deg=(-90.0, 90.0),
        roll_range_deg=(-180.0, 180.0), created_utc=tp_set("x").created_utc, software_version="0.1.0",
        rig=str(location["rig"]), procedure="fit", simulated=False,
    )  # fmt: skip
    return build_set(calibrate(observations, CalibrationRequest(extended="no")), provenance)


@pytest.mark.parametrize("axes", ["xyz", "xy", "xz"])
def test_a_table_that_is_off_by_known_angles_is_found_off_by_them(axes: str) -> None:
    before = solved(measured(axes, noise_v=1e-6))
    rows = measured(axes, 0.02, -0.01, noise_v=1e-6)
    errors = errors_of(before, solved(rows), rows, (-60.0, 60.0))
    of_two = errors["pitch"].parts_deg.get(TWO_ATTITUDES, np.zeros(1))
    assert (np.abs(errors["pitch"].error_deg - 0.02) < 3e-4 + of_two).all()
    assert (of_two > 0.0).mean() < 0.3, "only where both attitudes of two axes meet"
    assert np.abs(errors["roll"].error_deg + 0.01).max() < 3e-4
    assert np.abs(errors["pitch"].pitch_deg).max() <= 60.0 + 1e-9


def test_one_axis_tells_pitch_with_the_roll_of_the_table() -> None:
    before, rows = solved(measured("x")), measured("x", 0.05)
    errors = errors_of(before, solved(rows), rows)
    assert set(errors) == {"pitch"}
    assert np.abs(errors["pitch"].error_deg - 0.05).max() < 3e-4
    assert errors["pitch"].left_out == 2 * 8  # at pitch ±90 degrees the x axis does not move with pitch
    assert np.abs(errors["pitch"].pitch_deg).max() == pytest.approx(75.0)


def test_roll_is_not_told_where_the_package_stands_on_end() -> None:
    before, rows = solved(measured("xyz")), measured("xyz", 0.01)
    errors = errors_of(before, solved(rows), rows)
    assert (errors["roll"].left_out, errors["pitch"].left_out) == (16, 0)


def test_the_uncertainty_covers_the_errors_of_noise_alone() -> None:
    rows = measured("xyz", noise_v=2e-5)
    truth = solved(measured("xyz"))
    errors = errors_of(truth, solved(rows), rows, (-60.0, 60.0))["pitch"]
    inside = np.abs(errors.error_deg) <= errors.expanded_deg
    assert inside.mean() > 0.9


def an_error(error_deg: float, expanded_deg: float) -> AngleErrors:
    entry = np.array([0.0])
    return AngleErrors("pitch", entry, entry, np.array([error_deg]), np.array([expanded_deg / 2.0]), 2.0, 0)


@pytest.mark.parametrize(
    ("error_deg", "expanded_deg", "guarded", "simple"),
    [
        (0.05, 0.04, "pass", "pass"),
        (-0.05, 0.05, "pass", "pass"),
        (0.07, 0.04, "conditional", "pass"),
        (-0.13, 0.04, "conditional", "fail"),
        (0.15, 0.04, "fail", "fail"),
        (0.01, 0.20, "conditional", "pass"),
    ],
)
def test_the_verdict_follows_the_rule(error_deg: float, expanded_deg: float, guarded: Verdict, simple: Verdict) -> None:
    errors = an_error(error_deg, expanded_deg)
    assert judge(errors, 0.1, "guard-band").verdict == guarded
    assert judge(errors, 0.1, "simple").verdict == simple
    assert "0.1°" in judge(errors, 0.1, "guard-band").sentence


@pytest.mark.parametrize(("error_deg", "side"), [(0.0121, "beyond"), (-0.0121, "beyond"), (0.0052, "inside")])
def test_a_conditional_verdict_says_the_limit_and_the_uncertainty_each_by_its_own_figure(
    error_deg: float, side: str
) -> None:
    sentence = judge(an_error(error_deg, 0.0191), 0.01, "guard-band").sentence
    assert sentence.endswith(f"is {side} the limit of 0.01°, but by less than its uncertainty of 0.0191°")


@pytest.mark.parametrize(("error_deg", "verdict", "side"), [(0.002, "pass", "inside"), (0.05, "fail", "beyond")])
def test_a_verdict_without_reservation_says_the_side_of_the_limit_alone(
    error_deg: float, verdict: Verdict, side: str
) -> None:
    for rule in ("guard-band", "simple"):
        judged = judge(an_error(error_deg, 0.001), 0.01, rule)
        assert (judged.verdict, judged.sentence.split(" is ")[1]) == (verdict, f"{side} the limit of 0.01°")


def test_the_attitude_that_decides_is_the_one_that_is_told() -> None:
    at = np.array([0.0, 10.0, 20.0])
    errors = AngleErrors("pitch", at, at, np.array([0.02, -0.3, 0.1]), np.array([0.01, 0.01, 0.2]), 2.0, 0)
    assert judge(errors, 0.2, "guard-band").pitch_deg == 10.0  # beyond doubt beyond the limit
    assert judge(errors, 1.0, "guard-band").pitch_deg == 20.0  # closest to the limit with its uncertainty
    assert judge(errors, 0.2, "simple").pitch_deg == 10.0


def with_gain(coefficients: CoefficientSet, axis: str, gain: float) -> CoefficientSet:
    """The set of a sensor whose sensitivity was another."""

    def change(document: dict) -> None:
        values = document["axes"][axis]["primary"]["values"]
        values.update({name: value * gain for name, value in values.items() if name.startswith("k_")})

    return set_from_document(changed(coefficients, change), "with another gain")


def test_as_found_fails_and_as_left_passes_where_the_sensor_had_changed() -> None:
    rows = measured("xyz", noise_v=1e-6)
    new = solved(rows)
    before = with_gain(new, "x", 1.001)
    found = adjust(before, new, rows, Acceptance({"pitch": 0.02, "roll": 0.1}), (-60.0, 60.0))
    assert found.as_found is not None
    assert (found.as_found.verdict, found.as_left.verdict) == ("fail", "pass")
    assert found.as_found.set_sha256 == before.sha256
    assert found.as_left.largest_error_deg is not None
    assert found.as_left.largest_error_deg < 1e-3


def test_a_calibration_that_is_not_usable_is_not_judged_as_left_though_its_errors_are_told() -> None:
    rows = measured("xyz", noise_v=1e-6)
    usable = solved(rows)
    new = set_from_document(changed(usable, lambda document: document.update(verdict="not usable")), "not usable")
    limits = Acceptance({"pitch": 0.02})
    found, sound = adjust(None, new, rows, limits), adjust(None, usable, rows, limits)
    assert (sound.as_left.verdict, sound.not_judged) == ("pass", None)
    assert (found.as_left.verdict, found.as_left.judgements) == (None, ())
    assert found.not_judged == "the calibration is not usable"
    assert found.as_left.largest_error_deg == sound.as_left.largest_error_deg
    assert adjust(None, new, rows, Acceptance({})).not_judged is None, "where no limit is declared none is missing"


STATED = {
    "acceptance": {"pitch_limit_deg": 0.05, "decision_rule": "simple"},
    "laboratory": {"name": "a laboratory", "capability_deg": 0.002},
}


def test_nothing_passes_by_an_uncertainty_that_is_smaller_than_the_stated_capability() -> None:
    """ILAC-P14:09/2020 5.4: the capability is the least that a certificate states, and it judges by what it states."""
    errors = AngleErrors("pitch", np.zeros(1), np.zeros(1), np.array([0.0004]), np.array([0.0003]), np.full(1, 2.0), 0)
    assert judge(errors, 0.0015, "guard-band").verdict == "pass"
    floored = judge(errors, 0.0015, "guard-band", 0.002)
    assert (floored.verdict, floored.expanded_deg) == ("conditional", 0.002)
    assert floored.sentence.endswith("but by less than its uncertainty of 0.0020°; U is the capability")
    assert judge(errors, 0.0015, "guard-band", 0.0001) == judge(errors, 0.0015, "guard-band")
    assert acceptance_of(STATED).capability_deg == 0.002


def test_what_was_judged_without_the_capability_is_judged_anew_by_it() -> None:
    rows = measured("xyz", noise_v=1e-6)
    new = solved(rows)
    before = adjust(None, new, rows, Acceptance({"pitch": 0.0015}))
    assert before.as_left.verdict == "pass"
    capable = Acceptance({"pitch": 0.0015}, capability_deg=0.002)
    again = from_document(to_document(before), capable)
    assert again.as_left.judgements == adjust(None, new, rows, capable).as_left.judgements
    assert again.as_left.verdict == "conditional"


def test_an_adjustment_comes_back_from_its_document() -> None:
    before, rows = solved(measured("xyz", noise_v=1e-6)), measured("xyz", 0.05, noise_v=1e-6)
    found = adjust(before, solved(rows), rows, acceptance_of(STATED))
    back = from_document(to_document(found))
    assert to_document(back) == to_document(found)
    assert (back.as_left.verdict, back.acceptance) == (found.as_left.verdict, found.acceptance)


def test_a_first_calibration_has_nothing_to_find_and_no_limit_no_verdict() -> None:
    rows = measured("xyz", noise_v=1e-6)
    found = adjust(None, solved(rows), rows, acceptance_of({}))
    assert (found.as_found, found.no_as_found) == (None, "first calibration in this archive")
    assert found.as_left.verdict is None


def test_a_previous_set_of_another_kind_says_why_it_finds_nothing() -> None:
    rows = measured("xy", noise_v=1e-6)
    found = adjust(solved(measured("xyz", noise_v=1e-6)), solved(rows), rows, acceptance_of({}))
    assert found.as_found is None
    assert found.no_as_found is not None
    assert "axis z of the set was not measured" in found.no_as_found


def test_packages_that_know_yaw_are_refused_with_the_reason() -> None:
    with pytest.raises(OutsideValidity, match="need sets of pitch and roll: got convention CR"):
        errors_of(package_set("sting"), package_set("sting"), measured("xyz"))


def test_a_set_that_lies_about_sensitivity_is_found_out_in_degrees() -> None:
    """By 0.1 %: tan(60 deg)·0.001 rad at the most, TP (76)."""
    rows = measured("x", noise_v=1e-6)
    new = solved(rows)
    old = with_gain(new, "x", 1.001)
    errors = errors_of(old, new, rows, (-60.0, 60.0))["pitch"]
    assert np.abs(errors.error_deg).max() == pytest.approx(np.degrees(0.001 * np.tan(np.radians(60.0))), rel=0.02)


@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
def test_a_plan_can_foretell_which_limits_a_calibration_is_held_to(axes: str) -> None:
    rows = measured(axes, noise_v=1e-6)
    found = adjust(None, solved(rows), rows, Acceptance({"pitch": 0.1, "roll": 0.1}))
    assert tuple(judged.angle for judged in found.as_left.judgements) == angles_judged("pitch-roll", len(axes))


@pytest.mark.parametrize("model", ["pitch-yaw-roll-sting", "pitch-yaw-roll-model", "gyro", "linear-accelerometer"])
def test_of_other_models_no_angle_is_held_to_a_limit(model: str) -> None:
    assert angles_judged(model, 3) == ()
