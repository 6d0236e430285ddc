"""Laws of ``calrig fit`` and ``calrig.fit`` for temperatures in another unit than degrees Celsius."""

from dataclasses import replace
from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from command import call
from package_outputs import write_observations
from planning_files import rig_file

from ams.calibration.calibrate import calibrate
from ams.errors import ObservationsError
from ams.inputs.observations_csv import read_csv
from ams.inputs.request import CalibrationRequest

AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
COLUMNS = {"x": "sx_v", "y": "sy_v", "z": "sz_v"}
OF_RIG = {"x": (0.005, 2.5, 0.5, 35.0), "y": (-0.003, 2.48, 0.3, -110.0), "z": (0.008, 2.52, 0.4, 160.0)}


def rows_at(folder: Path, mean: float) -> Path:
    path = write_observations(folder / "obs.csv", range(-90, 91, 30), range(-180, 180, 60), 3, 1e-5, truth=OF_RIG)
    rows = pd.read_csv(path)
    rows.assign(temperature_degc=np.round(np.random.default_rng(3).normal(mean, 0.01, len(rows)), 3)).to_csv(
        path, index=False
    )
    return path


def rig_that_declares(folder: Path, used: str) -> Path:
    rig_file(folder)
    path = folder / "rig.toml"
    text = path.read_text()
    at = text.index("[sensors.SN1]\n") + len("[sensors.SN1]\n")
    path.write_text(f"{text[:at]}{used}{text[at:]}")
    return path


def test_kelvin_is_refused_by_command_and_python_and_for_observations_of_any_source(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = rows_at(tmp_path, 295.0)
    done = call(capsys, "fit", path, *AXES, "--set", tmp_path / "set.json", "--sensor", "SN1", "--gravity-mps2", "9.8")
    assert done.status == 2
    assert f"{path}: line 2: column temperature_degc: got '29" in done.err
    assert "kelvin: subtract 273.15" in done.err
    assert not (tmp_path / "set.json").exists()
    with pytest.raises(ObservationsError, match="kelvin"):
        calrig.fit(pd.read_csv(path), COLUMNS)
    rows = read_csv(rows_at(tmp_path, 21.85), COLUMNS)
    in_kelvin = replace(rows, temperature_degc=rows.temperature_degc + 273.15)
    with pytest.raises(ObservationsError, match=r"126 of 126 rows are impossible, .*replication 1, point 1: .*kelvin"):
        calibrate(in_kelvin, CalibrationRequest())


@pytest.mark.parametrize(
    ("mean", "used", "words"),
    [
        (72.0, "use_temperature_degc = [15.0, 30.0]\n", "degrees Fahrenheit? subtract 32 and divide by 1.8"),
        (-30.0, "use_temperature_degc = [15.0, 30.0]\n", "look at the unit of the column, and at the rig file"),
        (40.0, "use_temperature_degc = [15.0, 30.0]\n", None),
        (22.0, "use_temperature_degc = [15.0, 30.0]\n", None),
        (72.0, "", None),
    ],
)
@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_what_lies_far_outside_the_declared_range_of_use_is_a_warning(
    mean: float, used: str, words: str | None, joint: tuple, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, rig = rows_at(tmp_path, mean), rig_that_declares(tmp_path, used)
    document = call(capsys, "fit", path, *AXES, *joint, "--rig", rig, "--sensor", "SN1", "--json").document
    warnings = document["axes"]["x"]["warnings"]
    said = [text for text in warnings if "use_temperature_degc of the sensor is 15 to 30 °C" in text]
    assert len(said) == (words is not None)
    assert all(words in text and "nothing was converted" in text for text in said)
