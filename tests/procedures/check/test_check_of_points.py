"""Laws of the check of a moving procedure: what stops an axis when the computer dies is said before it turns."""

from pathlib import Path

from procedures.check.check_report import check
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig

EXAMPLE = Path(__file__).parents[3] / "examples" / "rate-table"


def _advice(rig: Path, procedure: Path = EXAMPLE / "rates.toml") -> list[str]:
    report = check(read_rig(rig), read_procedure(procedure))
    return [line for line in report.advice if "watchdog_s" in line]


def test_an_axis_that_turns_and_that_nothing_stops_is_named() -> None:
    text = _advice(EXAMPLE / "rig.toml")
    assert [line.partition(" ")[0] for line in text] == ["axes.pitch", "axes.yaw", "axes.roll"]
    assert "if this computer dies while it turns, it turns on" in text[0]


def test_an_axis_with_a_watchdog_is_not(tmp_path: Path) -> None:
    text = (EXAMPLE / "rig.toml").read_text(encoding="utf-8")
    text = text.replace('"zaber"', '"oriental-az"')
    text = text.replace("microstep_deg = 0.000234375", "step_deg = 0.001\nwatchdog_s = 5.0")
    path = tmp_path / "rig.toml"
    path.write_text(text, encoding="utf-8")
    assert _advice(path) == []


def test_an_axis_that_follows_a_profile_by_rates_is_named_and_one_that_sweeps_to_a_target_is_not() -> None:
    text = _advice(EXAMPLE / "rig.toml", EXAMPLE / "harmonic.toml")
    assert [line.partition(" ")[0] for line in text] == ["axes.pitch", "axes.yaw", "axes.roll"]
    servos = EXAMPLE.with_name("servo-mechanism")
    assert _advice(servos / "rig.toml", servos / "gyro.toml") == []
