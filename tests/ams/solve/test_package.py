"""The covariance between the axes of a package: against the spread of simulated campaigns, and where it is zero."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, OFFSET_V, VECTOR_V_PER_G, Campaign
from simulated_columns import Scene
from simulated_package import PACKAGE, simulate_packages

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.thermal import TemperatureCoefficients
from ams.solve.components import ComponentColumns
from ams.solve.package import SolvedAxis, package_covariance


def correlation(covariance: np.ndarray) -> np.ndarray:
    spread = np.sqrt(np.diag(covariance))
    return covariance / np.outer(spread, spread)


@pytest.mark.parametrize(
    "scene",
    [Scene(index_limit_arcsec=3.0), Scene(index_limit_arcsec=1.0, lack_of_fit=1.5, drift=2.0)],
    ids=["table", "everything"],
)
def test_what_axes_have_in_common_is_what_simulated_campaigns_show(scene: Scene) -> None:
    simulated = simulate_packages(scene, 1000, np.random.default_rng(0))
    shown = np.cov((simulated.primary - PACKAGE).reshape(-1, 12).T)
    said = sum(covariance for covariance, _ in simulated.components().values()).mean(axis=0)
    np.testing.assert_allclose(np.diag(said), np.diag(shown), rtol=0.25)
    np.testing.assert_allclose(correlation(said), correlation(shown), atol=0.12)
    if not scene.drift:
        assert abs(correlation(shown)[:8, 8:]).max() > 0.8  # treating the axes as independent would lose this


def test_one_package_at_a_time_is_the_same_as_all_at_once() -> None:
    simulated = simulate_packages(Scene(index_limit_arcsec=1.0, lack_of_fit=2.0), 5, np.random.default_rng(1))
    stacked = simulated.components()
    names = simulated.solved.problem.model.primary_names
    axes = [SolvedAxis(label, names, simulated.solved.components, 6 + row) for row, label in enumerate("xyz")]
    found = package_covariance(axes)
    assert found is not None
    assert found.order[5] == ("y", "k_x_v_per_g")
    for part in found.components:
        np.testing.assert_allclose(part.covariance, stacked[part.name][0][2], rtol=1e-9, atol=1e-22)


def test_the_blocks_of_the_axes_are_their_own_covariances() -> None:
    observations = Campaign(index_limit_arcsec=1.0, lack_of_fit_arcsec=1.0).observe(np.random.default_rng(2))
    solved = calibrate(observations, CalibrationRequest(table=TableUncertainty(ARCSEC, ARCSEC, "limit"), extended="no"))
    assert solved.package is not None
    for index, axis in enumerate(solved.axes.values()):
        block = solved.package.covariance[4 * index : 4 * index + 4, 4 * index : 4 * index + 4]
        np.testing.assert_allclose(block, axis.primary_covariance, rtol=1e-12)
    assert np.linalg.eigvalsh(correlation(solved.package.covariance))[0] > -1e-12
    alone = calibrate(observations, CalibrationRequest(nominal_axes={"x": "x"}, extended="no"))
    assert alone.package is None


def test_a_part_has_the_fewest_degrees_of_freedom_that_any_axis_has_of_it() -> None:
    """What is inferred from several axes is told no better than by the worst known of them."""
    covariance = np.stack([np.eye(2)] * 2)
    parts = [ComponentColumns("lack-of-fit", covariance, np.array([9.0, 4.0]))]
    axes = [SolvedAxis(label, ("offset_v", "k_x_v_per_g"), parts, row) for row, label in enumerate("xy")]
    found = package_covariance(axes)
    assert found is not None
    assert [part.dof for part in found.components] == [4.0]


def test_a_disturbance_of_the_package_is_seen_in_all_axes() -> None:
    """Half a microvolt per replication on every axis at once: the offsets of x and z hang together."""
    observations = Campaign(replications=12, noise_arcsec=0.05).observe(np.random.default_rng(3))
    jumps = np.random.default_rng(4).normal(0.0, 1e-4, 13)[observations.replication]
    moved = {axis: output + jumps for axis, output in observations.outputs.items()}
    solved = calibrate(replace(observations, outputs=moved), CalibrationRequest(extended="no"))
    assert solved.package is not None
    assert correlation(solved.package.covariance)[0, 8] > 0.99


def test_lack_of_fit_is_common_where_the_residuals_are() -> None:
    observations = Campaign(noise_arcsec=0.05).observe(np.random.default_rng(5))
    own = np.random.default_rng(6).normal(0.0, 1e-4, (3, observations.point.max() + 1))[:, observations.point]
    for same, expected in ((True, 0.98), (False, 0.0)):
        outputs = {a: v + own[0 if same else i] for i, (a, v) in enumerate(observations.outputs.items())}
        package = calibrate(replace(observations, outputs=outputs), CalibrationRequest(extended="no")).package
        assert package is not None
        part = next(part for part in package.components if part.name == "lack-of-fit")
        assert correlation(part.covariance)[0, 4] == pytest.approx(expected, abs=0.35 if not same else 0.02)


def test_temperature_coefficients_and_resistors_belong_to_one_axis_levels_and_meters_to_all() -> None:
    observations = replace(
        (campaign := Campaign()).observe(np.random.default_rng(7)),
        temperature_degc=np.full(campaign.replications * 49, 24.0),
    )
    known = dict.fromkeys("xyz", TemperatureCoefficients(3e-6, 2e-5, 1e-6, 1e-5))
    errors = (
        SharedError("load resistor", "gain", 1e-5, is_of_one_channel=True),
        SharedError("meter", "gain", 1e-5),
        SharedError("level", "pitch", ARCSEC),
    )
    request = CalibrationRequest(
        temperature="apply", known_temperature=known, reference_temperature_degc=20.0,
        shared_errors=dict.fromkeys("xyz", errors), extended="no",
    )  # fmt: skip
    package = calibrate(observations, request).package
    assert package is not None
    parts = {part.name: part.covariance for part in package.components}
    size = package.covariance.shape[0] // 3
    between = {name: abs(covariance[:size, size:]).max() for name, covariance in parts.items()}
    assert between["temperature"] == between["load resistor"] == 0.0
    assert correlation(parts["meter"] + 1e-30 * np.eye(3 * size))[1, size + 2] == pytest.approx(-1.0, abs=1e-3)
    assert correlation(parts["level"] + 1e-30 * np.eye(3 * size))[3, 2 * size + 1] == pytest.approx(-1.0, abs=1e-3)


def test_the_simulation_has_the_package_of_the_other_one() -> None:
    for row, axis in enumerate("xyz"):
        np.testing.assert_array_equal(PACKAGE[row, 1:], VECTOR_V_PER_G[axis])
        assert PACKAGE[row, 0] == OFFSET_V[axis]
