"""The whole calibration: recovery, what is refused, what is null, what is said."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, OFFSET_V, VECTOR_V_PER_G, Campaign

from ams.analysis.predictions import model_of_solution
from ams.arrays import IntArray
from ams.calibration.calibrate import calibrate
from ams.errors import DesignError, ObservationsError
from ams.inputs.request import CalibrationRequest, select_rows
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.accelerometer import PitchRoll
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations

QUIET = Campaign(noise_arcsec=0.0, replications=3)
TABLE = TableUncertainty(ARCSEC, ARCSEC, "limit")
EVERYTHING = Campaign(
    index_limit_arcsec=1.0, lack_of_fit_arcsec=1.5, offset_drift_arcsec=2.0, sensitivity_drift=1e-5, replications=6
)


def observe(campaign: Campaign, seed: int = 0) -> Observations:
    return campaign.observe(np.random.default_rng(seed))


def drop(observations: Observations, *rows: int) -> Observations:
    kept = np.ones(observations.rows, dtype=bool)
    kept[list(rows)] = False
    return select_rows(observations, kept)


def truth(axis: str) -> list[float]:
    """Offset, sensitivity, coning and azimuth by their definition: lengths and angles of the vector k."""
    i = "xyz".index(axis)
    along, first, second = np.roll(VECTOR_V_PER_G[axis], -i)
    sign = np.sign(along)
    sensitivity = sign * np.linalg.norm(VECTOR_V_PER_G[axis])
    coning = np.degrees(np.arccos(along / sensitivity))
    return [OFFSET_V[axis], sensitivity, coning, np.degrees(np.arctan2(sign * second, sign * first))]


@pytest.mark.parametrize("table", [None, TABLE])
@pytest.mark.parametrize("dropped", [(), (3, 50, 51, 120)])
def test_noise_free_data_give_the_truth_to_ten_digits(table, dropped) -> None:
    found = calibrate(drop(observe(QUIET), *dropped), CalibrationRequest(table=table, extended="no"))
    for axis, solved in found.axes.items():
        np.testing.assert_allclose([p.value for p in solved.parameters], truth(axis), rtol=0, atol=1e-10)
        np.testing.assert_allclose(solved.sensitive_axis_v_per_g, VECTOR_V_PER_G[axis], rtol=0, atol=1e-12)
        assert np.abs(solved.residuals_v).max() < 1e-12


def test_rounding_is_not_taken_for_lack_of_fit_or_drift() -> None:
    replication = calibrate(observe(QUIET), CalibrationRequest(extended="no")).axes["x"].replication
    assert replication is not None
    assert np.isnan(replication.lack_of_fit.t)
    assert not any(test.is_significant for test in replication.drift.values())


def test_pooled_uncertainty_is_that_of_ordinary_least_squares() -> None:
    observations = observe(EVERYTHING)
    solved = calibrate(observations, CalibrationRequest(extended="no")).axes["y"]
    pitch, roll = observations.pitch_rad, observations.roll_rad
    basis = np.stack([pitch * 0 + 1, np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], 1)
    estimate, squares, *_ = np.linalg.lstsq(basis, observations.outputs["y"], rcond=None)
    dof = observations.rows - 4
    np.testing.assert_allclose(solved.primary, estimate, rtol=1e-10)
    assert solved.degrees_of_freedom == dof
    assert solved.standard_error_v == pytest.approx(np.sqrt(squares[0] / dof), rel=1e-9)
    np.testing.assert_allclose(
        solved.tp_primary_covariance, squares[0] / dof * np.linalg.inv(basis.T @ basis), rtol=1e-8, atol=1e-24
    )


def test_components_add_up_to_the_covariance_and_parameters_to_their_uncertainties() -> None:
    solved = calibrate(observe(EVERYTHING), CalibrationRequest(table=TABLE, extended="no")).axes["x"]
    assert {part.name for part in solved.variance_components} == {"replications", "lack-of-fit", "table"}
    np.testing.assert_allclose(sum(p.covariance for p in solved.variance_components), solved.primary_covariance)
    for index, parameter in enumerate(solved.parameters):
        assert parameter.standard_uncertainty == pytest.approx(np.sqrt(solved.covariance[index, index]))
        low, high = parameter.interval_95
        assert low < parameter.value < high


def test_each_replication_is_given_alone() -> None:
    observations = observe(EVERYTHING)
    solved = calibrate(observations, CalibrationRequest(extended="no")).axes["z"]
    for number, alone in solved.replication.per_replication.items():
        single = select_rows(observations, observations.replication == number)
        expected = calibrate(single, CalibrationRequest(nominal_axes={"z": "z"}, extended="no")).axes["z"].parameters
        assert alone == pytest.approx({p.name: p.value for p in expected}, rel=1e-9)


def test_a_sensor_along_its_axis_has_no_coning_and_no_azimuth_but_everything_else() -> None:
    observations = observe(QUIET)
    aligned = replace(observations, outputs={"x": 0.1 - 2.0 * np.sin(observations.pitch_rad)})
    solved = calibrate(aligned, CalibrationRequest(extended="no")).axes["x"]
    values = {p.name: p.value for p in solved.parameters}
    assert values["coning_deg"] is None
    assert values["azimuth_deg"] is None
    assert values["sensitivity_v_per_g"] == pytest.approx(-2.0, abs=1e-12)
    assert np.isnan(solved.covariance[2:]).all()
    assert np.isfinite(solved.covariance[:2, :2]).all()
    assert any("coning angle and azimuth are not determined" in warning for warning in solved.warnings)
    assert not any(name in sentence for name in values for sentence in (*solved.warnings, *solved.remarks))


def test_polarity_is_signed_and_coning_stays_below_a_right_angle() -> None:
    observations = observe(QUIET)
    turned = replace(observations, outputs={"x": -observations.outputs["x"]})
    values = [p.value for p in calibrate(turned, CalibrationRequest(extended="no")).axes["x"].parameters]
    offset, sensitivity, coning, azimuth = truth("x")
    np.testing.assert_allclose(values, [-offset, -sensitivity, coning, azimuth], atol=1e-10)


def test_one_replication_is_solved_and_says_what_it_cannot_tell() -> None:
    observations = observe(Campaign(replications=1))
    found = calibrate(observations, CalibrationRequest(table=TABLE, extended="no"))
    assert found.axes["x"].replication is None
    assert any("one replication only" in warning for warning in found.warnings)
    assert found.axes["x"].variance_components[0].name == "residuals"


def test_missing_points_are_used_around_and_named() -> None:
    found = calibrate(drop(observe(EVERYTHING), 4, 5, 60), CalibrationRequest(extended="no"))
    assert any("replication 1 lacks 2 of 49 points (5, 6)" in warning for warning in found.warnings)
    assert found.axes["x"].degrees_of_freedom == 6 * 49 - 3 - 4
    assert np.isfinite(found.axes["x"].replication.lack_of_fit.t)


def test_a_stub_of_a_replication_is_left_out_and_named() -> None:
    observations = observe(Campaign(replications=3))
    stub = drop(observations, *range(2 * 49 + 3, 3 * 49))
    found = calibrate(stub, CalibrationRequest(table=TABLE, extended="no"))
    whole = calibrate(
        select_rows(observations, observations.replication < 3), CalibrationRequest(table=TABLE, extended="no")
    )
    assert any("replication 3 has only 3 points" in warning for warning in found.warnings)
    np.testing.assert_allclose(found.axes["x"].primary, whole.axes["x"].primary, rtol=1e-12)
    assert found.axes["x"].residuals_v.size == stub.rows


def test_equal_weights_change_nothing_and_a_doubtful_row_can_be_weighed_down() -> None:
    observations = observe(EVERYTHING)
    plain = calibrate(observations, CalibrationRequest(extended="no")).axes["x"]
    equal = calibrate(observations, CalibrationRequest(weights=np.full(observations.rows, 7.0), extended="no")).axes[
        "x"
    ]
    np.testing.assert_allclose(equal.primary, plain.primary, rtol=1e-11)
    np.testing.assert_allclose(equal.primary_covariance, plain.primary_covariance, rtol=1e-6)
    assert equal.standard_error_v == pytest.approx(plain.standard_error_v)
    broken = replace(observations, outputs={"x": observations.outputs["x"] + np.eye(observations.rows)[10]})
    weights = np.where(np.arange(observations.rows) == 10, 1e-12, 1.0)
    rescued = calibrate(broken, CalibrationRequest(weights=weights, extended="no")).axes["x"]
    np.testing.assert_allclose(rescued.primary, plain.primary, rtol=0, atol=1e-6)


def test_pitch_only_recovers_offset_sensitivity_and_misalignment() -> None:
    pitch = np.deg2rad(np.tile(np.arange(-36.0, 37.0, 4.0), 2))
    half = pitch.size // 2
    observations = Observations(
        np.repeat([1, 2], half), np.tile(np.arange(half), 2), pitch, np.zeros_like(pitch),
        {"aoa": 0.02 + 2.5 * np.sin(pitch - np.deg2rad(0.3))},
    )  # fmt: skip
    solved = calibrate(observations, CalibrationRequest("pitch-only", {"aoa": "x"}, extended="no")).axes["aoa"]
    assert [p.name for p in solved.parameters] == ["offset_v", "sensitivity_v_per_g", "pitch_misalignment_deg"]
    np.testing.assert_allclose([p.value for p in solved.parameters], [0.02, 2.5, 0.3], atol=1e-10)
    assert np.isnan(solved.sensitive_axis_v_per_g[1])


class OwnModel(PitchRoll):
    """A user's model: known by its own name, otherwise as its parent."""

    name = "mine"


