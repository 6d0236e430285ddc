"""What the axes of a package have in common reaches inferred angles by two ways alike: the solution, and its set."""

from dataclasses import replace

import numpy as np
import pytest
from joint_campaigns import mountings_of
from physics_scenes.designs import Setup
from physics_scenes.mounting_scenes import Sizes, remounted
from physics_scenes.tables import once_per_turn
from scipy.stats import t as student_t
from simulated_campaign import ARCSEC, OFFSET_V, VECTOR_V_PER_G, Campaign
from solved_sets import SITE, package_set
from stated_lines import line_sensor, sensors_as_solved

from ams.attitude.static import Angles, pitch_roll_from_three
from ams.calibration.calibrate import calibrate
from ams.calibration.joint_diagnosis import diagnose_joint
from ams.calibration.joint_document import joint_calibration
from ams.calibration_result import Calibration, VarianceComponent
from ams.frames import Attitude, specific_force
from ams.inference.inference import Package, inference
from ams.inference.package.calibrated import CalibratedPackage, package_of_set, sensor_of_set
from ams.inference.package.packages import SpreadAngles, angles_from_packages
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty
from ams.models.cr import model_gravity_g, sting_gravity_g
from ams.sets.canonical import with_checksum
from ams.sets.coefficients import CoefficientSet, build_set, from_document
from ams.sets.provenance import Provenance
from ams.solve.joint import joint_fit
from ams.solve.table_errors import TablePriors

PITCH, ROLL = np.deg2rad([5.0, 20.0, -40.0]), np.deg2rad([45.0, -30.0, 120.0])
FORCE = specific_force(PITCH, ROLL)
OUTPUTS_V = np.stack([OFFSET_V[axis] + FORCE @ VECTOR_V_PER_G[axis] for axis in "xyz"], axis=-1)
READING_SD_V = 1e-7
TEETH = TableUncertainty(
    5 * ARCSEC, 5 * ARCSEC, "limit", errors=dict.fromkeys(("pitch", "roll"), IndexErrors("independent"))
)


def solved() -> Calibration:
    observations = Campaign(index_limit_arcsec=5.0, noise_arcsec=0.2).observe(np.random.default_rng(0))
    return calibrate(observations, CalibrationRequest(extended="no", table=TEETH))


def set_of(calibration: Calibration) -> CoefficientSet:
    ranges = {"pitch_range_deg": (-90.0, 90.0), "roll_range_deg": (-180.0, 180.0)}
    return build_set(calibration, Provenance("P1", **SITE, **ranges))


def by_set(coefficients: CoefficientSet, *, is_lacking: bool = False) -> Angles:
    """With the noise of a reading alone, or with what every axis lacks of its model beside it."""
    lacks_v = {axis: coefficients.document["axes"][axis]["replication"]["lack_of_fit_v"] for axis in "xyz"}
    noise_v = {axis: float(np.hypot(READING_SD_V, lacks_v[axis] if is_lacking else 0.0)) for axis in "xyz"}
    sensors = [sensor_of_set(coefficients, axis, noise_v[axis], None) for axis in "xyz"]
    return pitch_roll_from_three(sensors, OUTPUTS_V, package_of_set(coefficients, "xyz", sensors))


def test_a_solution_and_its_set_give_the_same_intervals() -> None:
    calibration = solved()
    assert calibration.package is not None
    sensors = sensors_as_solved(calibration, READING_SD_V)
    package = CalibratedPackage(sensors, calibration.package.components)
    as_solved, of_set = pitch_roll_from_three(sensors, OUTPUTS_V, package), by_set(set_of(calibration))
    for name in ("pitch_rad", "roll_rad", "pitch_sd_rad", "roll_sd_rad", "pitch_half_95_rad", "roll_half_95_rad"):
        np.testing.assert_allclose(getattr(as_solved, name), getattr(of_set, name), rtol=1e-9)


def test_a_set_that_does_not_say_what_is_common_counts_its_axes_as_independent() -> None:
    """At 45° of roll y and z share the error of the index: independent they would look up to √2 better."""
    coefficients = set_of(solved())
    document = {name: value for name, value in coefficients.document.items() if name not in ("package", "checksum")}
    older = by_set(from_document(with_checksum(document), "older"))
    assert by_set(coefficients).roll_sd_rad[0] / older.roll_sd_rad[0] == pytest.approx(1.3, abs=0.1)


