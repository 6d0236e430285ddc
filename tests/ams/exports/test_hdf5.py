"""The HDF5 export with nothing but h5py and numpy, as somebody who has only the file."""

import io
import sys
from typing import Any

import h5py
import numpy as np
import pytest
from foreign_sets import HOSTILE, hostile, warm
from solved import provenance, solved_axis, solved_package

from ams.calibration_result import Calibration
from ams.errors import SetError, VectorsDisagree
from ams.exports.checksum_inside import CHECKSUM_SLOT, with_checksum_inside
from ams.exports.hdf5 import from_hdf5, to_hdf5
from ams.sets.coefficients import CoefficientSet, build_set


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def opened(coefficients: CoefficientSet) -> Any:
    return h5py.File(io.BytesIO(to_hdf5(coefficients)), "r")


@pytest.mark.parametrize("axis", "xyz")
def test_the_datasets_alone_reproduce_the_vectors(axis: str, package: CoefficientSet) -> None:
    with opened(package) as file:
        forward, values = file["test_vectors/forward"], file[f"axes/{axis}/primary/values"]
        alpha, roll = np.radians(forward["pitch_deg"]), np.radians(forward["roll_deg"])
        f = [np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)]
        outputs_v = values["offset_v"][()] + sum(values[f"k_{c}_v_per_g"][()] * f[i] for i, c in enumerate("xyz"))
        assert outputs_v == pytest.approx(forward[f"outputs_v/{axis}"][:], rel=0, abs=2.5e-12)


def test_numbers_have_units_and_covariances_are_matrices(package: CoefficientSet) -> None:
    with opened(package) as file:
        assert file["axes/x/primary/values/k_y_v_per_g"].attrs["unit"] == "V/g"
        assert file["axes/x/parameters/azimuth_deg/value"].attrs["unit"] == "deg"
        assert file["test_vectors/forward/outputs_v/z"].attrs["unit"] == "V"
        assert file["acceleration_unit/value_mps2"][()] == 9.79826
        assert file["use/polarity/z"][()] == -1.0
        covariance = file["axes/x/primary/components/table/covariance"][:]
        assert covariance == pytest.approx(np.full((4, 4), 1e-13), rel=0, abs=0)
        assert file["axes/x/primary/order"].asstr()[:].tolist()[1] == "k_x_v_per_g"


def test_what_is_not_determined_is_empty_and_nan_inside_a_matrix() -> None:
    solved = Calibration({"x": solved_axis("x", with_angles=False)}, "pitch-roll", "TP")
    with opened(build_set(solved, provenance())) as file:
        assert file["axes/x/parameters/azimuth_deg/value"].shape is None
        assert np.isnan(file["axes/x/covariance"][3, 3])


def test_names_and_texts_of_any_kind_come_back() -> None:
    with opened(hostile()) as file:
        assert file["provenance/operator"].asstr()[()] == HOSTILE
        assert HOSTILE.replace("~", "~0").replace("/", "~1") in file["provenance/job"]


def test_temperature_is_among_the_vectors() -> None:
    with opened(warm()) as file:
        assert file["test_vectors/forward/temperature_degc"].attrs["unit"] == "degC"


def tampered(coefficients: CoefficientSet, path: str, change: float) -> bytes:
    file = io.BytesIO(to_hdf5(coefficients))
    with h5py.File(file, "r+") as opened:
        opened[path][...] = opened[path][...] + change
        opened.attrs["file_sha256"] = np.bytes_(CHECKSUM_SLOT)
    return with_checksum_inside(file.getvalue())


@pytest.mark.parametrize(
    ("path", "part"),
    [
        ("axes/y/primary/values/offset_v", "axes"),
        ("axes/z/parameters/coning_deg/value", "axes"),
        ("test_vectors/inverse/outputs_v/x", "test_vectors"),
    ],
)
def test_a_sealed_file_with_other_numbers_than_its_document_disagrees(
    path: str, part: str, package: CoefficientSet
) -> None:
    with pytest.raises(VectorsDisagree, match=f"file: {part}: the file's own are others than those of the document"):
        from_hdf5(tampered(package, path, 1e-9), "file")


def test_a_file_of_another_layout_is_refused(package: CoefficientSet) -> None:
    file = io.BytesIO(to_hdf5(package))
    with h5py.File(file, "r+") as opened:
        opened.attrs["file_format"] = "calrig coefficient set as HDF5, version 2"
        opened.attrs["file_sha256"] = np.bytes_(CHECKSUM_SLOT)
    with pytest.raises(SetError, match=r"file: file_format: is of another version: got 'calrig .* version 2', this"):
        from_hdf5(with_checksum_inside(file.getvalue()), "file")


def test_another_hdf5_file_is_refused() -> None:
    file = io.BytesIO()
    with h5py.File(file, "w") as other:
        other["a"] = 1.0
    with pytest.raises(SetError, match=r"file: checksum: does not fit .* or written by another program"):
        from_hdf5(file.getvalue(), "file")
    with pytest.raises(SetError, match=r"file: is not a coefficient set as HDF5: it begins with b'PK"):
        from_hdf5(b"PK\x03\x04", "file")


def test_a_sealed_file_without_a_set_is_refused() -> None:
    file = io.BytesIO()
    with h5py.File(file, "w", libver=("earliest", "v110")) as other:
        other.attrs["file_sha256"] = np.bytes_(CHECKSUM_SLOT)
    with pytest.raises(SetError, match="file: has no document_json, axes and test_vectors that HDF5 can read"):
        from_hdf5(with_checksum_inside(file.getvalue()), "file")


def test_a_missing_library_is_a_sentence(package: CoefficientSet, monkeypatch: pytest.MonkeyPatch) -> None:
    content = to_hdf5(package)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(SetError, match=r"SN1047: HDF5: needs h5py, which is not installed; .* 'calrig\[export\]'"):
        to_hdf5(package)
    with pytest.raises(SetError, match="file: needs h5py, which is not installed; nothing was read or written"):
        from_hdf5(content, "file")