def test_a_model_of_the_callers_own_is_used() -> None:
    found = calibrate(
        observe(QUIET), CalibrationRequest(nominal_axes={"x": "x"}, models={"x": OwnModel("x")}, extended="no")
    )
    assert found.axes["x"].model == "mine"


def refused(match: str, error: type[Exception] = ObservationsError):
    return pytest.raises(error, match=match)


def test_one_roll_angle_is_refused_in_words() -> None:
    with refused(r"roll has one value only \(0°\).*coning and azimuth cannot be determined", DesignError):
        calibrate(observe(Campaign(roll_deg=np.zeros(1))), CalibrationRequest(extended="no"))


def test_fewer_points_than_parameters_are_refused() -> None:
    entry = Campaign(pitch_deg=np.array([0.0, 90.0]), roll_deg=np.array([0.0]), replications=1)
    with refused("2 observations cannot determine 4 parameters", DesignError):
        calibrate(observe(entry), CalibrationRequest(extended="no"))


def test_a_repeated_row_is_refused() -> None:
    observations = observe(Campaign(replications=2))
    point = observations.point.copy()
    point[5] = 7
    with refused(r"replication 1, point 7 stands more than once"):
        calibrate(replace(observations, point=point), CalibrationRequest(extended="no"))


def _labelled(replications: int, label: Callable[[IntArray, IntArray], IntArray]) -> Observations:
    """Replications 1 to n of points 1 to K, the points labelled anew."""
    observations = observe(Campaign(replications=replications))
    return replace(observations, point=label(observations.replication, observations.point))


