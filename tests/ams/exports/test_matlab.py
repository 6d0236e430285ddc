"""The MATLAB export with nothing but loadmat and numpy, as somebody who has only the file."""

import io
import json
import re
from typing import Any

import numpy as np
import pytest
from changed_sets import changed
from scipy.io import loadmat, savemat
from solved import PARAMETERS, provenance, solved_axis, solved_package

from ams.calibration_result import Calibration
from ams.errors import SetError, VectorsDisagree
from ams.exports.matlab import HEAD, HEAD_BYTES, _head, from_matlab, to_matlab
from ams.sets.coefficients import CoefficientSet, build_set, from_document


@pytest.fixture(scope="module")
def coefficients() -> CoefficientSet:
    return build_set(solved_package(), provenance())


@pytest.fixture(scope="module")
def struct(coefficients: CoefficientSet) -> dict[str, Any]:
    loaded: dict[str, Any] = loadmat(io.BytesIO(to_matlab(coefficients)), simplify_cells=True)["calrig"]
    return loaded


def value_of(text: str, names: dict[str, np.ndarray]) -> np.ndarray:
    """The right side of a printed equation, evaluated: `sin alpha` as a function call, juxtaposition as a product."""
    formula = text.split("=", 1)[1].split(";")[0]
    formula = re.sub(r"\b(sin|cos) (\w+)", r"\1(\2)", formula)
    formula = re.sub(r"\)\s+(?=[a-z(])|(?<=[)])(?=\s*\()", ")*", formula).replace(")*(", ")*(")
    formula = re.sub(r"\b(sin|cos)\(R \+ A\)", r"\1((R + A))", formula)
    return np.asarray(eval(formula, {"__builtins__": {}, "sin": np.sin, "cos": np.cos}, names))


@pytest.mark.parametrize("axis", "xyz")
def test_the_primary_equation_in_the_file_reproduces_its_vectors(axis: str, struct: dict[str, Any]) -> None:
    forward, section = struct["test_vectors"]["forward"], struct["axes"][axis]
    alpha, roll = np.radians(forward["pitch_deg"]), np.radians(forward["roll_deg"])
    force = {"f_x": np.sin(alpha), "f_y": -np.cos(alpha) * np.sin(roll), "f_z": -np.cos(alpha) * np.cos(roll)}
    assert "f = (sin alpha, -cos alpha sin R, -cos alpha cos R)" in struct["convention"]["text"]
    outputs_v = value_of(section["equation"]["primary"], {**section["primary"]["values"], **force})
    assert outputs_v == pytest.approx(forward["outputs_v"][axis], rel=0, abs=1e-12 * 2.5)


@pytest.mark.parametrize("axis", "xyz")
def test_the_derived_equation_in_the_file_reproduces_its_vectors(axis: str, struct: dict[str, Any]) -> None:
    forward, section = struct["test_vectors"]["forward"], struct["axes"][axis]
    parameters = {name: entry["value"] for name, entry in section["parameters"].items()}
    names = {
        "alpha": np.radians(forward["pitch_deg"]),
        "R": np.radians(forward["roll_deg"]),
        "b": parameters["offset_v"],
        "S": parameters["sensitivity_v_per_g"],
        "W": np.radians(parameters["coning_deg"]),
        "A": np.radians(parameters["azimuth_deg"]),
    }
    outputs_v = value_of(section["equation"]["derived"], names)
    assert outputs_v == pytest.approx(forward["outputs_v"][axis], rel=0, abs=1e-12 * 2.5)


def test_the_inverse_text_in_the_file_reproduces_its_vectors(struct: dict[str, Any]) -> None:
    inverse, axes = struct["test_vectors"]["inverse"], struct["axes"]
    k = np.array([[axes[a]["primary"]["values"][f"k_{c}_v_per_g"] for c in "xyz"] for a in axes])
    offsets = np.array([axes[a]["primary"]["values"]["offset_v"] for a in axes])
    outputs = np.array([inverse["outputs_v"][a] for a in axes])
    f_x, f_y, f_z = np.linalg.solve(k, outputs - offsets[:, None])
    assert np.degrees(np.arctan2(f_x, np.hypot(f_y, f_z))) == pytest.approx(inverse["pitch_deg"], abs=1e-11)
    turn = np.degrees(np.arctan2(-f_y, -f_z)) - inverse["roll_deg"]
    assert (turn + 180.0) % 360.0 - 180.0 == pytest.approx(np.zeros(turn.size), abs=1e-11)


def test_the_struct_has_matrices_units_and_the_whole_document(
    struct: dict[str, Any], coefficients: CoefficientSet
) -> None:
    section = struct["axes"]["x"]
    assert section["covariance"].shape == (4, 4)
    assert section["primary"]["covariance"] == pytest.approx(solved_axis("x").primary_covariance, rel=0, abs=0)
    assert list(section["covariance_order"]) == ["offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg"]
    assert section["parameters"]["azimuth_deg"]["unit"] == "deg"
    assert section["parameters"]["azimuth_deg"]["value"] == PARAMETERS["x"][3]
    assert struct["checksum"]["sha256"] == coefficients.sha256
    assert json.loads(struct["document_json"]) == coefficients.document


