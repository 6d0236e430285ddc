"""Many axes at once: every column is what :func:`ams.calibration.calibrate.calibrate` says of it alone."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, Campaign

from ams.calibration.calibrate import calibrate
from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.calibration_result import AxisCalibration
from ams.inputs.request import CalibrationRequest, select_rows
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.accelerometer import PitchRoll
from ams.models.thermal import TemperatureCoefficients, WithTemperature
from ams.observations import Observations

CAMPAIGN = Campaign(lack_of_fit_arcsec=1.0, offset_drift_arcsec=1.0, index_limit_arcsec=1.0, replications=5)


def observe(seed: int = 0) -> Observations:
    return CAMPAIGN.observe(np.random.default_rng(seed))


def solved(observations: Observations, table: TableUncertainty | None = None) -> SolvedColumns:
    """The three axes of the observations twice over, and one without coning."""
    outputs = np.stack([*observations.outputs.values()] * 2, axis=1)
    aligned = 0.1 + 2.0 * np.sin(observations.pitch_rad) + 1e-5 * np.sin(np.arange(observations.rows))
    models = [PitchRoll(axis) for axis in "xyz"] * 2 + [PitchRoll("x")]
    return solve_columns(observations, np.column_stack([outputs, aligned]), models, table=table)


def check(row: int, found: SolvedColumns, alone: AxisCalibration) -> None:
    np.testing.assert_allclose(found.primary[row], alone.primary, rtol=1e-10)
    np.testing.assert_allclose(found.primary_covariance[row], alone.primary_covariance, rtol=1e-7, atol=1e-20)
    assert found.standard_error_v[row] == pytest.approx(alone.standard_error_v)
    for index, parameter in enumerate(alone.parameters):
        value, half = found.parameters.values[row, index], found.parameters.halfwidths_95[row, index]
        assert (value - half, value + half) == pytest.approx(parameter.interval_95)
    assert alone.replication is not None
    assert found.replication is not None
    pairs = [(found.replication.lack_of_fit, alone.replication.lack_of_fit)]
    pairs += [(found.replication.drift[name], test) for name, test in alone.replication.drift.items()]
    pairs += [(found.replication.tp.drift[name], test) for name, test in alone.replication.tp.drift.items()]
    for columns, test in pairs:
        assert (columns.t[row], columns.p_value[row]) == pytest.approx((test.t, test.p_value), rel=1e-6, abs=1e-12)
        assert columns.is_significant[row] == test.is_significant


def test_each_of_many_columns_is_what_it_is_alone() -> None:
    """More than are worked on at one stroke, every seventh read by a meter whose step is large beside the noise."""
    observations, chance = observe(), np.random.default_rng(3)
    outputs = observations.outputs["x"][:, None] + 1e-5 * chance.standard_normal((observations.rows, 130))
    outputs[:, ::7] = np.round(outputs[:, ::7], 3)
    model = PitchRoll("x")
    together = solve_columns(observations, outputs, [model] * 130)
    assert {part.name for part in together.components} >= {"resolution"}
    for column in (0, 1, 63, 64, 70, 127, 128, 129):
        alone = solve_columns(observations, outputs[:, column : column + 1], [model])
        np.testing.assert_allclose(together.primary[column], alone.primary[0], rtol=1e-12)
        covariance = alone.primary_covariance[0]  # of which most parts are zero but for rounding
        tiny = 1e-15 * float(covariance.max())
        np.testing.assert_allclose(together.primary_covariance[column], covariance, rtol=1e-9, atol=tiny)
        assert together.replication is not None
        assert alone.replication is not None
        assert together.replication.lack_of_fit.t[column] == pytest.approx(alone.replication.lack_of_fit.t[0])


@pytest.mark.parametrize("table", [None, TableUncertainty(ARCSEC, ARCSEC, "limit")])
@pytest.mark.parametrize("kept", [1.0, 0.9])
def test_a_column_among_others_is_the_axis_calibrated_alone(table, kept) -> None:
    observations = observe()
    observations = select_rows(observations, np.random.default_rng(1).uniform(size=observations.rows) < kept)
    found = solved(observations, table)
    for row, axis in enumerate("xyzxyz"):
        alone = calibrate(observations, CalibrationRequest(nominal_axes={axis: axis}, table=table, extended="no")).axes[
            axis
        ]
        check(row, found, alone)


def test_what_cannot_be_determined_is_nan_in_its_row_only() -> None:
    found = solved(observe())
    assert np.isnan(found.parameters.values[6, 2:]).all()
    assert set(found.parameters.undetermined[6]) == {"coning_deg", "azimuth_deg"}
    assert np.isfinite(found.parameters.values[:6]).all()
    assert np.isfinite(found.parameters.values[6, :2]).all()
    assert found.replication is not None
    assert np.isnan(found.replication.drift["azimuth"].t[6])
    assert np.isfinite(found.replication.drift["azimuth"].t[:6]).all()


def test_the_order_of_the_rows_does_not_matter() -> None:
    observations = observe()
    shuffle = np.random.default_rng(2).permutation(observations.rows)
    moved = replace(
        observations,
        **{name: getattr(observations, name)[shuffle] for name in ("replication", "point", "pitch_rad", "roll_rad")},
        outputs={axis: output[shuffle] for axis, output in observations.outputs.items()},
    )
    table = TableUncertainty(ARCSEC, ARCSEC, "limit")
    first, again = solved(observations, table), solved(moved, table)
    np.testing.assert_allclose(again.primary[:6], first.primary[:6], rtol=1e-10)
    np.testing.assert_allclose(again.primary_covariance[:6], first.primary_covariance[:6], rtol=1e-6, atol=1e-20)


def test_a_common_error_is_carried_alike_where_the_basis_repeats_and_where_not() -> None:
    """The temperature is the same in every replication, or follows the rows: the uncertainty of b1 acts alike."""
    observations = observe()
    model = WithTemperature(PitchRoll("x"), 20.0, TemperatureCoefficients(1e-5, 0.0, 1e-6, 0.0))
    found = []
    for wobble in (0.0, 1e-9):
        warm = replace(observations, temperature_degc=24.0 + wobble * np.arange(observations.rows))
        columns = solve_columns(warm, observations.outputs["x"][:, None], [model])
        found.append(next(part.covariance[0] for part in columns.components if part.name == "temperature"))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-18)
    assert found[0][0, 0] == pytest.approx((4e-6) ** 2, rel=1e-6)