@pytest.mark.parametrize(
    ("replications", "label", "apart"),
    [
        (3, lambda replication, point: 1000 * replication + point, "replications 2, 3 and replication 1"),
        (4, lambda replication, point: 1000 * (replication % 2) + point, "replications 2, 4 and replication 1"),
    ],
    ids=["rows numbered through the file", "two nights of one half each"],
)
def test_replications_without_a_common_point_are_refused(
    replications: int, label: Callable[[IntArray, IntArray], IntArray], apart: str
) -> None:
    with refused(f"{apart} have no point in common, nor through another"):
        calibrate(_labelled(replications, label), CalibrationRequest(extended="no"))


def test_replications_may_be_joined_by_a_third() -> None:
    """Replication 2 has the points of 1 under other numbers, replication 3 half of each."""
    rows = _labelled(
        3, lambda replication, point: 1000 * ((replication == 2) | ((replication == 3) & (point > 9))) + point
    )
    assert calibrate(rows, CalibrationRequest(extended="no")).axes


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_none_are_refused_with_their_row(bad: float) -> None:
    observations = observe(Campaign(replications=2))
    outputs = {"x": np.where(np.arange(observations.rows) == 60, bad, observations.outputs["x"])}
    with refused(r"output x: row 61 \(replication 2, point 12\): got (nan|inf)"):
        calibrate(replace(observations, outputs=outputs), CalibrationRequest(extended="no"))