def test_some_axes_of_a_package_keep_their_own_share() -> None:
    coefficients = set_of(solved())
    sensors = [sensor_of_set(coefficients, axis, READING_SD_V, None) for axis in "zx"]
    package = package_of_set(coefficients, "zx", sensors)
    assert package is not None
    whole = sum(covariance for covariance, _ in package.output_parts(FORCE))
    for index, sensor in enumerate(sensors):
        np.testing.assert_allclose(
            whole[:, index, index], sensor.output_variance_v2(FORCE) - READING_SD_V**2, rtol=1e-9
        )
    assert package_of_set(coefficients, "x", sensors[1:]) is None


def test_crs_sets_sense_gravity_in_their_covariance_too() -> None:
    coefficients = package_set("sting")
    sensors = [sensor_of_set(coefficients, axis, 1e-5, None) for axis in "xyz"]
    package = package_of_set(coefficients, "xyz", sensors)
    assert package is not None
    variances = np.diagonal(sum(covariance for covariance, _ in package.output_parts(FORCE)), axis1=1, axis2=2)
    own = np.stack([sensor.output_variance_v2(FORCE) - 1e-10 for sensor in sensors], axis=1)
    np.testing.assert_allclose(variances, own, rtol=1e-6, atol=1e-20)


def test_the_inference_of_a_set_uses_it() -> None:
    coefficients = set_of(solved())
    how = inference(Package(coefficients, {axis: f"{axis}_v" for axis in "xyz"}), reading_sd_v=READING_SD_V)
    found = how.infer({f"{axis}_v": OUTPUTS_V[:, index] for index, axis in enumerate("xyz")})
    np.testing.assert_allclose(
        np.deg2rad(found["roll_sd_deg"]), by_set(coefficients, is_lacking=True).roll_sd_rad, rtol=1e-9
    )


def test_intervals_stand_after_the_standard_deviations_where_they_are_asked_for() -> None:
    coefficients = set_of(solved())
    package = Package(coefficients, {axis: f"{axis}_v" for axis in "xyz"})
    readings = {f"{axis}_v": OUTPUTS_V[:, index] for index, axis in enumerate("xyz")}
    found = inference(package, reading_sd_v=READING_SD_V, intervals=True).infer(readings)
    assert list(found) == [
        "pitch_deg", "pitch_sd_deg", "pitch_half_95_deg", "roll_deg", "roll_sd_deg", "roll_half_95_deg", "flag"
    ]  # fmt: skip
    expected = by_set(coefficients, is_lacking=True).roll_half_95_rad
    np.testing.assert_allclose(np.deg2rad(found["roll_half_95_deg"]), expected, rtol=1e-9)
    assert np.all(found["roll_half_95_deg"] > 1.95 * found["roll_sd_deg"])


def calibrated(chance: np.random.Generator, dofs: tuple[float, ...]) -> CalibratedPackage:
    """Return three lines of whose parts each has degrees of freedom of its own and ties the axes together."""
    parts = []
    for dof in dofs:
        root = 2e-4 * chance.standard_normal((12, 12)) / np.sqrt(12.0)
        parts.append(VarianceComponent(f"on {dof:g}", root @ root.T, dof))

    def own(axis: int) -> tuple[VarianceComponent, ...]:
        block = slice(4 * axis, 4 * axis + 4)
        return tuple(replace(part, covariance=part.covariance[block, block]) for part in parts)

    lines = [
        line_sensor(0.0, 2.5 * unit, np.asarray(sum(part.covariance for part in own(axis))), 1e-9, own(axis))
        for axis, unit in enumerate(np.eye(3))
    ]
    return CalibratedPackage(lines, parts)


