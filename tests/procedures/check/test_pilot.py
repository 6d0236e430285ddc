"""Laws of ``--pilot``: a run of the same rig says what the next one is expected to show; any other is a sentence."""

from pathlib import Path

import pytest
from command import call
from finished_job import FinishedJob

from procedures.check.check_report import check
from procedures.cli.prepare.pilot import pilot_named
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig


def test_a_pilot_says_noise_lack_of_fit_and_drift_and_is_named(finished_job: FinishedJob) -> None:
    """The twin's noise is 20 µV a reading; 12 dwells of five readings and two replications tell it to a third."""
    rig = read_rig(finished_job.folder / "rig.toml")
    procedure = read_procedure(finished_job.folder / "procedure.toml")
    pilot = pilot_named(str(finished_job.run), Path(), rig)
    assert pilot is not None
    for axis in check(rig, procedure, pilot=pilot).forecast.expected:
        assert axis.noise_source.startswith("run ")
        assert axis.noise_v == pytest.approx(2e-5 / 5**0.5, rel=0.6)
    plain = check(rig, procedure).forecast.expected[0]
    assert "no lack of fit and no drift assumed" in plain.noise_source


def test_a_pilot_of_another_rig_is_a_sentence(finished_job: FinishedJob, tmp_path: Path, capsys) -> None:
    text = (finished_job.folder / "rig.toml").read_text(encoding="utf-8")
    other = tmp_path / "rig.toml"
    other.write_text(text.replace('name = "', 'name = "another ', 1), encoding="utf-8")
    outcome = call(capsys, "check", finished_job.folder / "procedure.toml", "--rig", other, "--pilot", finished_job.run)
    assert outcome.status == 2
    assert "what one rig shows says nothing of another" in outcome.err


def test_a_pilot_tells_of_other_sensors_of_its_type(finished_job: FinishedJob, tmp_path: Path) -> None:
    text = (finished_job.folder / "rig.toml").read_text(encoding="utf-8")
    other = tmp_path / "rig.toml"
    other.write_text(text.replace("SN1047", "SN2000"), encoding="utf-8")
    rig = read_rig(other)
    pilot = pilot_named(str(finished_job.run), Path(), rig)
    found = check(rig, read_procedure(finished_job.folder / "procedure.toml"), pilot=pilot).forecast.expected
    assert {axis.sensor for axis in found} == {"SN2000"}
    assert all("its three-axis" in axis.noise_source for axis in found)