def test_columns_of_other_lengths_unknown_axes_and_no_rows_are_refused() -> None:
    observations = observe(Campaign(replications=2))
    with refused(r"pitch: got an array of shape \(3,\)"):
        calibrate(replace(observations, pitch_rad=np.zeros(3)), CalibrationRequest(extended="no"))
    with refused("axis w: no outputs; there are x, y, z"):
        calibrate(observations, CalibrationRequest(nominal_axes={"w": "x"}, extended="no"))
    with refused("no rows"):
        calibrate(select_rows(observations, np.zeros(observations.rows, dtype=bool)), CalibrationRequest(extended="no"))
    with refused("weights: row 1.*finite positive number"):
        calibrate(observations, CalibrationRequest(weights=np.zeros(observations.rows), extended="no"))


def test_a_table_uncertainty_that_is_none_is_refused() -> None:
    with refused("pitch: got -1.0 rad, allowed 0 or more"):
        TableUncertainty(-1.0, 0.0)


# Temperature

TC = {"x": (3e-5, 2e-4), "y": (-1e-5, 1e-4), "z": (2e-5, -3e-4)}


def warmed(campaign: Campaign, temperature_degc: np.ndarray, seed: int = 0) -> Observations:
    """Outputs with b(T) = b0 + b1 τ and S(T) = S0 (1 + s1 τ), τ from 25 °C, added to the campaign's."""
    observations = observe(campaign, seed)
    rise = temperature_degc - 25.0
    outputs = {
        axis: output + TC[axis][0] * rise + TC[axis][1] * rise * (output - OFFSET_V[axis])
        for axis, output in observations.outputs.items()
    }
    return replace(observations, outputs=outputs, temperature_degc=temperature_degc)


def mixed_temperatures(rows: int) -> np.ndarray:
    return np.random.default_rng(7).uniform(18.0, 32.0, rows)


@pytest.mark.parametrize("mode", ["apply", "estimate"])
def test_temperature_terms_are_applied_or_recovered_to_ten_digits(mode) -> None:
    observations = warmed(QUIET, mixed_temperatures(147))
    known = {axis: TemperatureCoefficients(*values) for axis, values in TC.items()}
    request = CalibrationRequest(
        temperature=mode, known_temperature=known, reference_temperature_degc=25.0, extended="no"
    )
    for axis, solved in calibrate(observations, request).axes.items():
        values = [p.value for p in solved.parameters]
        np.testing.assert_allclose(values, [*truth(axis), *TC[axis], 25.0], rtol=0, atol=1e-10)
        assert [p.name for p in solved.parameters][4:] == [
            "offset_tc_v_per_degc", "sensitivity_tc_per_degc", "reference_temperature_degc",
        ]  # fmt: skip


TC2 = {"x": (4e-7, -2e-6), "y": (-3e-7, 1e-6), "z": (1e-7, 3e-6)}


