"""Catalogue 4.4 (68) and 4.5: a wrong sensor, wrong files, degenerate designs."""

from pathlib import Path

import numpy as np
import pytest
from small_run import PROCEDURE, RIG

from ams.archive.synthetic import Story, synthetic_archive
from ams.calibration.calibrate import calibrate
from ams.errors import AmsError, DesignError
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.surveillance.control_chart import history_of
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig
from rig.errors import DescriptionError


def test_fault_68_a_sensor_mixed_up_with_another_is_named_with_its_partner() -> None:
    """Detected: mount check (sensitivity, polarity); the archive's history: characteristics that are another's.
    Response: a sensitivity beyond half to twice the nominal trips; a mix-up is named with its partner for a person.
    """
    archive = synthetic_archive(np.random.default_rng(68), Story(sensors=12, years=5))
    for sensor, partner in (archive.mixed_up, archive.mixed_up[::-1]):
        (finding,) = [
            finding for finding in history_of(archive.population, sensor).findings if finding.kind == "mix-up"
        ]
        assert finding.partner == partner
        assert sensor in finding.sentence or partner in finding.sentence


WRONG = {
    "an unknown key": ("speed_dps = 180.0", "speed_dps = 180.0\ncolour = 1"),
    "a key without its unit": ("speed_dps = 180.0", "speed = 20.0"),
    "a doubled key": ("speed_dps = 180.0", "speed_dps = 180.0\nspeed_dps = 180.0"),
    "a word for a truth": ("increment_deg = 1.0", "increment_deg = no"),
    "a clock time": ("increment_deg = 1.0", "increment_deg = 12:30:00"),
    "a number in quotes": ("increment_deg = 1.0", 'increment_deg = "1.0"'),
    "a truth for a number": ("increment_deg = 1.0", "increment_deg = true"),
    "no number": ("increment_deg = 1.0", "increment_deg = nan"),
    "radians": ("limits_deg = [-180.0, 180.0]", "limits_rad = [-3.14, 3.14]"),
    "limits the wrong way round": ("limits_deg = [-180.0, 180.0]", "limits_deg = [180.0, -180.0]"),
    "millivolts": ("nominal_sensitivity_v_per_g = 2.5", "nominal_sensitivity_mv_per_g = 2500.0"),
    "gravity in feet": ("gravity_mps2 = 9.80665", "gravity_mps2 = 32.17"),
    "a negative speed": ("speed_dps = 180.0", "speed_dps = -20.0"),
    "another driver": ('driver = "hp3458a"', 'driver = "hp3458"'),
    "a channel that is none": ('x = "dmm.x"', 'x = "dmm.q"'),
}


@pytest.mark.parametrize("what", WRONG)
def test_fault_69_a_wrong_rig_file_is_refused_by_line_before_any_port_is_opened(tmp_path: Path, what: str) -> None:
    """Detected: strict reading: unknown and doubled keys, missing units, types, ranges; then the mount check.
    Response: every mistake is told with file, line and key before any port is opened.
    """
    old, new = WRONG[what]
    assert old in RIG
    path = tmp_path / "rig.toml"
    path.write_text(RIG.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"rig\.toml:\d+") as refusal:
        read_rig(path)
    assert "Traceback" not in str(refusal.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [("samples = 5", "samples = 5.5"), ("samples = 5", "sample = 5"), ("step = 30.0", "step = 0.0"),
     ("replications = 2", "replications = 0"), ('kind = "grid"', 'kind = "gird"')],
)  # fmt: skip
def test_fault_69_a_wrong_procedure_is_refused_by_line(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "procedure.toml"
    path.write_text(PROCEDURE.replace(old, new), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"procedure\.toml:\d+"):
        read_procedure(path)


def _rows(pitch_deg: list[float], roll_deg: list[float], coning_deg: float = 0.5) -> Observations:
    """Two replications of the given points, seen by an x sensor; noise of a microvolt."""
    pitch, roll = (np.deg2rad(np.tile(np.array(values), 2)) for values in (pitch_deg, roll_deg))
    count, c = len(pitch_deg), np.deg2rad(coning_deg)
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    noise_v = 1e-6 * np.random.default_rng(7).standard_normal(2 * count)
    return Observations(
        replication=np.repeat([1, 2], count),
        point=np.tile(np.arange(1, count + 1), 2),
        pitch_rad=pitch,
        roll_rad=roll,
        outputs={"x": 0.005 + 2.5 * (np.cos(c) * force[0] + np.sin(c) * force[1]) + noise_v},
    )


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg"),
    [
        ([-60.0, -30.0, 0.0, 30.0, 60.0, 75.0], [0.0] * 6),
        ([0.0, 45.0, 90.0], [0.0, 90.0, 45.0]),
        ([30.0] * 6, [45.0] * 6),
        ([90.0] * 4 + [-90.0] * 4, [0.0, 90.0, 180.0, 270.0] * 2),
    ],
    ids=["one roll", "three points", "one point six times", "poles only"],
)
def test_fault_71_a_degenerate_design_is_refused_in_words(pitch_deg: list[float], roll_deg: list[float]) -> None:
    """Detected: rank and condition number of the scaled basis; the closed form needs no start.
    Response: refused with what is missing; what cannot be told is null with the reason, never a number.
    """
    with pytest.raises(DesignError, match="nothing was solved"):
        calibrate(_rows(pitch_deg, roll_deg), CalibrationRequest(extended="no"))


def test_fault_71_no_coning_has_no_azimuth_and_says_so() -> None:
    pitch, roll = np.meshgrid(np.arange(-60.0, 61.0, 30.0), np.arange(-180.0, 180.0, 45.0))
    axis = calibrate(_rows(pitch.ravel().tolist(), roll.ravel().tolist(), 0.0), CalibrationRequest(extended="no")).axes[
        "x"
    ]
    found = {parameter.name: parameter for parameter in axis.parameters}
    assert (found["coning_deg"].value, found["azimuth_deg"].value) == (None, None)
    assert found["sensitivity_v_per_g"].value == pytest.approx(2.5, abs=1e-5)
    assert "coning angle and azimuth are not determined" in str(axis.warnings)
    assert np.isfinite(axis.primary).all()


def test_fault_71_a_row_that_is_no_number_is_named() -> None:
    rows = _rows([0.0, 30.0, 60.0, -30.0, -60.0], [0.0, 90.0, 180.0, 45.0, 10.0])
    rows.outputs["x"][3] = np.inf  # type: ignore[index]
    with pytest.raises(AmsError, match=r"row 4 \(replication 1, point 4\): got inf"):
        calibrate(rows, CalibrationRequest(extended="no"))
