"""A model that is no part of the package goes through every solver as the package's own do, and once it is installed
through the command, sets, exports and attitude (examples/own_model)."""

import importlib.util
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from c_program import needs_compiler, printed
from command import call
from example_files import ROOT
from installed_examples import install_example
from solved import provenance

from ams import CalibrationRequest, TableUncertainty, apply, build_set, load_set, to_document
from ams.analysis.advice import advise
from ams.analysis.predictions import confidence_halfwidth_v
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.errors import DesignError
from ams.exports.c_header import to_c_header
from ams.exports.formats import FORMATS
from ams.frames import Attitude
from ams.inference.inference import Package, inference
from ams.inputs.table_uncertainty import IndexErrors
from ams.models.model import Model
from ams.models.registry import MODELS
from ams.observations import Observations
from procedures.kinds.read import read_procedure
from procedures.plan.attitudes import make_design

FILE = ROOT / "examples" / "own_model" / "stiffening.py"
TRUTH = np.array([0.01, 2.5, -0.02, 0.3])
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


def test_before_it_is_installed_no_solver_knows_it(model: Model) -> None:
    assert model.name not in MODELS


def test_its_jacobian_is_that_of_a_complex_step(example: ModuleType, model: Model) -> None:
    rows = example.measured(TRUTH, 0.0, np.random.default_rng(0), replications=1)
    exact = np.stack([np.imag(model.predict(TRUTH + 1e-30j * unit, rows)) / 1e-30 for unit in np.eye(4)], axis=1)
    np.testing.assert_allclose(model.jacobian(TRUTH, rows), exact, rtol=1e-12)


def test_the_truth_comes_back_to_ten_digits_from_its_own_start(example: ModuleType, model: Model) -> None:
    axis = solved(example.measured(TRUTH, 0.0, np.random.default_rng(0)), model)
    found = [parameter.value for parameter in axis.parameters]
    np.testing.assert_allclose(found, TRUTH, rtol=0.0, atol=1e-10)
    assert axis.model == "stiffening-clinometer"


def test_its_intervals_hold_the_truth(example: ModuleType, model: Model) -> None:
    rng, truth = np.random.default_rng(4), TRUTH
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
    entry = rows.replication == 1
    slopes = model.angle_jacobian(TRUTH, rows)["pitch"][entry]
    basis = model.jacobian(TRUTH, rows)[entry] / slopes[:, None]
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


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.delitem(sys.modules, "stiffening", raising=False)
    yield install_example("own_model", tmp_path / "site", monkeypatch)
    sys.modules.pop("stiffening", None)