@pytest.mark.parametrize("mode", ["apply", "estimate"])
def test_a_sensor_that_bends_with_temperature_is_recovered_to_ten_digits(mode) -> None:
    """b(T) = b0 + b1 τ + b2 τ², S(T) = S0 (1 + s1 τ + s2 τ²), written out."""
    temperature_degc = mixed_temperatures(147)
    plain, rise = warmed(QUIET, temperature_degc), temperature_degc - 25.0
    sensed = {axis: output - OFFSET_V[axis] for axis, output in observe(QUIET).outputs.items()}
    outputs = {a: output + rise**2 * (TC2[a][0] + TC2[a][1] * sensed[a]) for a, output in plain.outputs.items()}
    known = {
        axis: TemperatureCoefficients(*TC[axis], offset_tc2_v_per_degc2=b2, sensitivity_tc2_per_degc2=s2)
        for axis, (b2, s2) in TC2.items()
    }
    request = CalibrationRequest(
        temperature=mode, temperature_order=2 if mode == "estimate" else 1, known_temperature=known,
        reference_temperature_degc=25.0, extended="no",
    )  # fmt: skip
    for axis, solved in calibrate(replace(plain, outputs=outputs), request).axes.items():
        values = [p.value for p in solved.parameters]
        np.testing.assert_allclose(values, [*truth(axis), *TC[axis], *TC2[axis], 25.0], rtol=0, atol=1e-10)
        assert [p.name for p in solved.parameters][6:8] == ["offset_tc2_v_per_degc2", "sensitivity_tc2_per_degc2"]
        if mode == "estimate":
            predicted = model_of_solution(solved).predict(solved.primary, plain)
            np.testing.assert_allclose(predicted, outputs[axis], rtol=0, atol=1e-10)


def test_two_temperatures_do_not_tell_a_bend() -> None:
    two = warmed(QUIET, np.where(np.arange(147) % 3 == 0, 18.0, 30.0))
    with refused("second order cannot be estimated: 12 °C are spanned with nearly nothing between", DesignError):
        calibrate(two, CalibrationRequest(temperature="estimate", temperature_order=2, extended="no"))
    with refused("temperature_order: got 2 with temperature 'none'", DesignError):
        calibrate(two, CalibrationRequest(temperature_order=2))


def test_the_uncertainty_of_known_coefficients_is_carried() -> None:
    """All readings 4 °C above the reference: an error of b1 moves the offset by four times itself."""
    observations = warmed(QUIET, np.full(147, 29.0))
    u_offset = 1e-6
    known = {"x": TemperatureCoefficients(*TC["x"], u_offset, 0.0)}
    request = CalibrationRequest(
        nominal_axes={"x": "x"},
        temperature="apply",
        known_temperature=known,
        reference_temperature_degc=25.0,
        extended="no",
    )
    solved = calibrate(observations, request).axes["x"]
    assert solved.parameters[0].standard_uncertainty == pytest.approx(4.0 * u_offset, rel=1e-6)
    assert solved.primary_covariance[0, 4] == pytest.approx(-4.0 * u_offset**2, rel=1e-6)
    at_29 = np.array([1.0, 0, 0, 0, 4.0, 0])
    assert at_29 @ solved.primary_covariance @ at_29 == pytest.approx(0.0, abs=1e-18)


def test_temperature_is_not_estimated_from_a_narrow_span_or_in_step_with_time() -> None:
    narrow = warmed(QUIET, 20.0 + 0.02 * np.arange(147) % 3.0)
    with refused(r"spans 2\.9\d °C, allowed 5 °C or more", DesignError):
        calibrate(narrow, CalibrationRequest(temperature="estimate", extended="no"))
    rising = warmed(QUIET, 20.0 + 0.1 * np.arange(147))
    with refused("correlation of 1.00.*time in disguise", DesignError):
        calibrate(rising, CalibrationRequest(temperature="estimate", extended="no"))


def test_temperature_terms_without_temperature_or_coefficients_are_refused() -> None:
    observations = observe(QUIET)
    with refused("no temperature was measured"):
        calibrate(observations, CalibrationRequest(temperature="estimate", extended="no"))
    with refused("axis x: no coefficients given", DesignError):
        calibrate(warmed(QUIET, mixed_temperatures(147)), CalibrationRequest(temperature="apply", extended="no"))
    with refused("allowed none, apply, estimate", DesignError):
        calibrate(observations, CalibrationRequest(temperature="guess", extended="no"))


