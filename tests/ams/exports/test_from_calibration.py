"""Sets from the solvers' own calibrations: a set predicts what the solution fitted, whatever the model."""

from pathlib import Path

import numpy as np
import pytest
from solved import PARAMETERS, direction, provenance

from ams.calibration.calibrate import calibrate
from ams.exports.formats import FORMATS, export_set
from ams.exports.verify import verify
from ams.inputs.request import CalibrationRequest
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations
from ams.sets.apply import apply
from ams.sets.coefficients import build_set

KNOWN = {axis: TemperatureCoefficients(2e-5, -3e-5, 1e-7, 1e-7) for axis in "xyz"}
REQUESTS = {
    "pitch-roll": CalibrationRequest(extended="no"),
    "pitch-only": CalibrationRequest("pitch-only", {"x": "x", "z": "z"}, extended="no"),
    "extended": CalibrationRequest(extended="yes"),
    "known temperature": CalibrationRequest(extended="no", temperature="apply", known_temperature=KNOWN),
    "estimated temperature": CalibrationRequest(extended="no", temperature="estimate"),
}


def observed(roll_deg: list[float], replications: int = 3) -> Observations:
    """A small grid over temperature plateaus visited from both sides, with 20 µV of noise."""
    rng = np.random.default_rng(3)
    pitch, roll = (grid.ravel() for grid in np.meshgrid(np.radians(np.arange(-90, 91, 15.0)), np.radians(roll_deg)))
    points = pitch.size
    pitch, roll = np.tile(pitch, replications), np.tile(roll, replications)
    temperature = np.resize([20.0, 30.0, 12.0, 31.0, 13.0, 21.0, 19.5], pitch.size)
    f = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    outputs_v = {
        axis: offset + direction(axis, *angles) @ f + rng.normal(0.0, 2e-5, pitch.size)
        for axis, (offset, *angles) in PARAMETERS.items()
    }
    return Observations(
        replication=np.repeat(np.arange(replications), points),
        point=np.tile(np.arange(points), replications),
        pitch_rad=pitch,
        roll_rad=roll,
        outputs=outputs_v,
        temperature_degc=temperature,
        time_s=np.arange(pitch.size, dtype=float),
    )


@pytest.mark.parametrize(
    "name",
    [*list(REQUESTS)[:2], *(pytest.param(name, marks=pytest.mark.thorough) for name in list(REQUESTS)[2:])],
)
def test_a_set_predicts_what_the_solution_fitted(name: str, tmp_path: Path) -> None:
    roll_deg = [0.0] if name == "pitch-only" else list(np.arange(-180, 181, 45.0))
    observations = observed(roll_deg)
    calibration = calibrate(observations, REQUESTS[name])
    valid = provenance(temperature_range_degc=(12.0, 31.0), roll_range_deg=(roll_deg[0], roll_deg[-1]))
    coefficients = build_set(calibration, valid)
    predicted_v = apply(coefficients, observations.pitch_rad, observations.roll_rad, observations.temperature_degc)
    for label, axis in calibration.axes.items():
        assert predicted_v[label] == pytest.approx(axis.fitted_v, rel=0, abs=1e-13)
    is_plain = not any(numbers.needs_temperature for numbers in coefficients.axes.values())
    for one in FORMATS.values():
        is_triad = len(coefficients.axes) == 3
        if (is_plain or one.name != "c-fixed") and (is_triad or one.name != "imucal"):
            export_set(coefficients, one.name, tmp_path / one.file_name("set"))
            assert verify(tmp_path / one.file_name("set")).sha256 == coefficients.sha256


def test_the_parts_of_the_covariance_add_up() -> None:
    section = build_set(
        calibrate(observed([0.0, 90.0, 180.0, -90.0]), CalibrationRequest(extended="no")), provenance()
    ).document
    primary = section["axes"]["x"]["primary"]
    total = sum(np.array(part["covariance"]) for part in primary["components"].values())
    scale = float(np.abs(total).max())
    assert total == pytest.approx(np.array(primary["covariance"]), rel=0, abs=1e-12 * scale)
