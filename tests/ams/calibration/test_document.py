"""The JSON form, key by key, finite or null."""

import json
from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, Campaign

from ams import CalibrationRequest, TableUncertainty, to_document
from ams.calibration.calibrate import calibrate

PARAMETERS = ["offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg"]
QUANTITIES = ["offset", "sensitivity", "coning", "azimuth"]


def document(replications: int = 4, nominal_axes: dict[str, str] | None = None, **settings: float) -> dict:
    observations = Campaign(replications=replications, **settings).observe(np.random.default_rng(3))
    request = CalibrationRequest(
        nominal_axes=nominal_axes or {}, table=TableUncertainty(ARCSEC, ARCSEC, "limit"), extended="no"
    )
    return to_document(calibrate(observations, request))


def test_the_document_has_exactly_the_published_keys() -> None:
    axes = document()["axes"]
    assert list(axes) == ["x", "y", "z"]
    axis = axes["x"]
    assert list(axis) == [
        "parameters", "covariance", "standard_error_v", "degrees_of_freedom", "effective_degrees_of_freedom",
        "sensitive_axis_v_per_g", "replication", "warnings", "remarks",
    ]  # fmt: skip
    assert list(axis["parameters"]) == list(axis["effective_degrees_of_freedom"]) == PARAMETERS
    for parameter in axis["parameters"].values():
        assert list(parameter) == ["value", "standard_uncertainty", "tp_standard_uncertainty"]
    assert list(axis["sensitive_axis_v_per_g"]) == ["x", "y", "z"]
    replication = axis["replication"]
    assert list(replication) == ["n", "points", "lack_of_fit", "drift", "tp"]
    assert list(replication["tp"]) == ["sigma_bias_v", "sigma_prec_v", "t_bias", "f_bias_95", "drift"]
    assert list(replication["drift"]) == list(replication["tp"]["drift"]) == QUANTITIES
    assert list(replication["drift"]["offset"]) == ["t", "f_95"]
    assert (replication["n"], replication["points"], axis["degrees_of_freedom"]) == (4, 49, 4 * 49 - 4)


def test_a_sentence_of_the_package_and_of_an_axis_stands_once() -> None:
    """What a run found on every axis is among the warnings of the package too."""
    rows = Campaign(replications=4).observe(np.random.default_rng(3))
    solved = calibrate(rows, CalibrationRequest(table=TableUncertainty(ARCSEC, ARCSEC, "limit"), extended="no"))
    axes = {label: replace(axis, warnings=("a", "b"), remarks=("r",)) for label, axis in solved.axes.items()}
    twice = to_document(replace(solved, axes=axes, warnings=("c", "a"), remarks=("r", "s")))["axes"]
    assert [(axis["warnings"], axis["remarks"]) for axis in twice.values()] == [(["c", "a", "b"], ["r", "s"])] * 3


def test_covariance_is_in_the_order_and_units_of_the_parameters() -> None:
    axis = document()["axes"]["y"]
    uncertainties = [parameter["standard_uncertainty"] for parameter in axis["parameters"].values()]
    np.testing.assert_allclose(np.sqrt(np.diag(axis["covariance"])), uncertainties)


@pytest.mark.parametrize(
    "settings", [{}, {"noise_arcsec": 0.0}, {"replications": 1}], ids=["plain", "noise-free", "single"]
)
def test_every_number_is_finite_or_null(settings) -> None:
    json.dumps(document(**settings), allow_nan=False)


def test_one_replication_has_no_replication_section() -> None:
    axis = document(replications=1)["axes"]["x"]
    assert axis["replication"] is None
    assert any("one replication only" in warning for warning in axis["warnings"])


def test_a_null_parameter_has_null_rows_in_the_covariance() -> None:
    """Coning of half a degree read with a degree of noise cannot be told from zero."""
    axis = document(noise_arcsec=3600.0)["axes"]["x"]
    assert axis["parameters"]["azimuth_deg"]["value"] is None
    assert axis["parameters"]["azimuth_deg"]["standard_uncertainty"] is None
    assert axis["effective_degrees_of_freedom"]["azimuth_deg"] is None
    assert axis["covariance"][3] == [None] * 4
    assert [row[3] for row in axis["covariance"]] == [None] * 4
    assert axis["replication"]["drift"]["azimuth"] == {"t": None, "f_95": None}
    assert axis["sensitive_axis_v_per_g"]["y"] is not None
