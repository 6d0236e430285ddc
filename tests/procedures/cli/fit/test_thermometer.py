"""What offset and sensitivity over temperature are stated at rests on a thermometer: it is counted, or said."""

from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from example_files import EXAMPLE_RIG

from ams.frames import specific_force

PLATEAUS_DEGC = (10.0, 25.0, 40.0, 40.0, 25.0, 10.0)
LIMIT_DEGC, OFFSET_V_PER_DEGC = 0.6, 2e-5
SAID = "no uncertainty of the thermometer is declared"


def _readings() -> pd.DataFrame:
    points = np.array([(p, r) for p in (-60.0, -30.0, 0.0, 30.0, 60.0) for r in (-180.0, -90.0, 0.0, 90.0)])
    pitch, roll = np.tile(points, (len(PLATEAUS_DEGC), 1)).T
    temperature = np.repeat(PLATEAUS_DEGC, len(points))
    force = specific_force(np.deg2rad(pitch), np.deg2rad(roll))
    noise = np.random.default_rng(5).normal(0.0, 2e-5, force.shape)
    read = 0.002 + OFFSET_V_PER_DEGC * (temperature - 25.0)[:, None] + 2.5 * force + noise
    columns = {
        "replication": np.repeat(np.arange(1, len(PLATEAUS_DEGC) + 1), len(points)),
        "point": np.tile(np.arange(1, len(points) + 1), len(PLATEAUS_DEGC)),
        "pitch_deg": pitch, "roll_deg": roll, "temperature_degc": temperature,
        **{f"s{axis}_v": read[:, index] for index, axis in enumerate("xyz")},
    }  # fmt: skip
    return pd.DataFrame(columns)


def _rig(folder: Path, uncertainty: str) -> Path:
    """The example, its chamber with a standard of its own; the limit as the certificate states it, or nothing."""
    text = EXAMPLE_RIG.read_text(encoding="utf-8").replace(
        "[environment.air]\n", '[environment.air]\nstandard = "probe"\n'
    )
    text += f'\n[standards.probe]\nserial = "T1"\ncertificate = "T-1"\ndue = 2099-01-01\n{uncertainty}'
    path = folder / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("uncertainty", [f'uncertainty_degc = {LIMIT_DEGC}\nkind = "limit"\n', ""])
def test_a_thermometer_with_a_certificate_is_counted_and_one_without_is_said(tmp_path: Path, uncertainty: str) -> None:
    axes = {axis: f"s{axis}_v" for axis in "xyz"}
    found = calrig.fit(
        _readings(), axes, rig=_rig(tmp_path, uncertainty), temperature="estimate", reference_temperature_degc=25.0
    )
    (solved,) = found.sensors.values()
    remarks = " ".join(solved.calibration.remarks)
    (offset,) = (p for p in solved.calibration.axes["x"].parameters if p.name == "offset_v")
    of_probe = OFFSET_V_PER_DEGC * LIMIT_DEGC / np.sqrt(3.0)
    if uncertainty:
        assert SAID not in remarks
        assert offset.standard_uncertainty > of_probe
    else:
        assert SAID in remarks
        assert offset.standard_uncertainty < of_probe


def test_without_terms_of_temperature_nothing_is_said_of_the_thermometer(tmp_path: Path) -> None:
    found = calrig.fit(_readings(), {"x": "sx_v"}, rig=_rig(tmp_path, ""))
    (solved,) = found.sensors.values()
    assert SAID not in " ".join(solved.calibration.remarks)
