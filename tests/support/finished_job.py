"""A small but whole job, finished by the command in a process of its own: run, report, sets, exports, archive."""

import json
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from job_files import job

SUMMARY_FILE = "told.json"


@dataclass(frozen=True)
class FinishedJob:
    """Where it lies; many tests read it, so none changes it."""

    folder: Path

    @property
    def summary(self) -> dict[str, Any]:
        """What the command printed as JSON."""
        return dict(json.loads((self.folder / SUMMARY_FILE).read_text(encoding="utf-8")))

    @property
    def run(self) -> Path:
        return Path(self.summary["run"])

    def copied_to(self, folder: Path) -> Path:
        """Copy its runs and their archive; returns the copy of the run's folder, which may be changed."""
        shutil.copytree(self.folder / "runs", folder / "runs")
        return folder / "runs" / self.run.name


def finish_job(folder: Path) -> None:
    """Do the job of :mod:`job_files` in ``folder``."""
    procedure, rig = job(folder)
    arguments = ["run", procedure, "--rig", rig, "--out", str(folder / "runs"), "--json"]
    command = [sys.executable, "-m", "procedures.cli.main", *arguments]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    (folder / SUMMARY_FILE).write_text(done.stdout, encoding="utf-8")