def written(example: ModuleType, folder: Path) -> Path:
    """Observations as a file for `calrig fit`."""
    rows = example.measured(TRUTH, 2e-5, np.random.default_rng(3))
    path = folder / "observations.csv"
    lines = ["replication,point,pitch_deg,sx_v"]
    angles = np.rad2deg(rows.pitch_rad)
    for index in range(rows.rows):
        cells = (
            rows.replication[index],
            rows.point[index],
            f"{angles[index]:.6f}",
            f"{rows.outputs['x'][index]:.9f}",
        )
        lines.append(",".join(map(str, cells)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.usefixtures("installed")
def test_the_command_takes_it_from_observations_to_sets_exports_and_angles(
    example: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "SN9.json"
    fitted = call(
        capsys, "fit", written(example, tmp_path), "--model", "stiffening-clinometer", "--axis", "x=sx_v",
        "--set", path, "--sensor", "SN9", "--gravity-mps2", "9.81", "--json",
    )  # fmt: skip
    assert fitted.status == 0, fitted.err
    found = fitted.document["axes"]["x"]["parameters"]
    assert found["stiffening_v_per_g"]["value"] == pytest.approx(-0.02, abs=2e-4)
    for name in ("json", "csv", "mat", "epics", "dcc", "c"):
        target = tmp_path / f"out{FORMATS[name].ending}"
        exported = call(capsys, "export", path, "--to", name, "--out", target)
        assert exported.status == 0, exported.err
        assert call(capsys, "verify", target).status == 0
    for name in ("c-fixed", "linear"):
        refused = call(capsys, "export", path, "--to", name)
        assert refused.status == 2
        assert "nothing was written" in refused.err
    pitch_deg = np.array([-50.0, 0.0, 12.5])
    coefficients = load_set(path)
    outputs = apply(coefficients, np.deg2rad(pitch_deg), 0.0)["x"]
    np.testing.assert_allclose(outputs, example.StiffeningClinometer().predict(TRUTH, Attitude(
        np.deg2rad(pitch_deg), np.zeros(3))), atol=5e-5)  # fmt: skip
    answers = inference(Package(coefficients, {"x": "sx_v"}), reading_sd_v=2e-5).infer({"sx_v": outputs})
    np.testing.assert_allclose(answers["pitch_deg"], pitch_deg, atol=1e-9)
    assert np.all(np.asarray(answers["pitch_sd_deg"]) < 0.01)


@needs_compiler
@pytest.mark.usefixtures("installed")
def test_its_header_tests_itself(example: ModuleType, tmp_path: Path) -> None:
    calibration = calibrate(
        example.measured(TRUTH, 2e-5, np.random.default_rng(3)),
        CalibrationRequest(nominal_axes={"x": "x"}, model="stiffening-clinometer"),
    )
    header = to_c_header(build_set(calibration, replace(provenance(), sensor="SN9")))
    assert b"CALRIG_SN9_X_STIFFENING_V_PER_G" in header
    [[largest]] = printed(tmp_path, {"SN9.h": header}, 'printf("%.17g\\n", calrig_sn9_self_test());')
    assert largest <= 1e-12


@pytest.mark.usefixtures("installed")
def test_a_tumble_for_it_has_the_four_attitudes_without_roll(tmp_path: Path) -> None:
    (tmp_path / "procedure.toml").write_text(
        '[procedure]\ntitle = "own"\nkind = "tumble"\nreplications = 2\n[design]\nkind = "T"\n'
        '[solve]\nmodel = "stiffening-clinometer"\nextended = "no"\n',
        encoding="utf-8",
    )
    points = make_design(read_procedure(tmp_path / "procedure.toml")).points
    assert [(point.pitch_deg, point.roll_deg) for point in points] == [(-90, 0), (0, 0), (90, 0), (180, 0)]


@pytest.mark.usefixtures("installed")
def test_a_run_is_checked_and_solved_with_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = (ROOT / "examples" / "rig.toml").read_text(encoding="utf-8")
    one_axis = rig.replace("three-axis package", "single-axis package").replace(
        'channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }', 'channels = { x = "dmm.x" }'
    )
    assert one_axis != rig
    (tmp_path / "rig.toml").write_text(one_axis, encoding="utf-8")
    (tmp_path / "procedure.toml").write_text(
        '[procedure]\ntitle = "own model"\nkind = "grid"\nreplications = 2\n[design]\nkind = "D"\n'
        "pitch_deg = { from = -60.0, to = 60.0, step = 20.0 }\n[dwell]\nsamples = 5\n"
        '[solve]\nmodel = "stiffening-clinometer"\nextended = "no"\n',
        encoding="utf-8",
    )
    files = (tmp_path / "procedure.toml", "--rig", tmp_path / "rig.toml")
    checked = call(capsys, "check", *files, "--json")
    assert checked.status == 0, checked.err
    assert "stiffening" in checked.document["parameters"]
    ran = call(capsys, "run", *files, "--out", tmp_path / "runs", "--json")
    assert ran.status == 0, ran.err
    found = ran.document["sensors"]["SN1047"]["axes"]["x"]["parameters"]["sensitivity_v_per_g"]
    assert abs(found["value"] - 2.5) < 0.05
    coefficients = load_set(Path(ran.document["sets"][0]))
    pitch_deg = np.array([-40.0, 0.0, 33.0])
    outputs = {"x_v": apply(coefficients, np.deg2rad(pitch_deg), 0.0)["x"], "roll_deg": np.full(3, 50.0)}
    answers = inference(Package(coefficients, {"x": "x_v"}), reading_sd_v=2e-5).infer(outputs)
    np.testing.assert_allclose(answers["pitch_deg"], pitch_deg, atol=1e-9)