def test_null_is_an_empty_matrix_and_nan_inside_a_matrix() -> None:
    solved = Calibration({"x": solved_axis("x", with_angles=False)}, "pitch-roll", "TP")
    content = to_matlab(build_set(solved, provenance()))
    section = loadmat(io.BytesIO(content), simplify_cells=True)["calrig"]["axes"]["x"]
    assert np.size(section["parameters"]["azimuth_deg"]["value"]) == 0
    assert np.isnan(section["covariance"][3, 3])
    assert from_matlab(content, "file").axes["x"].parameters["azimuth_deg"] is None


def test_names_that_matlab_does_not_allow_are_renamed_and_do_not_meet() -> None:
    job = {"1 a": 1.0, "1-a": 2.0, "x" * 80: 3.0, "ok": [True, "text", None], "": {}}
    coefficients = build_set(solved_package("x"), provenance(job=job))
    content = to_matlab(coefficients)
    fields = loadmat(io.BytesIO(content), simplify_cells=True)["calrig"]["provenance"]["job"]
    assert sorted(fields["f_1_a"] for _ in "x") == [1.0]
    assert fields["f_1_a_2"] == 2.0
    assert len(fields) == 5
    assert from_matlab(content, "file") == coefficients


def test_the_head_is_what_matlab_expects_and_holds_no_time() -> None:
    content = to_matlab(build_set(solved_package("x"), provenance()))
    assert content[:19] == b"MATLAB 5.0 MAT-file"
    assert content[124:128] in (b"\x00\x01IM", b"\x01\x00MI")
    assert len(HEAD) + 64 <= HEAD_BYTES


def test_a_file_saved_again_by_another_program_is_refused(struct: dict[str, Any]) -> None:
    file = io.BytesIO()
    savemat(file, {"calrig": struct}, long_field_names=True)
    with pytest.raises(
        SetError, match=r"is not a coefficient set as MATLAB file: .*was saved again by another program"
    ):
        from_matlab(file.getvalue(), "file")


def resealed(struct: Any) -> bytes:
    file = io.BytesIO()
    savemat(file, {"calrig": struct}, long_field_names=True, oned_as="row")
    body = file.getvalue()[HEAD_BYTES:]
    return _head(body) + body


def test_a_struct_with_other_numbers_than_its_document_disagrees(coefficients: CoefficientSet) -> None:
    loaded = loadmat(io.BytesIO(to_matlab(coefficients)), simplify_cells=True)["calrig"]
    loaded["axes"]["y"]["primary"]["values"]["offset_v"] += 1e-9
    with pytest.raises(VectorsDisagree, match=r"axes: the file.s own are others than those of the document"):
        from_matlab(resealed(loaded), "file")


def test_a_struct_with_other_vectors_than_its_document_disagrees(coefficients: CoefficientSet) -> None:
    loaded = loadmat(io.BytesIO(to_matlab(coefficients)), simplify_cells=True)["calrig"]
    loaded["test_vectors"]["inverse"]["roll_deg"][0] += 1e-9
    with pytest.raises(VectorsDisagree, match=r"test_vectors: the file.s own are others"):
        from_matlab(resealed(loaded), "file")


@pytest.mark.parametrize("struct", [1.0, {"a": 1.0}, {"document_json": "{", "axes": 1.0, "test_vectors": 1.0}])
def test_a_sealed_file_without_the_struct_is_refused(struct: Any) -> None:
    with pytest.raises(SetError, match=r"has no struct 'calrig'|document_json: is truncated"):
        from_matlab(resealed(struct), "file")


@pytest.mark.parametrize("missing", ["axes", "test_vectors"])
def test_a_struct_that_lacks_what_its_document_has_disagrees(missing: str, coefficients: CoefficientSet) -> None:
    loaded = loadmat(io.BytesIO(to_matlab(coefficients)), simplify_cells=True)["calrig"]
    loaded[missing] = {"other": 1.0}
    with pytest.raises(VectorsDisagree, match=r"the file.s own are others"):
        from_matlab(resealed(loaded), "file")


def test_a_document_changed_inside_the_file_is_damage(coefficients: CoefficientSet) -> None:
    loaded = loadmat(io.BytesIO(to_matlab(coefficients)), simplify_cells=True)["calrig"]
    loaded["document_json"] = loaded["document_json"].replace("2.47", "2.48", 1)
    with pytest.raises(SetError, match="file: document_json: checksum: does not fit the content"):
        from_matlab(resealed(loaded), "file")


def test_two_packages_do_not_share_a_checksum(coefficients: CoefficientSet) -> None:
    other = from_document(changed(coefficients, lambda d: d["sensor"].update(serial="1048")), "other")
    assert other.sha256 != coefficients.sha256
    assert to_matlab(other) != to_matlab(coefficients)