def test_plateaus_take_contrasts_from_the_replications() -> None:
    """Six replications, each a plateau visited from both sides: one of five contrasts goes to the slope."""
    plateaus = np.repeat([15.0, 35.0, 25.0, 33.0, 17.0, 25.0], 49)
    observations = warmed(Campaign(replications=6), plateaus)
    solved = calibrate(
        observations, CalibrationRequest(temperature="estimate", reference_temperature_degc=25.0, extended="no")
    )
    for axis, solved_axis in solved.axes.items():
        dof = next(part.dof for part in solved_axis.variance_components if part.name == "replications")
        assert dof == 4
        for parameter, value in zip(solved_axis.parameters, [*truth(axis), *TC[axis]], strict=False):
            assert abs(parameter.value - value) < 8 * parameter.standard_uncertainty


# Extended model


def softened(campaign: Campaign, q_v_per_g2: float, seed: int = 0) -> Observations:
    """Every output with q (fx² − fz²) added: what a soft mount does."""
    observations = observe(campaign, seed)
    pitch, roll = observations.pitch_rad, observations.roll_rad
    bend = q_v_per_g2 * (np.sin(pitch) ** 2 - (np.cos(pitch) * np.cos(roll)) ** 2)
    return replace(observations, outputs={axis: out + bend for axis, out in observations.outputs.items()})


def test_a_soft_mount_is_found_and_a_stiff_one_is_left_alone() -> None:
    request = CalibrationRequest(nominal_axes={"x": "x"}, table=TABLE, extended="test")
    campaign = Campaign(index_limit_arcsec=1.0, replications=6)
    soft = calibrate(softened(campaign, 1e-4), request).axes["x"]
    values = {p.name: p.value for p in soft.parameters}
    assert soft.model == "pitch-roll-extended"
    assert values["q_xx_v_per_g2"] == pytest.approx(1e-4, rel=0.1)
    assert any("terms of second order are significant" in warning for warning in soft.warnings)
    stiff = calibrate(observe(campaign), request).axes["x"]
    assert stiff.model == "pitch-roll"
    assert not stiff.notes["extension"].is_accepted


def test_the_extended_model_recovers_noise_free_terms_to_ten_digits() -> None:
    found = calibrate(softened(QUIET, 3e-4), CalibrationRequest(extended="yes"))
    for axis, solved in found.axes.items():
        values = [p.value for p in solved.parameters]
        taken = 3e-4 * np.array(solved.centring)[0]
        linear = PitchRoll(axis).parameters(np.array([OFFSET_V[axis], *VECTOR_V_PER_G[axis]]) + taken)
        np.testing.assert_allclose(values, [*linear, 3e-4, 0, 0, 0, 0, 0, truth(axis)[0]], rtol=0, atol=1e-10)


def test_the_extension_is_not_tested_where_it_cannot_be_and_this_is_said() -> None:
    tumble = Campaign(pitch_deg=np.array([-90.0, 0.0, 90.0]), roll_deg=np.array([-180.0, -90.0, 0.0, 90.0]))
    solved = calibrate(observe(tumble), CalibrationRequest(extended="test")).axes["x"]
    assert solved.model == "pitch-roll"
    assert any("terms of second and third order are not determined" in remark for remark in solved.remarks)
    with refused("allowed no, test, yes", DesignError):
        calibrate(observe(tumble), CalibrationRequest(extended="maybe"))


def test_readings_in_another_unit_than_the_model_states_are_refused() -> None:
    observations = replace(observe(QUIET), units={"y": "dps"})
    with pytest.raises(ObservationsError, match=r"axis y: got readings in dps, the model 'pitch-roll' states volts"):
        calibrate(observations, CalibrationRequest())
