"""A solved set and rows of its outputs, as ``calrig attitude`` takes them."""

from pathlib import Path

import pytest
from package_outputs import ATTITUDES, TRUTH, output_v
from solved_sets import tp_set

from ams.exports.formats import export_set


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "tp.json"
    export_set(tp_set(), "json", path)
    return path


@pytest.fixture
def data(tmp_path: Path) -> Path:
    rows = [[output_v(axis, TRUTH[axis], p, r) for axis in "xyz"] for p, r in ATTITUDES]
    path = tmp_path / "data.csv"
    path.write_text("x_v,y_v,z_v\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    return path
