"""Laws of ``calrig simulate --faults``: strict before it serves, stable names while it serves, nothing left behind."""

from pathlib import Path

import pytest
from command import call
from job_files import job, simulated

FAULTS = """
[fault.unplugged]
line = "environment.air"
kind = "rename"
at_s = 0.0
away_s = 100000.0
"""


def test_a_fault_file_is_served_on_ports_with_stable_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, rig = job(tmp_path)
    (tmp_path / "faults.toml").write_text(FAULTS, encoding="utf-8")
    options = ("--pty", "--time-factor", "50", "--faults", str(tmp_path / "faults.toml"))
    with simulated(rig, tmp_path / "ports.toml", *options) as addresses:
        pitch = Path(addresses["axes.pitch"])
        assert pitch.is_symlink()
        outcome = call(capsys, "devices", "--rig", tmp_path / "ports.toml", "--json")
        assert outcome.status == 1
        assert list(outcome.document["troubles"]) == ["environment.air"]
        assert "unplugged" in outcome.document["troubles"]["environment.air"]
        assert set(outcome.document["identities"]) == {"axes.pitch", "axes.roll", "readouts.dmm"}
    assert not pitch.parent.exists()


def test_a_wrong_fault_file_is_refused_before_anything_is_served(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, rig = job(tmp_path)
    (tmp_path / "faults.toml").write_text(FAULTS.replace("air", "oven"), encoding="utf-8")
    outcome = call(capsys, "simulate", rig, "--faults", tmp_path / "faults.toml")
    assert (outcome.status, outcome.out) == (2, "")
    assert "faults.toml:3: fault.unplugged.line: got 'environment.oven', allowed axes.pitch" in outcome.err
