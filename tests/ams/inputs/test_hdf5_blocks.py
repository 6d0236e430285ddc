"""Columns of HDF5 as calrig reads them: what was written by h5py comes back, piece by piece."""

from pathlib import Path

import numpy as np
import pytest

from ams.errors import ObservationsError
from ams.inputs import hdf5_blocks
from ams.inputs.hdf5_blocks import blocks_of

h5py = pytest.importorskip("h5py")


@pytest.mark.parametrize("group", ["", "run/fast"])
def test_columns_come_back_from_whatever_group_has_them(
    tmp_path: Path, group: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hdf5_blocks, "PIECE_ROWS", 7)
    x, y = np.arange(20.0), np.arange(20, dtype=np.int32)
    x[3] = np.nan
    with h5py.File(tmp_path / "a.h5", "w") as file:
        location = file.require_group(group) if group else file
        location["x_v"], location["y_v"], location["note"] = x, y, "ramp"
        file.require_group("other")["x_v"] = x
    pieces = list(blocks_of(tmp_path / "a.h5", ("x_v", "y_v"), ("temperature_degc",)))
    assert [piece["x_v"].size for piece in pieces] == [7, 7, 6]
    assert np.concatenate([piece["x_v"] for piece in pieces]) == pytest.approx(x, nan_ok=True)
    assert np.concatenate([piece["y_v"] for piece in pieces]) == pytest.approx(y)


def test_what_is_no_table_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.hdf5"
    path.write_bytes(b"no HDF5")
    with pytest.raises(ObservationsError, match="cannot be read as HDF5"):
        list(blocks_of(path, ("x_v",)))
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["x_v"], file["y_v"] = np.zeros(3), np.zeros(4)
    with pytest.raises(ObservationsError, match="different lengths: x_v 3, y_v 4"):
        list(blocks_of(tmp_path / "b.h5", ("x_v", "y_v")))
    with pytest.raises(ObservationsError, match="column z_v missing; found: x_v, y_v"):
        list(blocks_of(tmp_path / "b.h5", ("z_v",)))