def test_every_angle_of_two_packages_has_the_degrees_of_freedom_of_what_it_takes_from() -> None:
    """Welch and Satterthwaite by hand, on slopes by differences: ν = (Σ u²)² / Σ u⁴/ν, and Student's factor of that.

    (With one or two behind a part the factors are averaged instead, as Cochran and Cox have it.)
    """
    chance = np.random.default_rng(12)
    sting, model = calibrated(chance, (4.0, 7.0, np.inf)), calibrated(chance, (5.0, 9.0, 20.0))
    pitch, yaw, roll = np.deg2rad([[30.0], [20.0], [40.0]])
    gravity = sting_gravity_g(pitch, yaw)
    forces = -gravity, -model_gravity_g(gravity, roll)
    outputs = [force @ np.stack([line.k_v_per_g for line in package.sensors]).T
               for force, package in zip(forces, (sting, model), strict=True)]  # fmt: skip

    def angles(volts: list[np.ndarray]) -> SpreadAngles:
        return angles_from_packages(sting.sensors, model.sensors, *volts, (sting, model))

    names, found = ("pitch", "yaw", "roll"), angles(outputs)
    slopes = np.zeros((3, 2, 3))
    for package in range(2):
        for axis in range(3):
            ends = []
            for step in (1e-5, -1e-5):
                moved = [volts.copy() for volts in outputs]
                moved[package][0, axis] += step
                ends.append(np.array([getattr(angles(moved), f"{name}_rad")[0] for name in names]))
            slopes[:, package, axis] = (ends[0] - ends[1]) / 2e-5
    for row, name in enumerate(names):
        variances, dofs = [], []
        for package, (lines, force) in enumerate(zip((sting, model), forces, strict=True)):
            for covariance, dof in lines.output_parts(force):
                variances.append(slopes[row, package] @ covariance[0] @ slopes[row, package])
                dofs.append(dof)
        u2, dof = sum(variances), 1.0 / sum((v / sum(variances)) ** 2 / d for v, d in zip(variances, dofs, strict=True))
        assert dof < 100.0
        np.testing.assert_allclose(getattr(found, f"{name}_sd_rad")[0], np.sqrt(u2), rtol=1e-3)
        half = getattr(found, f"{name}_half_95_rad")[0]
        np.testing.assert_allclose(half, student_t.ppf(0.975, dof) * np.sqrt(u2), rtol=3e-3)


def test_every_angle_of_a_joint_fit_has_the_degrees_of_freedom_of_what_it_takes_from() -> None:
    """By hand as above: six degrees between replications, the points' own, and the table, which is declared."""
    sizes = Sizes(drift_arcsec=1.0, drift_ppm=5.0)
    setup = Setup(replications=4, roll_count=6, noise_arcsec=0.5)
    mountings = mountings_of(remounted(once_per_turn, sizes, setup, 1, np.random.default_rng(3)), 0)
    priors = TablePriors(table=TableUncertainty(ARCSEC, ARCSEC, "limit"), seat_rad=5.0 * ARCSEC)
    fit = joint_fit(mountings, "xyz", priors)
    assert sorted(part.dof for part in fit.components)[0] == 6.0
    told = inference(
        Package(set_of(joint_calibration(fit, diagnose_joint(mountings, fit, priors))), {a: f"{a}_v" for a in "xyz"}),
        reading_sd_v=1e-9,
        intervals=True,
    )
    at = Attitude(*np.deg2rad([[25.0], [35.0]]))
    models = [fit.sensors[axis].model for axis in fit.axes]
    outputs_v = [model.predict(fit.primary[model.nominal_axis], at) for model in models]

    def angles(moved_v: np.ndarray) -> dict[str, np.ndarray]:
        read = {f"{a}_v": v + step for a, v, step in zip("xyz", outputs_v, moved_v, strict=True)}
        return {name: np.deg2rad(column) for name, column in told.answer(read).columns.items() if name.endswith("deg")}

    found = angles(np.zeros(3))
    for name in ("pitch", "roll"):
        slopes = [(angles(step)[f"{name}_deg"] - angles(-step)[f"{name}_deg"])[0] / 2e-5 for step in 1e-5 * np.eye(3)]
        columns = [model.jacobian(fit.primary[model.nominal_axis], at)[0] for model in models]
        direction = np.concatenate([slope * column for slope, column in zip(slopes, columns, strict=True)])
        u2 = np.array([direction @ part.covariance @ direction for part in fit.components])
        dof = 1.0 / np.sum((u2 / u2.sum()) ** 2 / np.array([part.dof for part in fit.components]))
        assert 6.0 < dof < 100.0
        half = student_t.ppf(0.975, dof) * np.sqrt(u2.sum())
        np.testing.assert_allclose(found[f"{name}_half_95_deg"][0], half, rtol=0.01)
