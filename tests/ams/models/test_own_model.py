"""A model that is no part of the package goes through every solver as the package's own do (examples/own_model.py)."""

import importlib.util
import sys
from types import ModuleType

import numpy as np
import pytest
from example_files import ROOT

from ams import CalibrationRequest, TableUncertainty, to_document
from ams.analysis.advice import advise
from ams.analysis.predictions import confidence_halfwidth_v
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.errors import DesignError
from ams.inputs.table_uncertainty import IndexErrors
from ams.models.model import Model
from ams.models.registry import MODELS
from ams.observations import Observations

FILE = ROOT / "examples" / "own_model.py"
TRUTH = np.array([0.01, 2.5, -0.02, np.deg2rad(0.3)])
ARCSEC = np.pi / 180.0 / 3600.0


@pytest.fixture(scope="module")
def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("own_model", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["own_model"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def model(example: ModuleType) -> Model:
    return example.StiffeningClinometer()


def solved(rows: Observations, model: Model, table: TableUncertainty | None = None) -> AxisCalibration:
    request = CalibrationRequest(nominal_axes={"x": "x"}, models={"x": model}, table=table, extended="no")
    return calibrate(rows, request).axes["x"]


def test_no_solver_knows_it(model: Model) -> None:
    assert model.name not in MODELS


def test_its_jacobian_is_that_of_a_complex_step(example: ModuleType, model: Model) -> None:
    rows = example.measured(TRUTH, 0.0, np.random.default_rng(0), replications=1)
    exact = np.stack([np.imag(model.predict(TRUTH + 1e-30j * unit, rows)) / 1e-30 for unit in np.eye(4)], axis=1)
    np.testing.assert_allclose(model.jacobian(TRUTH, rows), exact, rtol=1e-12)


def test_the_truth_comes_back_to_ten_digits_from_its_own_start(example: ModuleType, model: Model) -> None:
    axis = solved(example.measured(TRUTH, 0.0, np.random.default_rng(0)), model)
    found = [parameter.value for parameter in axis.parameters]
    np.testing.assert_allclose(found, [*TRUTH[:3], 0.3], rtol=0.0, atol=1e-10)
    assert axis.model == "stiffening-clinometer"


def test_its_intervals_hold_the_truth(example: ModuleType, model: Model) -> None:
    rng, truth = np.random.default_rng(4), np.array([*TRUTH[:3], 0.3])
    hits = []
    for _ in range(300):
        axis = solved(example.measured(TRUTH, 2e-5, rng), model)
        ends = np.array([parameter.interval_95 for parameter in axis.parameters])
        hits.append((ends[:, 0] < truth) & (truth < ends[:, 1]))
    assert np.mean(hits) == pytest.approx(0.95, abs=0.025)


def test_the_tables_indices_reach_it_through_its_slopes(example: ModuleType, model: Model) -> None:
    """Every index of ±1″ is off by itself: with no other noise S and φ are as uncertain as least squares makes them."""
    rows = example.measured(TRUTH, 0.0, np.random.default_rng(0))
    axis = solved(rows, model, TableUncertainty(ARCSEC, 0.0, "limit", errors={"pitch": IndexErrors("independent")}))
    one = rows.replication == 1
    slopes = model.angle_jacobian(TRUTH, rows)["pitch"][one]
    basis = model.jacobian(TRUTH, rows)[one] / slopes[:, None]
    expected = np.sqrt(np.diag(np.linalg.inv(basis.T @ basis)) * ARCSEC**2 / 3.0)
    np.testing.assert_allclose(np.sqrt(np.diag(axis.primary_covariance)), expected, rtol=1e-3)


def test_documents_and_advice_are_made_for_it(example: ModuleType, model: Model) -> None:
    rows = example.measured(TRUTH, 2e-5, np.random.default_rng(2))
    calibration = calibrate(rows, CalibrationRequest(nominal_axes={"x": "x"}, models={"x": model}, extended="no"))
    section = to_document(calibration)["axes"]["x"]  # type: ignore[index]
    assert list(section["parameters"]) == list(model.parameter_names)
    assert set(section["replication"]["drift"]) == {
        "offset", "sensitivity", "stiffening", "pitch_misalignment",
    }  # fmt: skip
    assert advise(calibration.axes["x"], rows).sentences is not None


def test_where_its_object_is_needed_the_refusal_says_so(example: ModuleType, model: Model) -> None:
    rows = example.measured(TRUTH, 2e-5, np.random.default_rng(2))
    with pytest.raises(DesignError, match="no model is known by the name 'stiffening-clinometer'"):
        confidence_halfwidth_v(solved(rows, model), rows)  # type: ignore[arg-type]


def test_the_example_runs_and_tells_what_it_found(example: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    example.main()
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("pitch_misalignment_deg"))
    value, _, uncertainty = line.split()[1:4]
    assert float(value) == pytest.approx(0.3, abs=4.0 * float(uncertainty))
