"""Laws: what a meter answers for an overload is named, and two points that changed places are no turn of nothing."""

from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from package_outputs import write_observations

from ams.errors import ObservationsError

COLUMNS = {"x": "sx_v", "y": "sy_v", "z": "sz_v"}


def rows_of(folder: Path) -> pd.DataFrame:
    return pd.read_csv(write_observations(folder / "rows.csv", range(-60, 61, 20), range(-180, 180, 45), 4, 2e-5))


@pytest.mark.parametrize("code", [9.9e37, -9.9e37, 9.91e37])
@pytest.mark.parametrize("model", ["pitch-roll", "gyro"])
def test_the_overload_code_of_a_meter_is_named_with_its_row(tmp_path: Path, code: float, model: str) -> None:
    rows = rows_of(tmp_path)
    rates = np.random.default_rng(1).permuted(np.tile(np.arange(-20.0, 36.0), (3, 1)), axis=1)
    columns = ("pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps")
    rows = rows.assign(yaw_deg=0.0, **dict(zip(columns, np.tile(rates, 4), strict=True))) if model == "gyro" else rows
    rows.loc[56 + 4, "sz_v"] = code
    with pytest.raises(ObservationsError, match=r"sz_v: replication 2, point .*: got .*e\+37, the code") as refusal:
        calrig.fit(rows, COLUMNS, model=model)
    assert "millivolts" not in str(refusal.value)
    assert f"point {rows.point[60]}: " in str(refusal.value)


def test_two_points_that_changed_places_are_not_said_to_be_a_table_that_stood_off_by_nothing(tmp_path: Path) -> None:
    rows = rows_of(tmp_path)
    outputs = list(COLUMNS.values())
    rows.loc[[65, 66], outputs] = rows.loc[[66, 65], outputs].to_numpy()
    axes = calrig.fit(rows, COLUMNS).document["axes"]
    said = [text for axis in axes.values() for text in axis["warnings"]]
    assert any("wrong dwell: replication 2, point" in text for text in said)
    assert not any("up to 0″" in text for text in said)
