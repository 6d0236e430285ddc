"""Numbers of motion that a machine cannot be told are refused by the file: no run meets them before a move."""

from pathlib import Path

import pytest
from device_sets import AXIS, COMMON, DAQ, F4T, SERVO

from rig.description.read import read_rig
from rig.errors import DescriptionError

DRIVERS = {
    "indexing-table": "increment_deg = 1.0",
    "esp301": "",
    "pi-gcs": "",
    "zaber": "microstep_deg = 0.001\nvelocity_scale = 1.0\ntop_rate_dps = 400.0",
    "oriental-az": "step_deg = 0.01\ntop_rate_dps = 400.0",
    "rate-table": "top_rate_dps = 400.0",
    "maestro": SERVO,
}


def _axis(driver: str, axis: str, number: int, key: str = "", value: str = "") -> str:
    """The table of an axis, one of its keys changed."""
    number -= driver == "maestro"
    text = AXIS.format(axis=axis, driver=driver, number=number, extra=DRIVERS[driver], tolerance_deg=0.1)
    kept = [line for line in text.splitlines() if not key or not line.startswith(f"{key} =")]
    return "\n".join([*kept, *([f"{key} = {value}"] if key else []), ""])


def _read(folder: Path, driver: str, key: str, value: str) -> None:
    axes = _axis(driver, "pitch", 1, key, value) + _axis(driver, "roll", 2)
    (folder / "rig.toml").write_text(COMMON.format(name="bench") + axes + DAQ + F4T, encoding="utf-8")
    read_rig(folder / "rig.toml")


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_speed_in_the_wrong_unit_is_refused_with_what_the_machine_can_be_told(tmp_path: Path, driver: str) -> None:
    with pytest.raises(DescriptionError, match=r"rig\.toml:\d+: axes\.pitch\.speed_dps: got 1e\+06 °/s, allowed is"):
        _read(tmp_path, driver, "speed_dps", "1e6")


@pytest.mark.parametrize(
    ("driver", "key", "value", "sentence"),
    [
        ("esp301", "speed_dps", "1e-4", "got 0.0001 °/s, allowed is 0.0005 to 36000 °/s"),
        ("pi-gcs", "speed_dps", "1e-4", "got 0.0001 °/s, allowed is 0.0005 to 36000 °/s"),
        ("zaber", "speed_dps", "0.0009", "got 0.0009 °/s, allowed is 0.001 to 36000 °/s"),
        ("oriental-az", "speed_dps", "0.009", "got 0.009 °/s, allowed is 0.01 to 36000 °/s"),
        ("oriental-az", "acceleration_dps2", "0.009", "got 0.009 °/s², allowed is 0.01 to 1e\\+07 °/s²"),
        ("oriental-az", "acceleration_dps2", "2e7", "got 2e\\+07 °/s², allowed is 0.01 to 1e\\+07 °/s²"),
        ("oriental-az", "top_rate_dps", "1e9", "got 1e\\+09 °/s, allowed is"),
        ("zaber", "speed_dps", "401.0", "got 401 °/s, allowed is up to 400 °/s, the largest rate of the axis"),
        ("rate-table", "speed_dps", "401.0", "got 401 °/s, allowed is up to 400 °/s, the largest rate of the axis"),
        ("indexing-table", "arrival_tolerance_deg", "0.5", "got 0.5°, allowed is below 0.5° \\(half its increment_deg"),
        ("esp301", "arrival_tolerance_deg", "90.0", "got 90°, allowed is below 1°"),
    ],
)
def test_what_a_driver_would_clamp_or_a_device_refuse_is_refused_by_the_file(
    tmp_path: Path, driver: str, key: str, value: str, sentence: str
) -> None:
    with pytest.raises(DescriptionError, match=rf"rig\.toml:\d+: axes\.pitch\.{key}: {sentence}"):
        _read(tmp_path, driver, key, value)


@pytest.mark.parametrize(("driver", "value"), [("zaber", "0.001"), ("oriental-az", "0.01"), ("esp301", "0.0005")])
def test_the_slowest_speed_that_can_be_told_is_taken(tmp_path: Path, driver: str, value: str) -> None:
    _read(tmp_path, driver, "speed_dps", value)
