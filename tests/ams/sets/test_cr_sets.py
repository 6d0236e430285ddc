"""Sets of CR's packages and gyros: applied against explicit rotations, sealed, refused where misused."""

import json
from pathlib import Path

import numpy as np
import pytest
from changed_sets import write_changed
from cr_outputs import TABLE_4, accelerometer_v, gyro_v
from simulated_campaign import Campaign
from solved import provenance
from solved_sets import TRUTH, gyro_set, package_set

from ams.calibration.calibrate import calibrate
from ams.errors import OutsideValidity, SetError
from ams.exports.formats import export_set, load_set
from ams.exports.verify import verify
from ams.finding_kinds import FINDING_KINDS
from ams.inputs.request import CalibrationRequest
from ams.sets.apply import apply
from ams.sets.coefficients import build_set
from ams.sets.schema import check_identity


@pytest.mark.parametrize("package", ["sting", "model"])
def test_a_package_of_cr_gives_the_outputs_of_explicit_rotations(package: str) -> None:
    coefficients = package_set(package)
    for euler in [(10.0, 5.0, -20.0), (-35.5, -12.0, 44.0)]:
        pitch, yaw, roll = np.radians(euler)
        outputs = apply(coefficients, pitch, roll, yaw_rad=yaw)
        for axis, truth in TRUTH[package].items():
            assert outputs[axis] == pytest.approx(accelerometer_v(axis, truth, euler, package), abs=1e-12)


def test_gyros_give_the_outputs_of_differentiated_rotations() -> None:
    euler, rate = (10.0, 15.0, -20.0), (20.0, -30.0, 10.0)
    outputs = apply(
        gyro_set(), *np.radians((euler[0], euler[2])), yaw_rad=np.radians(euler[1]), euler_rate_rad_s=np.radians(rate)
    )
    for axis, truth in TABLE_4.items():
        assert outputs[axis] == pytest.approx(gyro_v(axis, truth, euler, rate), abs=1e-10)


@pytest.mark.parametrize("make", [lambda: package_set("sting"), lambda: package_set("model"), gyro_set])
@pytest.mark.parametrize("ending", ["json", "csv", "mat"])
def test_a_set_of_cr_comes_back_from_every_format_and_verifies(tmp_path: Path, make: object, ending: str) -> None:
    coefficients = make()  # type: ignore[operator]
    path = tmp_path / f"set.{ending}"
    export_set(coefficients, ending, path)
    assert verify(path).largest_relative_error <= 1e-12
    loaded = load_set(path)
    assert (loaded.document["version"], loaded.convention, loaded.sha256) == (4, "CR", coefficients.sha256)


def test_test_vectors_are_reproduced_by_the_printed_equation_alone() -> None:
    """Whoever has only the JSON file: the convention's text and each axis' equation, evaluated as they stand."""
    document = json.loads(json.dumps(package_set("sting").document))
    for vector in document["test_vectors"]["forward"]:
        t, p = np.radians(vector["pitch_deg"]), np.radians(vector["yaw_deg"])
        g = {"G_x": -np.sin(t) * np.cos(p), "G_y": np.sin(t) * np.sin(p), "G_z": np.cos(t)}
        for axis, output in vector["outputs_v"].items():
            section = document["axes"][axis]
            text = section["equation"]["primary"].removeprefix("output = ")
            value = eval(text, {"__builtins__": {}}, {**section["primary"]["values"], **g})
            assert value == pytest.approx(output, abs=1e-12)


def test_polarity_tells_the_way_that_the_output_goes_when_the_axis_is_turned_up() -> None:
    use = package_set("model").document["use"]
    assert use["polarity"] == {"x": -1, "y": -1, "z": -1}  # S is positive per gravity, which points down
    assert gyro_set().document["use"]["polarity"] == {"x": 1, "y": 1, "z": 1}


def test_a_missing_yaw_or_rate_and_a_value_outside_are_refused() -> None:
    with pytest.raises(OutsideValidity, match="yaw is missing"):
        apply(package_set("model"), 0.0, 0.0)
    with pytest.raises(OutsideValidity, match="yaw outside the validity"):
        apply(package_set("model"), 0.0, 0.0, yaw_rad=1.0)
    with pytest.raises(OutsideValidity, match="rates are missing"):
        apply(gyro_set(), 0.0, 0.0, yaw_rad=0.0)
    with pytest.raises(OutsideValidity, match="rate outside the validity"):
        apply(gyro_set(), 0.0, 0.0, yaw_rad=0.0, euler_rate_rad_s=[0.0, 0.0, 2.0])


def test_version_1_holds_no_convention_of_cr(tmp_path: Path) -> None:
    path = write_changed(tmp_path / "s.json", package_set("model"), lambda document: document.update(version=1))
    with pytest.raises(SetError, match="schema of version 1"):
        load_set(path)


def test_a_new_set_is_of_version_4_and_holds_its_findings() -> None:
    observations = Campaign().observe(np.random.default_rng(4))
    document = build_set(calibrate(observations, CalibrationRequest()), provenance()).document
    assert document["version"] == 4
    kinds = {finding["kind"] for finding in document["axes"]["x"]["findings"]}
    assert {"wrong-dwell", "lack-of-fit", "drift", "quadratic"} <= kinds <= set(FINDING_KINDS)
    assert check_identity(document, "here") is document
