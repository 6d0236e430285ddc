"""What is measured is delivered, whatever the archive can tell of the years before."""

from pathlib import Path

import pytest
from command import call
from job_files import job

from ams.errors import ArchiveError


def test_a_look_at_the_past_that_fails_is_told_and_costs_no_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def locked(*_: object, **__: object) -> None:
        raise ArchiveError("archive: is locked by another program")

    for place in ("deliver", "publish"):
        monkeypatch.setattr(f"procedures.delivery.{place}.history", locked)
    procedure, rig = job(tmp_path)
    ran = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs")
    assert ran.status == 0
    assert "is locked by another program" in ran.out + ran.err
    (run,) = (tmp_path / "runs").glob("*/journal.sqlite")
    assert (run.parent / "report.html").exists()
    assert list((run.parent / "exports").iterdir())
